#include "acus/base/core/delimited_text.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstring>
#include <iconv.h>

#include "acus/base/core/error.h"
#include "acus/base/core/number_text.h"
#include "acus/base/core/words.h"

namespace acus {
namespace {

constexpr std::size_t kLinesLookedAt = 100;  ///< A style shows in the first lines.

std::string Lower(std::string_view text) {
  std::string out(text);
  for (char& c : out) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return out;
}

std::string Utf8FromUtf16(const std::string& bytes, const char* encoding,
                          const std::string& label) {
  const iconv_t converter = iconv_open("UTF-8", encoding);
  ACUS_ASSERT(converter != reinterpret_cast<iconv_t>(-1));
  std::string out(2 * bytes.size(), '\0');  // At most 3 bytes for each 2.
  std::string in = bytes.substr(2);
  char* from = in.data();
  char* to = out.data();
  std::size_t from_left = in.size();
  std::size_t to_left = out.size();
  const std::size_t result = iconv(converter, &from, &from_left, &to, &to_left);
  iconv_close(converter);
  ACUS_REQUIRE(result != static_cast<std::size_t>(-1), label,
               ": begins as UTF-16, but is none at byte ", bytes.size() - from_left,
               "; save it as UTF-8");
  out.resize(out.size() - to_left);
  return out;
}

/// Digits around one comma, as "-0,5" or "1,5e-3".
bool IsDecimalCommaNumber(std::string_view cell) {
  const std::size_t comma = cell.find(',');
  if (comma == cell.npos || comma + 1 >= cell.size()) return false;
  return std::isdigit(static_cast<unsigned char>(cell[comma + 1])) != 0 &&
         NumberInCell(cell, true).has_value();
}

/// The first lines with content, without comments.
std::vector<std::string_view> LinesLookedAt(std::string_view text) {
  std::vector<std::string_view> lines;
  for (std::size_t begin = 0; begin < text.size() && lines.size() < kLinesLookedAt;) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const std::string_view line = text.substr(begin, end - begin);
    begin = end + 1;
    if (!Trimmed(line).empty() && !IsCommentLine(line)) lines.push_back(line);
  }
  return lines;
}

bool AllDecimalCommas(const std::vector<std::string>& cells) {
  return std::ranges::all_of(cells, [](const std::string& cell) {
    return IsDecimalCommaNumber(cell) || ParseNumber<long long>(cell).has_value();
  });
}

/// Lines with numbers in at least two cells.
std::size_t LinesOfNumbers(const std::vector<std::string_view>& lines, char separator) {
  std::vector<std::string> cells;
  std::size_t count = 0;
  for (const std::string_view line : lines) {
    SplitCells(line, separator, cells);
    const auto numbers = std::ranges::count_if(cells, [](const std::string& cell) {
      return NumberInCell(cell, false).has_value() || IsDecimalCommaNumber(cell);
    });
    count += numbers >= 2 ? 1 : 0;
  }
  return count;
}

/// The separator that all lines have in the same number, of a table with few numbers.
char CommonSeparator(const std::vector<std::string_view>& lines) {
  for (const char separator : {'\t', ';', '|'}) {
    const auto count = [&](std::string_view line) { return std::ranges::count(line, separator); };
    const auto is_common = [&](std::string_view line) {
      return count(line) > 0 && count(line) == count(lines.front());
    };
    if (!lines.empty() && std::ranges::all_of(lines, is_common)) return separator;
  }
  return ',';
}

char SeparatorOf(const std::vector<std::string_view>& lines) {
  for (const char separator : {';', '\t', '|'}) {
    const auto has = [&](std::string_view line) { return line.find(separator) != line.npos; };
    if (!std::ranges::any_of(lines, has)) continue;
    const std::size_t here = LinesOfNumbers(lines, separator);
    if (here > 0 && here >= LinesOfNumbers(lines, ',')) return separator;
  }
  const auto has_comma = [](std::string_view line) { return line.find(',') != line.npos; };
  const std::size_t by_blanks = LinesOfNumbers(lines, ' ');
  if (by_blanks == 0) return std::ranges::any_of(lines, has_comma) ? ',' : CommonSeparator(lines);
  if (!std::ranges::any_of(lines, has_comma)) return ' ';
  // "0,0 0,05 0,003": cells between blanks, decimals after commas.
  std::vector<std::string> cells;
  const auto all_fit = [&](std::string_view line) {
    SplitCells(line, ' ', cells);
    return cells.size() < 2 || !NumberInCell(cells[0], true) || AllDecimalCommas(cells);
  };
  const bool with_decimals = std::ranges::all_of(lines, all_fit);
  return with_decimals || by_blanks > LinesOfNumbers(lines, ',') ? ' ' : ',';
}

/// A number that is quoted for its decimal comma, in a line with commas between cells.
bool HasQuotedDecimalComma(std::string_view line) {
  for (std::size_t open = line.find('"'); open != line.npos; open = line.find('"', open + 1)) {
    const std::size_t close = line.find('"', open + 1);
    if (close == line.npos) return false;
    if (IsDecimalCommaNumber(Trimmed(line.substr(open + 1, close - open - 1)))) return true;
    open = close;
  }
  return false;
}

struct Unit {
  std::string_view name;
  char kind;      ///< What it measures.
  double amount;  ///< In s, mm, N.
};

constexpr std::array<Unit, 42> kUnits = {{{"s", 's', 1.0},
                                          {"sec", 's', 1.0},
                                          {"secs", 's', 1.0},
                                          {"second", 's', 1.0},
                                          {"seconds", 's', 1.0},
                                          {"sekunden", 's', 1.0},
                                          {"ms", 's', 1e-3},
                                          {"msec", 's', 1e-3},
                                          {"milliseconds", 's', 1e-3},
                                          {"us", 's', 1e-6},
                                          {"\xC2\xB5s", 's', 1e-6},
                                          {"\xCE\xBCs", 's', 1e-6},
                                          {"microseconds", 's', 1e-6},
                                          {"ns", 's', 1e-9},
                                          {"min", 's', 60.0},
                                          {"mm", 'm', 1.0},
                                          {"millimeter", 'm', 1.0},
                                          {"millimeters", 'm', 1.0},
                                          {"millimetres", 'm', 1.0},
                                          {"cm", 'm', 10.0},
                                          {"m", 'm', 1e3},
                                          {"meter", 'm', 1e3},
                                          {"meters", 'm', 1e3},
                                          {"metres", 'm', 1e3},
                                          {"um", 'm', 1e-3},
                                          {"\xC2\xB5m", 'm', 1e-3},
                                          {"\xCE\xBCm", 'm', 1e-3},
                                          {"in", 'm', 25.4},
                                          {"inch", 'm', 25.4},
                                          {"inches", 'm', 25.4},
                                          {"centimeter", 'm', 10.0},
                                          {"centimeters", 'm', 10.0},
                                          {"centimetres", 'm', 10.0},
                                          {"n", 'n', 1.0},
                                          {"newton", 'n', 1.0},
                                          {"newtons", 'n', 1.0},
                                          {"mn", 'n', 1e-3},
                                          {"kn", 'n', 1e3},
                                          {"cn", 'n', 1e-2},
                                          {"gf", 'n', 9.80665e-3},
                                          {"kgf", 'n', 9.80665},
                                          {"lbf", 'n', 4.4482216152605}}};

const Unit* FindUnit(std::string_view name) {
  const auto found = std::ranges::find(kUnits, name, &Unit::name);
  return found == kUnits.end() ? nullptr : &*found;
}

/// What is in the last brackets of a name, and the name before them.
std::pair<std::string_view, std::string_view> ApartFromBrackets(std::string_view name) {
  for (const char* pair : {"[]", "()", "{}"}) {
    const std::size_t open = name.rfind(pair[0]);
    const std::size_t close = name.rfind(pair[1]);
    if (open == name.npos || close == name.npos || close < open) continue;
    return {name.substr(0, open), Trimmed(name.substr(open + 1, close - open - 1))};
  }
  const std::size_t slash = name.rfind('/');
  if (slash != name.npos && FindUnit(Lower(Trimmed(name.substr(slash + 1)))) != nullptr) {
    return {name.substr(0, slash), Trimmed(name.substr(slash + 1))};
  }
  return {name, {}};
}

void AppendCell(const std::string& cell, std::string& out) {
  const bool is_quoted = cell.find_first_of(",\"") != cell.npos;
  if (is_quoted) out += '"';
  for (const char c : cell) {
    if (c == '"') out += '"';
    out += c;
  }
  if (is_quoted) out += '"';
}

}  // namespace

