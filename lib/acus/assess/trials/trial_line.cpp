#include "acus/assess/trials/trial_line.h"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <vector>

namespace acus::trials {
namespace {

constexpr double kReachMm = 60.0;
constexpr double kSkinStepMm = 0.5;
constexpr double kSkinToleranceMm = 1e-6;
constexpr double kNormalSpacingMm = 6.0;
constexpr double kSineOfUpright = 0.1;

Eigen::Vector3d Perpendicular(const Eigen::Vector3d& direction) {
  return direction.unitOrthogonal();
}

/// The component of `direction` perpendicular to the unit vector `normal`.
Eigen::Vector3d LaidInto(const Eigen::Vector3d& normal, const Eigen::Vector3d& direction) {
  return direction - direction.dot(normal) * normal;
}

/// Mean speed along the axis from 10 % to 90 % of a pass: rests at its ends do not count. 0 if the
/// pass has no such samples.
double MiddleSpeed(const TrialScene& scene, const session::Session& trial,
                   const training::NeedlePass& pass, const TrialLine& line) {
  std::optional<std::pair<double, double>> first;  // Start, in seconds and mm.
  const double to_go_mm = 0.1 * pass.advance_mm;
  for (const session::PoseSample& sample : trial.needle) {
    if (!sample.valid || sample.time_ns < pass.begin_ns) continue;
    const Eigen::Vector3d tip_mm =
        scene.scene.ct_from_reference * Eigen::Vector3d(sample.reference_from_tool.translation());
    const double along_mm = (tip_mm - line.ct_from_tip.translation()).dot(line.axis_in_ct);
    const double time_s = 1e-9 * static_cast<double>(sample.time_ns);
    if (!first && along_mm >= to_go_mm - pass.advance_mm) first = {time_s, along_mm};
    if (first && along_mm >= -to_go_mm) {
      return time_s > first->first ? (along_mm - first->second) / (time_s - first->first) : 0.0;
    }
  }
  return 0.0;
}

}  // namespace

std::optional<Eigen::Vector3d> EntryOfLine(const TrialScene& scene,
                                           const Eigen::Vector3d& near_ct_mm,
                                           const Eigen::Vector3d& direction_in_ct) {
  const auto inside = [&](double t_mm) {
    return scene.IsInBody(near_ct_mm + t_mm * direction_in_ct);
  };
  std::optional<double> nearest_mm;
  bool was_inside = inside(-kReachMm);
  const int steps = static_cast<int>(2.0 * kReachMm / kSkinStepMm);
  for (int i = 1; i <= steps; ++i) {
    const double t_mm = -kReachMm + kSkinStepMm * i;
    const bool is_inside = inside(t_mm);
    if (is_inside && !was_inside && (!nearest_mm || std::abs(t_mm) < std::abs(*nearest_mm))) {
      nearest_mm = t_mm;
    }
    was_inside = is_inside;
  }
  if (!nearest_mm) return std::nullopt;
  double outside_mm = *nearest_mm - kSkinStepMm;
  double inside_mm = *nearest_mm;
  while (inside_mm - outside_mm > kSkinToleranceMm) {
    const double middle_mm = 0.5 * (inside_mm + outside_mm);
    (inside(middle_mm) ? inside_mm : outside_mm) = middle_mm;
  }
  return near_ct_mm + inside_mm * direction_in_ct;
}

Eigen::Vector3d SkinNormalInCt(const TrialScene& scene, const Eigen::Vector3d& entry_ct_mm,
                               const Eigen::Vector3d& direction_in_ct) {
  const Eigen::Vector3d a = Perpendicular(direction_in_ct);
  const Eigen::Vector3d b = direction_in_ct.cross(a);
  std::vector<Eigen::Vector3d> points;
  for (int i = -1; i <= 1; ++i) {
    for (int j = -1; j <= 1; ++j) {
      const auto point =
          EntryOfLine(scene, entry_ct_mm + kNormalSpacingMm * (i * a + j * b), direction_in_ct);
      // A line that enters far away meets another part of the body.
      if (point && (*point - entry_ct_mm).norm() < 5.0 * kNormalSpacingMm) points.push_back(*point);
    }
  }
  if (points.size() < 3) return direction_in_ct;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (const auto& point : points) centre += point / static_cast<double>(points.size());
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const auto& point : points) scatter += (point - centre) * (point - centre).transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(scatter);
  const Eigen::Vector3d normal = axes.eigenvectors().col(0);
  return normal.dot(direction_in_ct) < 0.0 ? Eigen::Vector3d(-normal) : normal;
}

void MakeSkinAxes(TrialLine& line, const Eigen::Vector3d& other_in_ct) {
  const Eigen::Vector3d& inward = line.inward_in_ct;
  Eigen::Vector3d along = LaidInto(inward, line.axis_in_ct);
  if (along.norm() < kSineOfUpright) along = LaidInto(inward, other_in_ct);
  if (along.norm() < kSineOfUpright) along = Perpendicular(inward);
  line.along_in_ct = along.normalized();
  line.across_in_ct = inward.cross(line.along_in_ct);
}

TrialLine LineOfTrial(const TrialScene& scene, const session::Session& trial) {
  const Eigen::Isometry3d& ct_from_reference = scene.scene.ct_from_reference;
  const training::InsideTissue inside = [&](const Eigen::Vector3d& point_mm) {
    return scene.IsInBody(ct_from_reference * point_mm);
  };
  const auto passes = training::FindPasses(trial.needle, inside, scene.exercise.passes);
  ACUS_REQUIRE(!passes.empty(), "session \"", trial.name,
               "\" has no insertion: the needle never advanced by ", scene.exercise.passes.turn_mm,
               " mm in tissue; is the transform of this patient the right one?");
  const training::NeedlePass& last = passes.back();
  const session::PoseSample deepest = session::PoseAt(trial.needle, last.end_ns);
  TrialLine line;
  line.ct_from_tip = ct_from_reference * deepest.reference_from_tool.isometry();
  line.axis_in_ct = line.ct_from_tip.linear().col(2).normalized();
  constexpr double kLongestMm = 300.0;
  line.entry_ct_mm =
      ct_from_reference * training::ShaftExit(deepest.reference_from_tool, inside, kLongestMm);
  line.depth_mm = (line.ct_from_tip.translation() - line.entry_ct_mm).norm();
  line.deepest_ns = last.end_ns;
  line.speed_mm_per_s = MiddleSpeed(scene, trial, last, line);
  line.entry_ns = last.begin_ns;
  line.inward_in_ct = SkinNormalInCt(scene, line.entry_ct_mm, line.axis_in_ct);
  MakeSkinAxes(line, Eigen::Vector3d::UnitZ());
  return line;
}

std::string PatientDirection(const Eigen::Vector3d& direction_in_ct) {
  constexpr const char* kPlus[] = {"the left", "the back", "the head"};
  constexpr const char* kMinus[] = {"the right", "the front", "the feet"};
  Eigen::Index axis = 0;
  direction_in_ct.cwiseAbs().maxCoeff(&axis);
  return direction_in_ct[axis] >= 0.0 ? kPlus[axis] : kMinus[axis];
}

}  // namespace acus::trials
