#include "acus/base/report/axis.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>

namespace acus::report {
namespace {

constexpr std::string_view kMinus = "\u2212";

/// Values smaller than this are zero to a plot; keeps 10^exponent clear of overflow.
constexpr double kSmallest = 1e-280;

/// A range narrower than this part of its values has no digits left to show: it is a constant.
constexpr double kNarrowest = 1e-12;

/// The smallest of 1, 2, 5 x 10^k that is at least `step`.
double NiceStep(double step) {
  const double decade = std::pow(10.0, std::floor(std::log10(step)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * decade >= step * (1.0 - 1e-9)) return factor * decade;
  }
  return 10.0 * decade;
}

/// Widens [low, high] where there is nothing between its ends.
void WidenConstant(double& low, double& high) {
  const double size = std::max(std::abs(low), std::abs(high));
  if (high - low > kNarrowest * size && high > low) return;
  const double middle = low + 0.5 * (high - low);
  const double half = size > 0.0 ? 0.1 * size : 1.0;
  low = middle - half;
  high = middle + half;
}

}  // namespace

void Extent::Add(double value) {
  low = empty ? value : std::min(low, value);
  high = empty ? value : std::max(high, value);
  empty = false;
}

void Extent::Add(const std::vector<double>& values) {
  for (const double value : values) Add(value);
}

Axis::Axis(const Extent& extent, bool is_log, double padding, int max_labels, bool sits_on_zero)
    : is_log_(is_log) {
  max_labels = std::max(max_labels, 2);
  if (is_log_) {
    low_scaled_ = extent.empty ? 0.0 : std::log10(extent.low);
    high_scaled_ = extent.empty ? 1.0 : std::log10(extent.high);
    if (high_scaled_ - low_scaled_ < 1e-9) {
      low_scaled_ -= 0.5;
      high_scaled_ += 0.5;
    }
  } else if (!extent.empty) {
    const double size = std::max(std::abs(extent.low), std::abs(extent.high));
    if (size >= 1e5 || (size < 1e-2 && size > kSmallest)) {
      exponent_ = 3 * static_cast<int>(std::floor(std::log10(size) / 3.0));
    }
    low_scaled_ = size > kSmallest ? Scaled(extent.low) : 0.0;
    high_scaled_ = size > kSmallest ? Scaled(extent.high) : 0.0;
    WidenConstant(low_scaled_, high_scaled_);
  }
  const double room = padding * (high_scaled_ - low_scaled_);
  if (!sits_on_zero || is_log_ || low_scaled_ != 0.0) low_scaled_ -= room;
  if (!sits_on_zero || is_log_ || high_scaled_ != 0.0) high_scaled_ += room;
  is_log_ ? MakeLogTicks(max_labels) : MakeLinearTicks(max_labels);
}

double Axis::Scaled(double value) const {
  return is_log_ ? std::log10(value) : value / std::pow(10.0, exponent_);
}

double Axis::Unscaled(double scaled) const {
  const double value = is_log_ ? std::pow(10.0, scaled) : scaled * std::pow(10.0, exponent_);
  constexpr double kLargest = std::numeric_limits<double>::max();
  return std::clamp(value, -kLargest, kLargest);
}

double Axis::low() const {
  return Unscaled(low_scaled_);
}

double Axis::high() const {
  return Unscaled(high_scaled_);
}

double Axis::Fraction(double value) const {
  return (Scaled(value) - low_scaled_) / (high_scaled_ - low_scaled_);
}

void Axis::MakeLinearTicks(int max_labels) {
  const double step = NiceStep((high_scaled_ - low_scaled_) / max_labels);
  const int decimals = std::max(0, -static_cast<int>(std::floor(std::log10(step) + 1e-9)));
  const double first = std::ceil(low_scaled_ / step - 1e-9);
  const int count = static_cast<int>(std::floor(high_scaled_ / step + 1e-9) - first) + 1;
  for (int i = 0; i < count; ++i) {
    const double scaled = (first + i) * step;
    ticks_.push_back({Unscaled(scaled), DecimalText(scaled, decimals)});
  }
}

void Axis::MakeLogTicks(int max_labels) {
  const double decades = high_scaled_ - low_scaled_;
  const int stride = std::max(1, static_cast<int>(std::ceil(decades / max_labels)));
  const bool label_all = decades < 0.7;  // Then hardly a power of ten is in sight.
  const bool label_some = decades < 2.0;
  for (int k = static_cast<int>(std::floor(low_scaled_)); k <= std::floor(high_scaled_); ++k) {
    for (int digit = 1; digit <= (stride > 1 ? 1 : 9); ++digit) {
      const double at = k + std::log10(digit);
      if (at < low_scaled_ - 1e-9 || at > high_scaled_ + 1e-9) continue;
      const bool some = digit == 2 || digit == 5;
      std::string label;
      if (digit == 1 && k % stride == 0) label = PowerOfTenText(k);
      if (digit > 1 && (label_all || (label_some && some))) {
        label = std::abs(k) <= 2 ? DecimalText(digit * std::pow(10.0, k), std::max(0, -k))
                                 : DecimalText(digit, 0) + "\u00D7" + PowerOfTenText(k);
      }
      if (stride > 1 && label.empty()) continue;
      ticks_.push_back({Unscaled(at), label});
    }
  }
}

std::string PowerOfTenText(int exponent) {
  static constexpr std::array<std::string_view, 10> kDigits = {
      "\u2070", "\u00B9", "\u00B2", "\u00B3", "\u2074",
      "\u2075", "\u2076", "\u2077", "\u2078", "\u2079"};
  if (exponent == 0) return "1";
  if (exponent == 1) return "10";
  std::string text = exponent < 0 ? "10\u207B" : "10";
  for (const char digit : std::to_string(std::abs(exponent))) {
    text += kDigits[static_cast<std::size_t>(digit - '0')];
  }
  return text;
}

std::string DecimalText(double value, int decimals) {
  std::array<char, 400> digits{};
  const auto [end, error] = std::to_chars(digits.data(), digits.data() + digits.size(),
                                          std::abs(value), std::chars_format::fixed, decimals);
  std::string text(digits.data(), end);
  const bool is_zero = text.find_first_not_of("0.") == text.npos;
  return value < 0.0 && !is_zero ? std::string(kMinus) + text : text;
}

}  // namespace acus::report