std::string TableStyle::Text() const {
  std::string text = separator == ','    ? "commas"
                     : separator == ';'  ? "semicolons"
                     : separator == '\t' ? "tabs"
                     : separator == '|'  ? "bars"
                                         : "blanks";
  text += " between cells";
  return has_decimal_comma ? text + ", decimal comma" : text;
}

std::string Utf8Text(std::string bytes, const std::string& label) {
  ACUS_REQUIRE(!bytes.starts_with("\x1F\x8B"), label,
               ": is compressed by gzip; unpack it first (gunzip)");
  if (bytes.starts_with("\xEF\xBB\xBF")) {
    bytes.erase(0, 3);
  } else if (bytes.starts_with("\xFF\xFE")) {
    bytes = Utf8FromUtf16(bytes, "UTF-16LE", label);
  } else if (bytes.starts_with("\xFE\xFF")) {
    bytes = Utf8FromUtf16(bytes, "UTF-16BE", label);
  }
  if (bytes.find('\n') == bytes.npos) std::ranges::replace(bytes, '\r', '\n');
  return bytes;
}

bool IsCommentLine(std::string_view line) {
  const std::string_view text = Trimmed(line);
  return text.starts_with('#') || text.starts_with('%') || text.starts_with("//");
}

TableStyle StyleOf(std::string_view text, const std::string& label) {
  const auto lines = LinesLookedAt(text);
  TableStyle style;
  style.separator = SeparatorOf(lines);
  if (style.separator == ',') {
    style.has_decimal_comma = std::ranges::any_of(lines, HasQuotedDecimalComma);
    return style;
  }
  std::vector<std::string> cells;
  std::string with_point;
  std::string with_comma;
  for (const std::string_view line : lines) {
    SplitCells(line, style.separator, cells);
    for (const std::string& cell : cells) {
      if (with_comma.empty() && IsDecimalCommaNumber(cell)) with_comma = cell;
      const bool has_point = cell.find('.') != cell.npos && NumberInCell(cell, false);
      if (with_point.empty() && has_point) with_point = cell;
    }
  }
  ACUS_REQUIRE(with_comma.empty() || with_point.empty(), label, ": has the numbers '", with_point,
               "' and '", with_comma,
               "': in one of them, either ',' or '.' may stand for "
               "thousands. Write all numbers with a decimal point and without separated thousands");
  style.has_decimal_comma = !with_comma.empty();
  return style;
}

