// The axis of a plot: range, ticks at 1-2-5 steps, labels, and the way from values to pixels.
#pragma once

#include <string>
#include <vector>

namespace acus::report {

struct Tick {
  double value;
  std::string label;  ///< Empty for a minor tick.
};

/// Smallest and largest of the values seen.
struct Extent {
  double low = 0.0;
  double high = 0.0;
  bool empty = true;

  void Add(double value);
  void Add(const std::vector<double>& values);
};

/// Made once for an extent; maps values to [0, 1] along the axis.
class Axis {
 public:
  /// @param padding     Free space at both ends as a fraction of the range; none beyond a 0 that
  ///     ends the range if `sits_on_zero`.
  /// @param max_labels  At most so many labels.
  /// @pre Values are finite; positive if `is_log`. An empty extent gives [0, 1]
  ///     ([1, 10] if is_log).
  Axis(const Extent& extent, bool is_log, double padding, int max_labels,
       bool sits_on_zero = false);

  double low() const;
  double high() const;
  bool is_log() const { return is_log_; }

  /// 0 at low(), 1 at high().
  double Fraction(double value) const;

  const std::vector<Tick>& ticks() const { return ticks_; }

  /// Labels are to be multiplied by 10^exponent(); a multiple of 3, 0 for plain labels.
  int exponent() const { return exponent_; }

 private:
  double Scaled(double value) const;
  double Unscaled(double scaled) const;
  void MakeLinearTicks(int max_labels);
  void MakeLogTicks(int max_labels);

  bool is_log_;
  int exponent_ = 0;
  double low_scaled_ = 0.0;  ///< Value / 10^exponent, or log10(value).
  double high_scaled_ = 1.0;
  std::vector<Tick> ticks_;
};

/// "10⁻³": ten to the power of `exponent`, with superscript digits.
std::string PowerOfTenText(int exponent);

/// A decimal text with `decimals` digits after the point and a true minus sign.
std::string DecimalText(double value, int decimals);

}  // namespace acus::report
