// Straight rays from the elements of an aperture to every place of the image.
#pragma once

#include <vector>

#include "acus/imaging/acoustics/probe.h"

namespace acus::ultrasound {

/// Directions of rays at the probe's face, and where each has come to at a depth. All rays of one
/// direction are copies of each other, shifted along the face: at row k, ray r of direction d is on
/// line r + ShiftLines(d, k), in lines. A place is reached by the rays whose elements belong to the
/// aperture that the F-number gives at its depth, weighted by a cosine apodisation.
///
/// A phased probe has the middle one only: see SteeredRays.
class ApertureRays {
 public:
  /// @param grid  Rows at which rays are required; keeps nothing of it. @pre directions is odd.
  ApertureRays(const acoustics::Probe& probe, const acoustics::ScanGrid& grid, int directions);

  int directions() const { return static_cast<int>(tan_at_face_.size()); }
  /// Tangent of the angle between a direction and the scan line, at the face.
  double TanAtFace(int direction) const {
    return tan_at_face_[static_cast<std::size_t>(direction)];
  }
  float ShiftLines(int direction, int row) const { return shift_[At(direction, row)]; }
  /// Share of the aperture's amplitude: the sum over directions is 1 at every row.
  float Weight(int direction, int row) const { return weight_[At(direction, row)]; }
  /// The last row that takes part of a direction.
  int LastRow(int direction) const { return last_row_[static_cast<std::size_t>(direction)]; }
  /// The largest shift of all, in lines.
  float MostLines() const { return most_lines_; }

 private:
  std::size_t At(int direction, int row) const {
    return static_cast<std::size_t>(direction) * static_cast<std::size_t>(rows_) +
           static_cast<std::size_t>(row);
  }

  int rows_;
  std::vector<double> tan_at_face_;
  std::vector<float> shift_;
  std::vector<float> weight_;
  std::vector<int> last_row_;
  float most_lines_ = 0.0F;
};

}  // namespace acus::ultrasound
