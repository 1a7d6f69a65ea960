#include "benchmarks/expression.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numeric>

#include "acus/base/core/error.h"
#include "acus/base/core/text_table.h"
#include "acus/base/core/words.h"

namespace acus::benchmarks {
namespace {

/// Recursive descent; every rule leaves `at_` behind what it has read. A missing measurement is an
/// empty list on the way and NaN in the end.
class Parser {
 public:
  Parser(std::string_view text, const PageData& data) : text_(text), data_(data) {}

  double Whole() {
    const double value = Single(Sum());
    Blanks();
    if (at_ != text_.size()) Fail("cannot be understood");
    return value;
  }

 private:
  using Numbers = std::vector<double>;

  [[noreturn]] void Fail(const std::string& what) const {
    throw InputError(Message("'", text_, "': ", what, " at '", text_.substr(at_), "'"));
  }
  void Blanks() {
    while (at_ < text_.size() && std::isspace(static_cast<unsigned char>(text_[at_]))) ++at_;
  }
  bool Take(char wanted) {
    Blanks();
    if (at_ == text_.size() || text_[at_] != wanted) return false;
    ++at_;
    return true;
  }
  double Single(const Numbers& numbers) const {
    if (numbers.empty()) return kNotMeasured;
    if (numbers.size() > 1) Fail("several numbers: say which, or take min, max or mean,");
    return numbers[0];
  }

  Numbers Sum() {
    Numbers left = Product();
    while (true) {
      const bool plus = Take('+');
      if (!plus && !Take('-')) return left;
      const double right = Single(Product());
      left = {Single(left) + (plus ? right : -right)};
    }
  }
  Numbers Product() {
    Numbers left = Factor();
    while (true) {
      const bool times = Take('*');
      if (!times && !Take('/')) return left;
      const double right = Single(Factor());
      left = {times ? Single(left) * right : Single(left) / right};
    }
  }
  Numbers Factor() {
    if (Take('-')) return {-Single(Factor())};
    if (Take('(')) {
      Numbers inside = Sum();
      if (!Take(')')) Fail("a parenthesis is not closed");
      return inside;
    }
    if (Take('[')) return Selected();
    Blanks();
    if (at_ < text_.size() && std::isalpha(static_cast<unsigned char>(text_[at_]))) {
      return {Function()};
    }
    double number = 0.0;
    const auto result = std::from_chars(text_.data() + at_, text_.data() + text_.size(), number);
    if (result.ec != std::errc()) Fail("a number was expected");
    at_ = static_cast<std::size_t>(result.ptr - text_.data());
    return {number};
  }
  Numbers Selected() {
    const auto end = text_.find(']', at_);
    if (end == text_.npos) Fail("a bracket is not closed");
    const std::string_view selector = text_.substr(at_, end - at_);
    at_ = end + 1;
    return data_.Numbers(selector);
  }
  double Function() {
    const std::size_t begin = at_;
    while (at_ < text_.size() && std::isalpha(static_cast<unsigned char>(text_[at_]))) ++at_;
    const std::string_view name = text_.substr(begin, at_ - begin);
    if (!Take('(')) Fail("a parenthesis was expected");
    Numbers all = Sum();
    bool missing = all.empty();
    while (Take(';')) {
      const Numbers more = Sum();
      missing = missing || more.empty();
      all.insert(all.end(), more.begin(), more.end());
    }
    if (!Take(')')) Fail("a parenthesis is not closed");
    if (missing || std::ranges::any_of(all, [](double x) { return std::isnan(x); })) {
      return kNotMeasured;
    }
    if (name == "min") return std::ranges::min(all);
    if (name == "max") return std::ranges::max(all);
    if (name == "mean") {
      return std::accumulate(all.begin(), all.end(), 0.0) / static_cast<double>(all.size());
    }
    if (name == "log") return std::log(Single(all));
    if (name == "abs") return std::abs(Single(all));
    Fail("no such function; there are: min, max, mean, log, abs,");
  }

  std::string_view text_;
  const PageData& data_;
  std::size_t at_ = 0;
};

/// The place of the next '<' or '>' outside brackets.
std::size_t NextComparison(std::string_view text) {
  int depth = 0;
  for (std::size_t n = 0; n < text.size(); ++n) {
    depth += text[n] == '[';
    depth -= text[n] == ']';
    if (depth == 0 && (text[n] == '<' || text[n] == '>')) return n;
  }
  return text.npos;
}

bool Compared(double left, std::string_view sign, double right) {
  if (sign == "<") return left < right;
  if (sign == "<=") return left <= right;
  if (sign == ">") return left > right;
  return left >= right;
}

}  // namespace

double ValueOf(std::string_view expression, const PageData& data) {
  return Parser(Trimmed(expression), data).Whole();
}

Claim Check(std::string_view claim, const PageData& data) {
  constexpr std::string_view kAnd = " and ";
  if (const auto both = claim.find(kAnd); both != claim.npos) {
    const Claim first = Check(claim.substr(0, both), data);
    const Claim rest = Check(claim.substr(both + kAnd.size()), data);
    Claim out{.holds = std::nullopt, .values = first.values + " and " + rest.values};
    if (first.holds && rest.holds) out.holds = *first.holds && *rest.holds;
    return out;
  }
  std::size_t at = NextComparison(claim);
  ACUS_REQUIRE(at != claim.npos, "'", claim, "' compares nothing: <, <=, > or >= is missing");
  double left = ValueOf(claim.substr(0, at), data);
  Claim out{.holds = std::isnan(left) ? std::nullopt : std::optional(true),
            .values = RoundedText(left, 3)};
  while (at != claim.npos) {
    const std::size_t length = at + 1 < claim.size() && claim[at + 1] == '=' ? 2 : 1;
    const std::string_view sign = claim.substr(at, length);
    claim.remove_prefix(at + length);
    at = NextComparison(claim);
    const double right = ValueOf(claim.substr(0, at), data);
    if (std::isnan(right)) out.holds.reset();
    if (out.holds) out.holds = *out.holds && Compared(left, sign, right);
    out.values += " " + std::string(sign) + " " + RoundedText(right, 3);
    left = right;
  }
  return out;
}

}  // namespace acus::benchmarks
