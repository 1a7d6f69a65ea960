#include "acus/patient/phantom/hands/probe_script.h"

#include <algorithm>
#include <cmath>

#include "acus/patient/phantom/hands/hand_motion.h"

namespace acus::phantom {
namespace {

using Eigen::Vector3d;

constexpr double kLatticeMm = 2.0;
constexpr double kMarginMm = 6.0;  ///< More than tremor and wander ever need.

}  // namespace

ProbePath::ProbePath(const PatientField& field, const InsertionPlan& plan,
                     const ProbeScript& script)
    : plan_(plan), script_(script) {
  const double reach = script.sweep_mm + std::abs(script.out_of_plane_mm) + kMarginMm;
  first_along_mm_ = script.ahead_mm - kMarginMm;
  first_across_mm_ = -reach;
  columns_ = static_cast<int>(std::ceil(2.0 * kMarginMm / kLatticeMm)) + 1;
  rows_ = static_cast<int>(std::ceil(2.0 * reach / kLatticeMm)) + 1;
  const Vector3d lateral = plan.lateral();
  for (int row = 0; row < rows_; ++row) {
    for (int column = 0; column < columns_; ++column) {
      const Vector3d start = plan.entry_ct_mm +
                             (first_along_mm_ + column * kLatticeMm) * plan.heading +
                             (first_across_mm_ + row * kLatticeMm) * lateral;
      const auto skin = SkinAlong(field, start, plan.skin_normal, 60.0);
      if (!skin) {
        throw NoAnswerError(
            Message("no skin under the probe, ", script.ahead_mm,
                    " mm ahead of the entry point; make `ahead_mm` or `sweep_mm` smaller"));
      }
      height_mm_.push_back((*skin - start).dot(plan.skin_normal));
    }
  }
  // The beam goes into the skin squarely, in the needle's plane, except for the toe.
  const Vector3d face = plan.entry_ct_mm + script.ahead_mm * plan.heading +
                        Height(script.ahead_mm, script.out_of_plane_mm) * plan.skin_normal;
  const Vector3d inwards = -SkinNormal(field, face);
  const Vector3d beam = Eigen::AngleAxisd(script.toe_rad, lateral) *
                        (inwards - inwards.dot(lateral) * lateral).normalized();
  ct_from_probe_rotation_.col(0) = beam.cross(lateral);  // x = y cross z, towards the heading.
  ct_from_probe_rotation_.col(1) = beam;
  ct_from_probe_rotation_.col(2) = lateral;
}

double ProbePath::Height(double along_mm, double across_mm) const {
  const double u = std::clamp((along_mm - first_along_mm_) / kLatticeMm, 0.0, columns_ - 1.001);
  const double v = std::clamp((across_mm - first_across_mm_) / kLatticeMm, 0.0, rows_ - 1.001);
  const int i = static_cast<int>(u);
  const int j = static_cast<int>(v);
  const double s = u - i;
  const double t = v - j;
  const auto at = [&](int column, int row) { return height_mm_[row * columns_ + column]; };
  return (1 - t) * ((1 - s) * at(i, j) + s * at(i + 1, j)) +
         t * ((1 - s) * at(i, j + 1) + s * at(i + 1, j + 1));
}

Eigen::Isometry3d ProbePath::CtFromProbe(double time_s, double along_mm, double across_mm) const {
  const double landed = MinimumJerk(time_s / script_.land_s);
  // The sweep: from one side past the plane and back to it.
  const double swept = (time_s - script_.land_s) / script_.sweep_s;
  const double overshoot = -0.4 * script_.sweep_mm;
  const double sweep =
      swept < 0.65 ? script_.sweep_mm + MinimumJerk(swept / 0.65) * (overshoot - script_.sweep_mm)
                   : overshoot * (1.0 - MinimumJerk((swept - 0.65) / 0.35));
  const double along = script_.ahead_mm + along_mm;
  const double across = script_.out_of_plane_mm + sweep + across_mm;
  const double height = Height(along, across) + script_.gap_mm + (1.0 - landed) * script_.lift_mm;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = ct_from_probe_rotation_;
  pose.translation() = plan_.entry_ct_mm + along * plan_.heading + across * plan_.lateral() +
                       height * plan_.skin_normal;
  return pose;
}

}  // namespace acus::phantom