void SplitCells(std::string_view line, char separator, std::vector<std::string>& cells) {
  cells.clear();
  const bool by_blanks = separator == ' ';
  if (by_blanks) line = Trimmed(line);
  std::size_t at = 0;
  do {
    cells.emplace_back();
    std::string& cell = cells.back();
    const std::size_t first =
        line.find_first_not_of(by_blanks || separator == '\t' ? " " : " \t", at);
    if (first != line.npos && line[first] == '"') {
      at = first + 1;
      while (at < line.size()) {
        if (line[at] != '"') {
          cell += line[at++];
        } else if (at + 1 < line.size() && line[at + 1] == '"') {
          cell += '"';
          at += 2;
        } else {
          break;
        }
      }
    }
    const std::size_t end = by_blanks ? line.find_first_of(" \t", at) : line.find(separator, at);
    if (cell.empty()) cell = Trimmed(line.substr(at, end == line.npos ? end : end - at));
    if (cell.starts_with('"') && cell.ends_with('"')) cell.clear();  // "": an empty cell.
    at = end;
    if (at == line.npos) break;
    ++at;
    if (by_blanks) at = std::min(line.find_first_not_of(" \t", at), line.size());
  } while (true);
}

std::optional<double> NumberInCell(std::string_view cell, bool has_decimal_comma) {
  if (cell.size() > 1 && cell.front() == '+' && cell[1] != '-') cell.remove_prefix(1);
  if (!has_decimal_comma) return ParseFinite(cell);
  std::array<char, 64> point{};
  if (cell.size() >= point.size()) return {};
  std::ranges::copy(cell, point.begin());
  const auto comma = std::find(point.begin(), point.begin() + cell.size(), ',');
  if (comma != point.begin() + cell.size()) {
    if (cell.find('.') != cell.npos) return {};
    *comma = '.';
  }
  return ParseFinite({point.data(), cell.size()});
}

