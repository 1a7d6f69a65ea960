#include "acus/physics/tissue/elastic_planes.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "acus/base/core/error.h"

namespace acus::tissue {
namespace {

constexpr double kLeastImageSine = 0.3;      // Between needle and the image's normal.
constexpr double kLeastPlannedCosine = 0.5;  // Between needle and planned axis.

void CheckSettings(const PlaneSettings& s, double needle_mm) {
  ACUS_REQUIRE(s.spacing_mm > 0.0, "spacing_mm is ", s.spacing_mm, "; allowed: above 0");
  for (const double size_mm : {s.width_mm, s.depth_mm}) {
    ACUS_REQUIRE(size_mm >= 2.0 * s.spacing_mm && size_mm <= 1000.0 * s.spacing_mm, "width_mm is ",
                 s.width_mm, " and depth_mm ", s.depth_mm,
                 "; allowed: 2 to 1000 times spacing_mm, ", s.spacing_mm);
  }
  ACUS_REQUIRE(s.above_mm >= 0.0 && s.above_mm <= 1000.0 * s.spacing_mm, "above_mm is ", s.above_mm,
               "; allowed: 0 to 1000 times spacing_mm");
  const double cells = (s.width_mm / s.spacing_mm) * ((s.depth_mm + s.above_mm) / s.spacing_mm);
  ACUS_REQUIRE(cells <= 10000.0, "the plane has ", cells,
               " cells; allowed: up to 10000, for which the inverse takes 3 GB; take a larger "
               "spacing_mm or a smaller region");
  ACUS_REQUIRE(s.thickness_mm >= 0.0 && std::isfinite(s.thickness_mm), "thickness_mm is ",
               s.thickness_mm, "; allowed: above 0, or 0 to choose it by the width");
  ACUS_REQUIRE(s.width_mm > 8.0 * needle_mm, "width_mm is ", s.width_mm,
               "; allowed: more than four diameters of the needle");
  ACUS_REQUIRE(s.num_turned >= 0 && s.num_turned <= 32, "num_turned is ", s.num_turned,
               "; allowed: 0 to 32");
  ACUS_REQUIRE(s.num_turned == 0 || s.update == PlaneUpdate::kRestricted,
               "a plane that turns needs the restricted update");
}

}  // namespace

ElasticPlanes::ElasticPlanes(const PlaneSettings& settings, const PlanePlacement& placement,
                             const forces::ForceTable& table,
                             const mechanics::ElasticityTable& elasticity, double needle_radius_mm,
                             const TissueAt& tissue_at)
    : entry_in_ct_mm_(placement.entry_in_ct_mm), thickness_mm_(settings.thickness_mm) {
  ACUS_ASSERT(tissue_at != nullptr);
  CheckSettings(settings, needle_radius_mm);
  if (thickness_mm_ == 0.0) {
    const double half_mm = 0.5 * settings.width_mm;
    thickness_mm_ = std::numbers::pi * half_mm / std::log(half_mm / needle_radius_mm);
  }
  const Eigen::Vector3d normal = placement.across_in_ct.cross(placement.axis_in_ct);
  ACUS_REQUIRE(
      placement.entry_in_ct_mm.allFinite() &&
          normal.norm() > 1e-6 * placement.across_in_ct.norm() * placement.axis_in_ct.norm(),
      "the plane's axis and the direction across it are parallel, zero or not finite");
  const double h = settings.spacing_mm;
  half_columns_ = static_cast<int>(std::lround(0.5 * settings.width_mm / h));
  rows_above_ = static_cast<int>(std::lround(settings.above_mm / h));
  grid_.spacing_mm = h;
  grid_.columns = 2 * half_columns_ + 1;  // The planned path is a line of nodes.
  grid_.rows = rows_above_ + static_cast<int>(std::lround(settings.depth_mm / h)) + 1;
  const Eigen::Vector3d axis = placement.axis_in_ct.normalized();
  for (int i = 0; i < std::max(1, settings.num_turned); ++i) {
    const double turn_rad = i == 0 ? 0.0 : std::numbers::pi * i / settings.num_turned;
    const Eigen::Vector3d turned = i == 0 ? Eigen::Vector3d(normal.normalized())
                                          : Eigen::AngleAxisd(turn_rad, axis) * normal.normalized();
    plane_.push_back(
        MakePlane(FrameThrough(entry_in_ct_mm_, axis, turned), table, elasticity, tissue_at));
    plane_.back().frame.tissue = i;
  }
}

ElasticPlanes ElasticPlanes::OnlyPlanned() const {
  ElasticPlanes planned = *this;
  planned.plane_.resize(1);
  return planned;
}

PlaneFrame ElasticPlanes::FrameThrough(const Eigen::Vector3d& entry_in_ct_mm,
                                       const Eigen::Vector3d& axis,
                                       const Eigen::Vector3d& normal) const noexcept {
  PlaneFrame frame;
  frame.ct_from_plane.col(1) = axis;
  frame.ct_from_plane.col(2) = normal;
  frame.ct_from_plane.col(0) = axis.cross(normal);
  const double h = grid_.spacing_mm;
  frame.origin_in_ct_mm =
      entry_in_ct_mm - half_columns_ * h * frame.ct_from_plane.col(0) - rows_above_ * h * axis;
  return frame;
}

ElasticPlanes::Plane ElasticPlanes::MakePlane(const PlaneFrame& frame,
                                              const forces::ForceTable& table,
                                              const mechanics::ElasticityTable& elasticity,
                                              const TissueAt& tissue_at) const {
  std::vector<mechanics::ElasticTissue> tissue(grid_.num_triangles());
  std::vector<char> fixed(grid_.num_nodes(), 0);
  for (int t = 0; t < grid_.num_triangles(); ++t) {
    const volume::Label label = tissue_at(frame.ToCtMm(grid_.CentroidMm(t)));
    tissue[t].youngs_modulus_mpa = mechanics::kEmptyMpa;
    if (label == 0) continue;
    if (table.tissue[label].impenetrable) {
      for (const int node : grid_.Triangle(t)) fixed[node] = 1;
    } else {
      tissue[t] = elasticity.At(label);
    }
  }
  for (int node = 0; node < grid_.num_nodes(); ++node) {  // The rest of the body holds the region.
    const int column = node % grid_.columns;
    const int row = node / grid_.columns;
    if (column == 0 || row == 0 || column == grid_.columns - 1 || row == grid_.rows - 1) {
      fixed[node] = 1;
    }
  }
  mechanics::EmptyUnsupported(grid_, fixed, tissue);
  mechanics::PlaneCompliance inverse =
      mechanics::InvertPlane(grid_, tissue, fixed, mechanics::Dilatation::kCell);
  inverse.matrix /= thickness_mm_;
  return {frame, std::move(inverse.dof_of_node), std::move(fixed),
          std::make_shared<const Eigen::MatrixXd>(std::move(inverse.matrix))};
}

PlaneFrame ElasticPlanes::FrameFor(const Eigen::Vector3d& tip_in_ct_mm,
                                   const Eigen::Vector3d& axis_in_ct,
                                   const Eigen::Vector3d& image_normal_in_ct,
                                   const PlaneFrame& present) const noexcept {
  const Eigen::Vector3d planned = plane_.front().frame.ct_from_plane.col(1);
  Eigen::Vector3d normal = image_normal_in_ct - image_normal_in_ct.dot(axis_in_ct) * axis_in_ct;
  const double size = normal.norm();
  if (!(size > kLeastImageSine && axis_in_ct.dot(planned) > kLeastPlannedCosine)) return present;
  normal /= size;
  const Eigen::Vector3d along = (planned - planned.dot(normal) * normal).normalized();
  const Eigen::Vector3d across = along.cross(normal);
  int nearest = 0;
  double cosine = 0.0;
  for (int i = 0; i < count(); ++i) {
    const double here = across.dot(Of(i).frame.ct_from_plane.col(0));
    if (std::abs(here) <= std::abs(cosine)) continue;
    nearest = i;
    cosine = here;
  }
  if (cosine < 0.0) normal = -normal;  // The same plane, seen as the elastic one is.
  const Eigen::Vector3d entry_mm =
      entry_in_ct_mm_ + (tip_in_ct_mm - entry_in_ct_mm_).dot(normal) * normal;
  PlaneFrame frame = FrameThrough(entry_mm, along, normal);
  frame.tissue = nearest;
  return frame;
}

}  // namespace acus::tissue
