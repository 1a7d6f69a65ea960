#include "acus/base/report/html_report.h"

#include <array>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "acus/base/core/number_text.h"
#include "acus/base/report/html_parts.h"
#include "acus/base/report/markup.h"

namespace acus::report {
namespace {

/// A relative path as a URL: bytes with a meaning in URLs are percent-encoded.
std::string Url(const std::filesystem::path& path) {
  std::string url;
  for (const char c : path.generic_string()) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                       std::string_view("-._~/").find(c) != std::string_view::npos;
    std::array<char, 4> code{};
    std::snprintf(code.data(), code.size(), "%%%02X", static_cast<unsigned char>(c));
    url += plain ? std::string(1, c) : std::string(code.data());
  }
  return url;
}

std::string Row(const std::vector<std::string>& cells, const char* tag,
                const std::vector<bool>& is_number) {
  std::string row = "<tr>";
  for (std::size_t i = 0; i < cells.size(); ++i) {
    row += Message("<", tag, is_number[i] ? " class=\"n\"" : "", ">", Escaped(cells[i]), "</", tag,
                   ">");
  }
  return row + "</tr>\n";
}

}  // namespace

HtmlReport::HtmlReport(std::string title, std::string subtitle)
    : title_(std::move(title)), subtitle_(std::move(subtitle)) {}

void HtmlReport::Section(const std::string& heading) {
  headings_.push_back(heading);
  body_ += Message("<h2 id=\"s", headings_.size(), "\">", Escaped(heading), "</h2>\n");
}

void HtmlReport::Paragraph(const std::string& text) {
  body_ += Message("<p>", Escaped(text), "</p>\n");
}

void HtmlReport::KeyValues(std::span<const std::pair<std::string, std::string>> rows) {
  body_ += "<dl>\n";
  for (const auto& [key, value] : rows) {
    body_ += Message("<dt>", Escaped(key), "</dt><dd>", Escaped(value), "</dd>\n");
  }
  body_ += "</dl>\n";
}

void HtmlReport::Table(const std::vector<std::string>& header,
                       const std::vector<std::vector<std::string>>& rows,
                       const std::string& caption) {
  std::vector<bool> is_number(header.size(), !rows.empty());
  for (const auto& row : rows) {
    ACUS_ASSERT(row.size() == header.size());
    for (std::size_t i = 0; i < row.size(); ++i) {
      is_number[i] =
          is_number[i] && (row[i].empty() || row[i] == "-" || ParseNumber<double>(row[i]));
    }
  }
  body_ += "<div class=\"scroll\"><table>\n";
  if (!caption.empty()) body_ += Message("<caption>", Escaped(caption), "</caption>\n");
  body_ += "<thead>" + Row(header, "th", is_number) + "</thead>\n<tbody>\n";
  for (const auto& row : rows) body_ += Row(row, "td", is_number);
  body_ += "</tbody></table></div>\n";
}

void HtmlReport::Plots(std::span<const Plot> plots, const std::string& caption) {
  Figure(StackedSvgText(plots), caption);
}

void HtmlReport::Drawing(const std::string& svg, const std::string& caption) {
  Figure(svg, caption);
}

void HtmlReport::Image(const std::filesystem::path& png, const std::string& alt,
                       const std::string& caption) {
  Figure(Message("<img src=\"", PngDataUri(png), "\" alt=\"", Escaped(alt), "\">"), caption);
}

void HtmlReport::Film(const std::filesystem::path& relative_path, const std::string& caption) {
  ACUS_ASSERT(relative_path.is_relative());
  const std::string url = Url(relative_path);
  Figure(Message("<video controls preload=\"metadata\" src=\"", url, "\" aria-label=\"",
                 Escaped(caption.empty() ? "film" : caption), "\"><a href=\"", url, "\">",
                 Escaped(relative_path.string()), "</a></video>"),
         caption);
}

void HtmlReport::Figure(const std::string& content, const std::string& caption) {
  body_ += "<figure>\n" + content;
  if (!caption.empty()) body_ += Message("<figcaption>", Escaped(caption), "</figcaption>");
  body_ += "</figure>\n";
}

void HtmlReport::Warnings(std::span<const std::string> texts) {
  for (const std::string& text : texts) warnings_ += Message("<li>", Escaped(text), "</li>\n");
}

void HtmlReport::SetProvenance(const nlohmann::json& provenance) {
  constexpr auto kReplace = nlohmann::json::error_handler_t::replace;  // A path may not be UTF-8.
  provenance_ = provenance.dump(2, ' ', false, kReplace);
}

std::string HtmlReport::Text() const {
  std::string text = Message(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>",
      Escaped(title_), "</title>\n<style>", StyleSheet(),
      "</style>\n</head>\n<body>\n<header>\n<h1>", Escaped(title_), "</h1>\n");
  if (!subtitle_.empty()) text += Message("<p class=\"subtitle\">", Escaped(subtitle_), "</p>\n");
  text += "</header>\n";
  if (!warnings_.empty()) {
    text += "<aside class=\"warnings\" role=\"note\"><strong>Please note</strong>\n<ul>\n" +
            warnings_ + "</ul></aside>\n";
  }
  if (headings_.size() > 1) {
    text += "<nav aria-label=\"Contents\"><ul>\n";
    for (std::size_t i = 0; i < headings_.size(); ++i) {
      text += Message("<li><a href=\"#s", i + 1, "\">", Escaped(headings_[i]), "</a></li>\n");
    }
    text += "</ul></nav>\n";
  }
  text += "<main>\n" + body_ + "</main>\n";
  if (!provenance_.empty()) {
    text += Message("<footer>\n<h2 id=\"provenance\">Provenance</h2>\n<pre>", Escaped(provenance_),
                    "</pre>\n</footer>\n");
  }
  return text + Message("<script>", kReadingScript, "</script>\n</body>\n</html>\n");
}

void HtmlReport::Write(const std::filesystem::path& path) const {
  WriteTextFile(path, Text());
}

}  // namespace acus::report
