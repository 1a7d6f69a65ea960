// Transmissions of an array: when each element fires, and when the wave is where.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "acus/imaging/rf/array.h"

namespace acus::rf {

/// A plane wave, or a wave that converges on a focus.
struct Transmit {
  double angle_rad = 0.0;  ///< Plane wave: between its direction and depth; positive towards +x.
  std::optional<Eigen::Vector2d> focus_mm = {};  ///< In the plane of the probe; then no angle.
};

/// The times of one transmission of one array. The first element fires at 0.
class TransmitTiming {
 public:
  /// @throws InputError if the focus is not in front of the face, or a number is not finite.
  TransmitTiming(const Array& array, const Transmit& transmit, double sound_speed_mm_per_us);

  const std::vector<double>& element_us() const { return element_us_; }  ///< Of each element.

  /// When the wave front passes a place, by geometry. Focused: the spherical wave towards the focus
  /// and from it (the virtual source of Bae & Jeong, IEEE TUFFC 47(6), 2000).
  double ArrivalUs(const Eigen::Vector2d& place_mm) const;

 private:
  Transmit transmit_;
  Eigen::Vector2d direction_;  ///< Of the plane wave, or from the middle of the face to the focus.
  double sound_speed_mm_per_us_;
  double offset_us_ = 0.0;  ///< Plane: of the origin. Focused: of the focus.
  std::vector<double> element_us_;
};

}  // namespace acus::rf
