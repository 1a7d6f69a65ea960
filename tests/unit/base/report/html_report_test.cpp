#include "acus/base/report/html_report.h"

#include <filesystem>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>
#include <regex>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "acus/base/report/markup.h"
#include "support/temporary_folder.h"

namespace acus::report {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using testing::ThrowsMessage;

/// Removed when the tests end.
std::filesystem::path Scratch() {
  static const testing_support::TemporaryFolder folder;
  return folder.path();
}

std::filesystem::path Temporary(const char* name) {
  return Scratch() / name;
}

HtmlReport FullReport() {
  HtmlReport report("Replay <1>", "lumbar & 22G");
  report.Warnings(std::vector<std::string>{"probe left the skin", "a < b"});
  report.Section("Forces");
  report.Paragraph("Peak 1.5 N at \"puncture\"");
  report.KeyValues(std::vector<std::pair<std::string, std::string>>{{"duration", "30 s"}});
  report.Table({"name", "value"}, {{"path", "12.5"}, {"time", "-3"}}, "Metrics");
  Plot plot;
  plot.title = "Force";
  plot.series.push_back({.name = "axial", .x = {0, 1}, .y = {0, 2}});
  report.Plots(std::span(&plot, 1), "Over time");
  report.Section("Images");
  const auto png = Temporary("tiny.png");
  WriteTextFile(png, std::string_view("\x89PNG\r\n\x1A\nrest", 12));
  report.Image(png, "a slice", "Slice");
  report.Film("my film#1.mp4", "All frames");
  report.SetProvenance({{"program", "acus-replay"}, {"path", "bad \xFF byte"}});
  return report;
}

TEST(HtmlReport, HoldsEverythingAndNeedsNoNetwork) {
  const std::string html = FullReport().Text();
  EXPECT_THAT(html, HasSubstr("<h1>Replay &lt;1&gt;</h1>"));
  EXPECT_THAT(html, HasSubstr("<li>a &lt; b</li>"));
  EXPECT_THAT(html, HasSubstr("<a href=\"#s2\">Images</a>"));
  EXPECT_THAT(html, HasSubstr("<h2 id=\"s2\">Images</h2>"));
  EXPECT_THAT(html, HasSubstr("<td class=\"n\">12.5</td>"));
  EXPECT_THAT(html, HasSubstr("<td>path</td>"));
  EXPECT_THAT(html, HasSubstr("src=\"my%20film%231.mp4\""));
  EXPECT_THAT(html, HasSubstr("alt=\"a slice\""));
  EXPECT_THAT(html, HasSubstr("acus-replay"));
  // The name space of SVG is the only address in it.
  EXPECT_EQ(std::regex_replace(html, std::regex("http://www.w3.org/2000/svg"), "").find("http"),
            std::string::npos);
  EXPECT_THAT(html, Not(HasSubstr("<link")));
}

TEST(HtmlReport, EveryElementThatIsOpenedIsClosed) {
  std::string html = FullReport().Text();
  html = std::regex_replace(html, std::regex("<(script|style)>[^]*?</\\1>"), "");
  std::vector<std::string> open;
  const std::regex tag("<(/?)([a-z0-9]+)([^<>]*)>");
  for (std::sregex_iterator it(html.begin(), html.end(), tag), end; it != end; ++it) {
    const std::string name = (*it)[2];
    const std::string rest = (*it)[3];
    if (rest.ends_with("/") || name == "meta" || name == "img") continue;
    if ((*it)[1].length() == 0) {
      open.push_back(name);
    } else {
      ASSERT_FALSE(open.empty());
      ASSERT_EQ(open.back(), name);
      open.pop_back();
    }
  }
  EXPECT_THAT(open, testing::IsEmpty());
}

TEST(PngDataUri, EncodesAsRfc4648) {
  // RFC 4648, section 10: "" f fo foo ... -> Zg== Zm8= Zm9v, here behind the PNG signature
  // of eight bytes, of which "\r\n\x1A\n" + one letter ends a group of three.
  const auto path = Temporary("rfc.png");
  const auto encoded = [&](const std::string& rest) {
    WriteTextFile(path, "\x89PNG\r\n\x1A\n" + rest);
    return PngDataUri(path);
  };
  EXPECT_THAT(encoded("?"), testing::EndsWith(",iVBORw0KGgo/"));
  EXPECT_THAT(encoded("?foobar"), testing::EndsWith("/Zm9vYmFy"));
  EXPECT_THAT(encoded("?foob"), testing::EndsWith("/Zm9vYg=="));
  EXPECT_THAT(encoded("?fooba"), testing::EndsWith("/Zm9vYmE="));
}

TEST(PngDataUri, RefusesWhatIsNoPng) {
  const auto path = Temporary("not.png");
  WriteTextFile(path, "GIF89a");
  EXPECT_THAT([&] { PngDataUri(path); },
              ThrowsMessage<InputError>(AllOf(HasSubstr("not.png"), HasSubstr("not a PNG"))));
  EXPECT_THAT([&] { PngDataUri(Temporary("none.png")); },
              ThrowsMessage<InputError>(HasSubstr("no such file")));
}

TEST(Escaped, ReplacesWhatIsNotUtf8) {
  EXPECT_EQ(Escaped("a\xC3\xA9\xE2\x82\xAC\xF0\x9F\x98\x80"),
            "a\xC3\xA9\xE2\x82\xAC\xF0\x9F\x98\x80");
  EXPECT_EQ(Escaped("\xC3"), "\uFFFD");                      // Cut off.
  EXPECT_EQ(Escaped("\xC0\x80"), "\uFFFD\uFFFD");            // Overlong.
  EXPECT_EQ(Escaped("\xED\xA0\x80"), "\uFFFD\uFFFD\uFFFD");  // Surrogate.
  EXPECT_EQ(Escaped(std::string_view("a\0b", 3)), "a b");
}

}  // namespace
}  // namespace acus::report
