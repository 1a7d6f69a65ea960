// How far a registration may be from the truth, at every place.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "acus/patient/breathing_registration/sliding_grid.h"

namespace acus::breathing_registration {

/// What a bound is made of, for each node of the finest grid.
struct Solution {
  SlidingGrid::Field displacement_voxels;
  SlidingGrid::Field coarser_voxels;  ///< What the next coarser grid had found there.
  std::vector<std::uint8_t> is_seen;  ///< 0: its match left the volume, or is tissue that came in.
  std::vector<float> wall_mm;         ///< Distance to the wall along which tissue slides.
};

/// A bound on the length of a registration's error that holds at 95 of 100 places. With the strain
/// S of the solution, the distance D between what this grid and the next coarser one
/// found, the strain S' of the whole phase and the distance w to the wall,
///
///   bound^2 = (4.5 mm S)^2 + (0.62 D)^2 + (10 mm S' exp(-w / 8 mm))^2 + (L S)^2 + (0.05 mm)^2
///
/// S and D are root mean squares over some nodes of the same side. L is 0 where images show a
/// match; otherwise the width of the smallest cube about the place that is seen in part: so far the
/// solution is only extrapolated. Factors are calibrated on two CTs: see
/// docs/models/breathing_registration.md. A value; const access from any number of threads.
class ErrorBound {
 public:
  ErrorBound() = default;
  /// @pre the vectors of `solution` have one value for each node.
  ErrorBound(const SlidingGrid& grid, const Solution& solution, int num_threads);

  /// @param at  In voxels of the grid. @returns mm; 0 without tissue of that side.
  double Mm(const Eigen::Vector3f& at, Side side) const noexcept;
  /// Images show no match here: the solution is extrapolated from its surroundings.
  bool IsUnseen(const Eigen::Vector3f& at, Side side) const noexcept;
  /// Share of all tissue for which IsUnseen() holds.
  double unseen_share() const { return unseen_share_; }

 private:
  struct Cube {
    float mm = 0.0F;  ///< 0: no tissue.
    float unseen_share = 0.0F;
  };
  Cube At(const Eigen::Vector3f& at, Side side) const noexcept;

  double unseen_share_ = 0.0;
  Eigen::Array3i size_ = Eigen::Array3i::Zero();  ///< In cubes of two nodes.
  std::array<std::vector<Cube>, 2> cubes_;        ///< Wall, cavity.
};

}  // namespace acus::breathing_registration
