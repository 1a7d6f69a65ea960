#include "acus/imaging/ultrasound/beams/beam_interface.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace acus::ultrasound {

double FresnelReflection(double impedance_ratio, double speed_ratio, double cos_incidence) {
  const double c1 = std::clamp(cos_incidence, 0.0, 1.0);
  const double sin2 = speed_ratio * speed_ratio * (1.0 - c1 * c1);
  if (sin2 >= 1.0) return 1.0;
  const double c2 = std::sqrt(1.0 - sin2);
  return (impedance_ratio * c1 - c2) / (impedance_ratio * c1 + c2);
}

double MirrorLobe(double cos_incidence, double lobe_deg, double diffuse_share) {
  const double c = std::clamp(cos_incidence, 1e-3, 1.0);
  const double tan2 = (1.0 - c * c) / (c * c);
  const double width = std::tan(lobe_deg * std::numbers::pi / 180.0);
  return diffuse_share * c + (1.0 - diffuse_share) * std::exp(-0.5 * tan2 / (width * width));
}

SurfaceNormals::SurfaceNormals(const BeamTissue& tissue) : tissue_(tissue) {
  const volume::Geometry& geometry =
      tissue.labels != nullptr ? tissue.labels->geometry : tissue.ct->geometry;
  size_ = geometry.size;
  spacing_mm_ = geometry.spacing_mm;
}

Eigen::Vector3d SurfaceNormals::OfLabels(const Eigen::Array3i& voxel, int before, int after) const {
  // Which side of the surface the voxels around are on; two voxels away, the steps of a
  // voxelised surface matter little.
  constexpr int kReach = 2;
  const volume::LabelMap& labels = *tissue_.labels;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int dk = -kReach; dk <= kReach; dk += kReach) {
    for (int dj = -kReach; dj <= kReach; dj += kReach) {
      for (int di = -kReach; di <= kReach; di += kReach) {
        const Eigen::Array3i at = (voxel + Eigen::Array3i(di, dj, dk)).max(0).min(size_ - 1);
        const int label = labels.At(at[0], at[1], at[2]);
        const double side = label == after ? 1.0 : label == before ? -1.0 : 0.0;
        sum += side * Eigen::Vector3d(di, dj, dk);
      }
    }
  }
  return sum;
}

Eigen::Vector3d SurfaceNormals::OfHu(const Eigen::Array3i& voxel) const {
  const volume::CtVolume& ct = *tissue_.ct;
  Eigen::Vector3d gradient;
  for (int a = 0; a < 3; ++a) {
    Eigen::Array3i low = voxel;
    Eigen::Array3i high = voxel;
    low[a] = std::max(0, voxel[a] - 1);
    high[a] = std::min(size_[a] - 1, voxel[a] + 1);
    gradient[a] = ct.At(high[0], high[1], high[2]) - ct.At(low[0], low[1], low[2]);
  }
  return gradient;
}

Eigen::Vector3d SurfaceNormals::At(const Eigen::Vector3d& index, float before, float after) const {
  const Eigen::Array3i voxel =
      (index.array() + 0.5).floor().max(0.0).min((size_ - 1).cast<double>()).cast<int>();
  Eigen::Vector3d normal = tissue_.labels != nullptr
                               ? OfLabels(voxel, static_cast<int>(before), static_cast<int>(after))
                               : OfHu(voxel);
  normal.array() /= spacing_mm_;
  const double length = normal.norm();
  return length > 0.0 ? Eigen::Vector3d(normal / length) : Eigen::Vector3d::Zero();
}

SurfaceNormals::Angles SurfaceNormals::AnglesTo(const Eigen::Vector3d& index,
                                                const Eigen::Vector3d& step,
                                                const Eigen::Vector3d& across, float before,
                                                float after) const {
  const Eigen::Vector3d normal = At(index, before, after);
  if (normal.isZero(0.0)) return {};
  const Eigen::Vector3d along = (step.array() * spacing_mm_).matrix().normalized();
  const Eigen::Vector3d sideways_mm = across.array() * spacing_mm_;
  const Eigen::Vector3d sideways = (sideways_mm - along.dot(sideways_mm) * along).normalized();
  const double cosine = std::min(1.0, std::abs(along.dot(normal)));
  return {cosine, std::abs(sideways.dot(normal)) / std::max(cosine, 1e-3)};
}

double SurfaceNormals::SideAt(const Eigen::Vector3d& index, int before, int after) const {
  const Eigen::Array3d inside = index.array().max(0.0).min((size_ - 1).cast<double>());
  const Eigen::Array3i low = inside.floor().cast<int>();
  const Eigen::Array3i high = (low + 1).min(size_ - 1);
  const Eigen::Array3d share = inside - low.cast<double>();
  double sum = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    Eigen::Array3i at;
    double weight = 1.0;
    for (int a = 0; a < 3; ++a) {
      const bool up = (corner >> a & 1) != 0;
      at[a] = up ? high[a] : low[a];
      weight *= up ? share[a] : 1.0 - share[a];
    }
    const int label = tissue_.labels->At(at[0], at[1], at[2]);
    sum += label == after ? weight : label == before ? -weight : 0.0;
  }
  return sum;
}

double SurfaceNormals::SamplesToSurface(const Eigen::Vector3d& index, const Eigen::Vector3d& step,
                                        float before, float after) const {
  if (tissue_.labels == nullptr || before == after) return 0.0;
  constexpr double kReachVoxels = 0.75;
  const double reach = kReachVoxels / step.norm();
  const auto side = [&](double samples) {
    return SideAt(index + samples * step, static_cast<int>(before), static_cast<int>(after));
  };
  const double middle = side(0.0);
  if (middle == 0.0) return 0.0;
  const double other_at = middle > 0.0 ? -reach : reach;
  const double other = side(other_at);
  if (middle * other > 0.0) return other_at;
  return other_at * middle / (middle - other);
}

}  // namespace acus::ultrasound
