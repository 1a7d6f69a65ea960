#include "benchmarks/page_template.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "acus/base/core/error.h"
#include "acus/base/core/text_table.h"
#include "acus/base/core/words.h"
#include "benchmarks/expression.h"
#include "benchmarks/measured_tables.h"

namespace acus::benchmarks {
namespace {

class Filler {
 public:
  Filler(const PageData& data, Claims claims) : data_(data), strict_(claims == Claims::kMustHold) {}

  Page Fill(std::string_view text) {
    Page page;
    std::size_t at = 0;
    while (true) {
      const auto open = text.find("{{", at);
      page.text += text.substr(at, open - at);
      if (open == text.npos) break;
      const auto line = 1 + std::ranges::count(text.substr(0, open), '\n');
      const auto close = text.find("}}", open);
      if (close == text.npos) {
        problems_.push_back(Message("line ", line, ": {{ without }}"));
        break;
      }
      std::string filled;
      try {
        filled = Directive(Trimmed(text.substr(open + 2, close - open - 2)), page);
      } catch (const InputError& error) {
        problems_.push_back(Message("line ", line, ": ", error.what()));
      }
      at = close + 2;
      const bool whole_line =
          (page.text.empty() || page.text.back() == '\n') && at < text.size() && text[at] == '\n';
      if (whole_line && (filled.empty() || filled.back() == '\n')) ++at;
      page.text += filled;
    }
    if (!problems_.empty()) throw InputError(Joined(problems_, "\n"));
    return page;
  }

 private:
  std::string Directive(std::string_view text, Page& page) const {
    const auto word_end = text.find_first_of(" \n");
    ACUS_REQUIRE(word_end != text.npos, "'{{", text, "}}' asks for nothing");
    const std::string_view word = text.substr(0, word_end);
    const std::string_view rest = Trimmed(text.substr(word_end));
    if (word == "=") return Number(rest);
    if (word == "text") return data_.Text(rest);
    if (word == "require") return Require(rest);
    if (word == "table") return SettingsTable(rest, data_);
    if (word == "pivot") return ValuesTable(rest, data_);
    ACUS_REQUIRE(word == "figure", "'", word,
                 "' is unknown; there are: =, text, require, table, pivot, figure");
    const auto name_end = rest.find('\n');
    ACUS_REQUIRE(name_end != rest.npos, "a figure needs lines that say what it shows");
    const std::string name(Trimmed(rest.substr(0, name_end)));
    const std::string_view asked = rest.substr(name_end);
    page.figures[name] = FigureSvg(asked, data_);
    std::string title = name;
    for (const AskedLine& line : AskedLines(asked, "sweep title x y line points linear")) {
      if (line.key == "title") title = line.name;
    }
    return "![" + title + "](figures/" + name + ".svg)";
  }

  std::string Number(std::string_view text) const {
    int digits = 2;
    if (const auto colon = text.rfind(" : "); colon != text.npos) {
      const std::string_view count = Trimmed(text.substr(colon + 3));
      const auto result = std::from_chars(count.data(), count.data() + count.size(), digits);
      ACUS_REQUIRE(result.ec == std::errc() && digits > 0, "'", count, "' is no number of digits");
      text = text.substr(0, colon);
    }
    const double value = ValueOf(text, data_);
    if (std::isfinite(value)) return RoundedText(value, digits);
    ACUS_REQUIRE(!strict_, "'", text, "' was not measured");
    return "–";
  }

  std::string Require(std::string_view text) const {
    const Claim claim = Check(text, data_);
    if (claim.holds.value_or(false)) return {};
    const std::string why =
        claim.holds ? "not so in this run: " + claim.values : "not measured in this run";
    ACUS_REQUIRE(!strict_, "what the text says no longer holds, '", text, "': ", why);
    return " **(" + why + ")** ";
  }

  const PageData& data_;
  bool strict_;
  std::vector<std::string> problems_;
};

}  // namespace

Page MakePage(std::string_view text, const PageData& data, Claims claims) {
  return Filler(data, claims).Fill(text);
}

}  // namespace acus::benchmarks
