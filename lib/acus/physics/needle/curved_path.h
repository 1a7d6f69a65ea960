// The channel that a bendable needle has cut: nodes along a curve in the tissue at rest.
//
// Fortmeier-2016, section 2.3: nodes about `spacing_mm` apart that stay where they are, except for
// the last one, which is the tip. It moves forward in a direction that the caller gives (of the
// needle's tip), and back towards the node before it. A node is put in when the tip is over 1.5
// spacings from the one before it, and taken out when it is nearer than half a spacing.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

namespace acus::needle {

struct PathNode {
  Eigen::Vector3d position_mm = Eigen::Vector3d::Zero();
  double depth_mm = 0.0;             ///< Along the channel, from the skin.
  double stiffness_n_per_mm2 = 0.0;  ///< Of the tissue here, across the channel, per mm of it.
  double support_n_per_mm = 0.0;     ///< The same, summed from the skin to here.
  std::uint8_t tissue = 0;           ///< The caller's label.
};

/// A plain value of fixed size: copies do not allocate. With all kMaxNodes in use, the last piece
/// grows longer instead of being divided.
struct CurvedPath {
  static constexpr int kMaxNodes = 512;

  double spacing_mm = 1.0;  ///< > 0
  int num_nodes = 0;        ///< 0: outside the body. 1: the tip is on the skin.
  std::array<PathNode, kMaxNodes> node{};

  /// Support one spacing beyond the last node but one, once the tip has passed there.
  double support_at_spacing_n_per_mm = 0.0;

  bool empty() const noexcept { return num_nodes == 0; }
  const PathNode& entry() const noexcept { return node[0]; }  ///< @pre not empty
  const PathNode& tip() const noexcept { return node[num_nodes - 1]; }
  double LengthMm() const noexcept { return empty() ? 0.0 : tip().depth_mm; }

  /// Begins a path at the skin.
  void Begin(const PathNode& at) noexcept;

  /// Moves the tip by `distance_mm` > 0 along `direction` (any length > 0); what is cut gets the
  /// tissue and stiffness of `tissue`, as does the tip. @pre not empty
  void Advance(const Eigen::Vector3d& direction, double distance_mm,
               const PathNode& tissue) noexcept;

  /// Moves the tip back along the channel by `distance_mm`; at the skin the path ends, empty.
  void Retract(double distance_mm) noexcept;

  /// Place and unit direction at this depth; beyond the ends, those of the first or last piece.
  /// @pre not empty; the direction of a path of one node is `fallback`.
  Eigen::Vector3d PositionMm(double depth_mm) const noexcept;
  Eigen::Vector3d Direction(
      double depth_mm, const Eigen::Vector3d& fallback = Eigen::Vector3d::UnitZ()) const noexcept;
  /// Stiffness across the channel of all tissue from the skin to this depth.
  double SupportNPerMm(double depth_mm) const noexcept;

 private:
  int PieceAt(double depth_mm) const noexcept;
  void StepForward(const Eigen::Vector3d& unit, double step_mm, const PathNode& tissue) noexcept;
};

/// A bevel tip is deflected by the tissue it cuts: the path bends with a constant
/// curvature towards the side that the bevel leaves (the unicycle model of Webster et al. 2006).
struct BevelTip {
  double curvature_per_mm = 0.0;
  double roll_rad = 0.0;  ///< From the rod frame's +x about +z to where the path bends.

  /// Heading at the end of an advance, and the direction of the chord to there. `tip_x` and `tip_y`
  /// are the axes of the needle's tip.
  struct Heading {
    Eigen::Vector3d end = Eigen::Vector3d::UnitZ();
    Eigen::Vector3d chord = Eigen::Vector3d::UnitZ();
  };
  Heading After(double distance_mm, const Eigen::Vector3d& heading, const Eigen::Vector3d& tip_x,
                const Eigen::Vector3d& tip_y) const noexcept;
};

}  // namespace acus::needle
