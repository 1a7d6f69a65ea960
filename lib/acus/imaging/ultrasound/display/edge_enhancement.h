// Edge enhancement: detail along the lines, added to the greys.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace acus::ultrasound {

/// out = in + strength * (in - in blurred by a Gaussian along the line), cut off to 0 ... 255. A
/// pattern with the wave number q along the line is raised by
///   1 + strength * (1 - exp(-(q sigma)^2 / 2)),
/// and a step of height h overshoots by strength * h / 2 on either side.
class EdgeEnhancement {
 public:
  /// @param strength  0: off. @param sigma_mm  Of the Gaussian. @param step_mm  From row to row.
  /// @throws InputError if one is negative or not finite, or the Gaussian covers too many rows.
  EdgeEnhancement(double strength, double sigma_mm, double step_mm);

  bool on() const { return !weight_.empty(); }

  /// Row `k` of `rows` rows, each `stride` bytes after the one before; the first and the last row
  /// continue outside.
  void EnhanceRow(const std::uint8_t* grey, std::ptrdiff_t stride, int rows, int k, int lanes,
                  std::uint8_t* out) const;

 private:
  std::vector<int> weight_;  ///< Half of the window with its middle, in 2^-14 of strength.
  int gain_ = 0;             ///< Of the middle, in the same unit.
};

}  // namespace acus::ultrasound
