#include "acus/assess/trials/planned_path.h"

#include <algorithm>

#include "acus/data/transforms/landmarks.h"

namespace acus::trials {
namespace {

/// Distance from the entry to the centre of the face, along the skin.
constexpr double kFaceBesideMm = 30.0;

Eigen::Vector3d PointOf(const transforms::Landmarks& points, const std::string& name) {
  const auto found = std::ranges::find(points.names, name);
  ACUS_REQUIRE(found != points.names.end(), points.source, ": has no point \"", name,
               "\"; a virtual trainee needs entry and target, as in corridor_ct.csv of "
               "acus-phantom");
  return points.points_mm.col(found - points.names.begin());
}

}  // namespace

PlannedPath PlannedPathOf(const TrialScene& scene) {
  const std::filesystem::path& file = scene.scenario.patient.corridor;
  ACUS_REQUIRE(!file.empty(), scene.scenario.file.string(),
               ": /patient/corridor: is missing; a virtual trainee plans from its points entry and "
               "target; give --set /patient/corridor=corridor_ct.csv");
  const transforms::Landmarks points = transforms::ReadLandmarks(file);
  PlannedPath path;
  path.entry_ct_mm = PointOf(points, "entry");
  path.target_ct_mm = scene.target_ct_mm ? *scene.target_ct_mm : PointOf(points, "target");
  ACUS_REQUIRE((path.target_ct_mm - path.entry_ct_mm).norm() > 1.0, file.string(),
               ": entry and target coincide");
  path.axis_in_ct = (path.target_ct_mm - path.entry_ct_mm).normalized();
  if (const auto skin = EntryOfLine(scene, path.entry_ct_mm, path.axis_in_ct)) {
    path.entry_ct_mm = *skin;
  }
  path.inward_in_ct = SkinNormalInCt(scene, path.entry_ct_mm, path.axis_in_ct);
  TrialLine line;
  line.axis_in_ct = path.axis_in_ct;
  line.inward_in_ct = path.inward_in_ct;
  MakeSkinAxes(line, Eigen::Vector3d::UnitZ());
  const Eigen::Vector3d beside_mm = path.entry_ct_mm + kFaceBesideMm * line.along_in_ct;
  path.face_ct_mm = EntryOfLine(scene, beside_mm, path.inward_in_ct).value_or(beside_mm);
  return path;
}

Eigen::Isometry3d ProbeAlongNeedle(const PlannedPath& path, const Eigen::Vector3d& axis_in_ct,
                                   double offset_mm, double turn_rad) {
  // The plane of the needle's line and the centre of the face.
  const Eigen::Vector3d to_face = path.face_ct_mm - path.entry_ct_mm;
  Eigen::Vector3d normal = to_face.cross(axis_in_ct);
  if (normal.norm() < 1e-6) normal = axis_in_ct.unitOrthogonal();
  normal.normalize();
  Eigen::Vector3d beam = path.target_ct_mm - path.face_ct_mm;
  beam = (beam - beam.dot(normal) * normal).normalized();
  Eigen::Isometry3d ct_from_probe = Eigen::Isometry3d::Identity();
  ct_from_probe.linear().col(0) = beam.cross(normal);
  ct_from_probe.linear().col(1) = beam;
  ct_from_probe.linear().col(2) = normal;
  ct_from_probe.linear() = Eigen::AngleAxisd(turn_rad, beam) * ct_from_probe.linear();
  ct_from_probe.translation() = path.face_ct_mm + offset_mm * normal;
  return ct_from_probe;
}

}  // namespace acus::trials
