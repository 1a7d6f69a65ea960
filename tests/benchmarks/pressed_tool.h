// Tools pressed into a body by a known amount: the force and torque that infinitely many proxies
// would feel, to hold a few against.
#pragma once

#include <Eigen/Geometry>
#include <string_view>

#include "acus/physics/forces/models/model_settings.h"
#include "acus/physics/forces/probe/palpation_tool.h"

namespace acus::benchmarks {

/// A tool, how it is held, and what it is pressed into. The body is below z = 0 (its skin the plane
/// z = 0, or for the round one a cylinder along y that touches it from below); z is up.
struct PressedTool {
  enum class Kind {
    kFlat,       ///< The face of a probe, 40 x 12 mm, square to a plane.
    kTilted,     ///< The same, leaning by kTiltRad about its short side.
    kRound,      ///< The same, square to a cylinder of kRoundMm that bends away along the face.
    kFingertip,  ///< A hemisphere of kFingertipMm, square to a plane.
  };
  static constexpr double kFaceMm = 40.0;
  static constexpr double kFaceWidthMm = 12.0;
  static constexpr double kTiltRad = 0.2;
  static constexpr double kRoundMm = 120.0;
  static constexpr double kFingertipMm = 8.0;
  Kind kind = Kind::kFlat;

  std::string_view name() const;

  /// @throws InputError unless 1 <= num_nodes <= PalpationTool::kMostNodes.
  forces::PalpationTool Nodes(int num_nodes) const;

  /// Tool frame: x along the face, +y into the body.
  /// @param depth_mm  Of the middle of the face (foremost point of the fingertip) in the skin.
  /// @param aside_mm  Along the body's y, in which it does not change.
  Eigen::Isometry3d BodyFromTool(double depth_mm, double aside_mm) const;

  /// How deep a place is in the body, mm; negative outside.
  double DepthMm(const Eigen::Vector3d& in_body_mm) const;
  /// Out of the body, unit.
  Eigen::Vector3d NormalAt(const Eigen::Vector3d& in_body_mm) const;

  struct Load {
    Eigen::Vector3d force_n = Eigen::Vector3d::Zero();      ///< On the tool, in the body's axes.
    Eigen::Vector3d torque_n_mm = Eigen::Vector3d::Zero();  ///< About the tool's origin.
  };
  /// The mean over the tool's surface of a1 d + a2 d^2 along the normal, by a fine quadrature;
  /// without friction.
  Load Exact(const forces::MultiProxySettings::Repulsion& law,
             const Eigen::Isometry3d& body_from_tool) const;
};

}  // namespace acus::benchmarks
