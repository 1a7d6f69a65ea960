// Clutter: haze of the echoes around a place, which fills shadows.
#pragma once

#include <vector>

namespace acus::ultrasound {

/// Intensity averaged over a sixth of the lines and carried down with a decay, row by row.
class ClutterHaze {
 public:
  /// @param lines, lanes  Of the image; lanes are lines, rounded up for the kernels.
  /// @param row_mm  From row to row. @param reach_mm  Decay. @param haze_db  Amplitude that comes
  ///     back, relative to the echoes around.
  ClutterHaze(int lines, int lanes, double row_mm, double reach_mm, double haze_db);

  /// Before the first row.
  void Begin();
  /// @param bright  Intensity of interfaces on the row, by line.
  /// @param speckle  Intensity of scatterers; out: the amplitude of both and of the haze.
  void AddRow(const float* bright, float* speckle);

 private:
  void Blur();

  int lines_;
  int lanes_;
  float keep_;   ///< From row to row.
  float share_;  ///< Of intensity.
  std::vector<float> haze_;
  std::vector<float> sums_;  ///< Running sums over the lines.
};

}  // namespace acus::ultrasound
