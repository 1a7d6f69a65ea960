#include "benchmarks/pressed_tool.h"

#include <cmath>
#include <numbers>

namespace acus::benchmarks {
namespace {

using Eigen::Vector3d;

/// Places of the tool's surface that all count the same: many more than a tool has proxies.
template <typename Action>
int ForEachPlace(const PressedTool& tool, const Action& action) {
  constexpr int kAlong = 400;
  constexpr int kAcross = 24;
  for (int i = 0; i < kAlong; ++i) {
    for (int j = 0; j < kAcross; ++j) {
      const double a = (i + 0.5) / kAlong;
      const double b = (j + 0.5) / kAcross;
      if (tool.kind == PressedTool::Kind::kFingertip) {
        // Equal steps of height are equal areas of a sphere (Archimedes).
        const double across = std::sqrt(1.0 - a * a);
        const double turn = 2.0 * std::numbers::pi * b;
        action(PressedTool::kFingertipMm *
               Vector3d(across * std::cos(turn), a - 1.0, across * std::sin(turn)));
      } else {
        action(
            Vector3d((a - 0.5) * PressedTool::kFaceMm, 0.0, (b - 0.5) * PressedTool::kFaceWidthMm));
      }
    }
  }
  return kAlong * kAcross;
}

}  // namespace

std::string_view PressedTool::name() const {
  switch (kind) {
    case Kind::kFlat:
      return "face square to flat skin";
    case Kind::kTilted:
      return "face leaning on flat skin";
    case Kind::kRound:
      return "face on round skin";
    case Kind::kFingertip:
      return "fingertip on flat skin";
  }
  return {};
}

forces::PalpationTool PressedTool::Nodes(int num_nodes) const {
  return kind == Kind::kFingertip ? forces::FingertipNodes(kFingertipMm, num_nodes)
                                  : forces::ProbeFaceNodes(kFaceMm, kFaceWidthMm, 0.0, num_nodes);
}

Eigen::Isometry3d PressedTool::BodyFromTool(double depth_mm, double aside_mm) const {
  Eigen::Matrix3d axes;  // Columns: the tool's x, y (into the body) and z, in the body's axes.
  axes << 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, -1.0, 0.0;
  const double tilt_rad = kind == Kind::kTilted ? kTiltRad : 0.0;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = Eigen::AngleAxisd(tilt_rad, Vector3d::UnitY()).toRotationMatrix() * axes;
  pose.translation() << 0.0, aside_mm, -depth_mm;
  return pose;
}

double PressedTool::DepthMm(const Vector3d& in_body_mm) const {
  if (kind != Kind::kRound) return -in_body_mm.z();
  return kRoundMm - std::hypot(in_body_mm.x(), in_body_mm.z() + kRoundMm);
}

Vector3d PressedTool::NormalAt(const Vector3d& in_body_mm) const {
  if (kind != Kind::kRound) return Vector3d::UnitZ();
  return Vector3d(in_body_mm.x(), 0.0, in_body_mm.z() + kRoundMm).normalized();
}

PressedTool::Load PressedTool::Exact(const forces::MultiProxySettings::Repulsion& law,
                                     const Eigen::Isometry3d& body_from_tool) const {
  Load sum;
  const int count = ForEachPlace(*this, [&](const Vector3d& in_tool_mm) {
    const Vector3d place = body_from_tool * in_tool_mm;
    const double depth_mm = DepthMm(place);
    if (depth_mm <= 0.0) return;
    const Vector3d force_n =
        (law.a1_n_per_mm + law.a2_n_per_mm2 * depth_mm) * depth_mm * NormalAt(place);
    sum.force_n += force_n;
    sum.torque_n_mm += (place - body_from_tool.translation()).cross(force_n);
  });
  sum.force_n /= count;
  sum.torque_n_mm /= count;
  return sum;
}

}  // namespace acus::benchmarks