bool IsMissingCell(std::string_view cell) {
  if (cell.empty() || cell == "-") return true;
  if (cell.size() > 4) return false;
  const std::string word = Lower(cell);
  return word == "nan" || word == "na" || word == "n/a" || word == "null" || word == "#n/a";
}

ColumnName ParseColumnName(std::string_view name) {
  const auto [before, unit] = ApartFromBrackets(name);
  ColumnName out;
  out.unit = Lower(unit);
  for (const char c : Lower(before)) {
    if (std::isalnum(static_cast<unsigned char>(c)) != 0 || static_cast<unsigned char>(c) >= 128) {
      out.words += c;
    } else if (!out.words.empty() && out.words.back() != '_') {
      out.words += '_';
    }
  }
  while (out.words.ends_with('_')) out.words.pop_back();
  const std::size_t last = out.words.rfind('_');
  if (out.unit.empty() && last != out.words.npos &&
      FindUnit(std::string_view(out.words).substr(last + 1)) != nullptr) {
    out.unit = out.words.substr(last + 1);
    out.words.erase(last);
  }
  return out;
}

std::optional<double> UnitFactor(std::string_view from, std::string_view to) {
  const Unit* a = FindUnit(from);
  const Unit* b = FindUnit(to);
  if (a == nullptr || b == nullptr || a->kind != b->kind) return {};
  return a->amount / b->amount;
}

bool IsUnitCell(std::string_view cell) {
  const auto [before, unit] = ApartFromBrackets(cell);
  const bool in_brackets = !unit.empty() && Trimmed(before).empty();
  const std::string text = Lower(in_brackets ? unit : Trimmed(cell));
  return FindUnit(text) != nullptr || text == "hu" || text == "deg" || text == "rad" ||
         text == "%" || (in_brackets && text.size() <= 8);
}

std::string AsPlainCsv(std::string text, const std::string& label) {
  text = Utf8Text(std::move(text), label);
  const TableStyle style = StyleOf(text, label);
  if (style.IsPlain() && text.find('"') == text.npos) return text;
  std::string out;
  out.reserve(text.size());
  std::vector<std::string> cells;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t newline = text.find('\n', begin);
    const std::size_t end = std::min(newline, text.size());
    const std::string_view line = std::string_view(text).substr(begin, end - begin);
    begin = end + 1;
    if (Trimmed(line).empty() || IsCommentLine(line)) {
      out += line;
    } else {
      SplitCells(line, style.separator, cells);
      for (std::size_t i = 0; i < cells.size(); ++i) {
        if (i > 0) out += ',';
        if (style.has_decimal_comma && IsDecimalCommaNumber(cells[i])) {
          std::ranges::replace(cells[i], ',', '.');
        }
        AppendCell(cells[i], out);
      }
    }
    if (newline != text.npos) out += '\n';
  }
  return out;
}

}  // namespace acus
