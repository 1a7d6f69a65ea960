#include "acus/patient/registration/warp_volume.h"

#include <algorithm>
#include <cmath>

#include "acus/base/core/parallel.h"
#include "acus/base/math/inverse_map.h"

namespace acus::registration {
namespace {

using Eigen::Vector3d;

constexpr math::InverseSettings kInverse{.max_iterations = 40, .tolerance_mm = 0.01};
constexpr std::int16_t kPaddingHu = -1024;

/// Calls visit(index of the output voxel, continuous index in the source) for all voxels of slice
/// k.
template <class Visit>
void ForSlice(const volume::Geometry& target, const Eigen::Affine3d& index_from_ct,
              const LatticeField& field, int k, const Visit& visit) {
  const auto u = [&field](const Vector3d& rest_mm) { return field.At(rest_mm); };
  for (int j = 0; j < target.size[1]; ++j) {
    Vector3d u_mm = Vector3d::Zero();  // Of the neighbour: a good guess.
    for (int i = 0; i < target.size[0]; ++i) {
      const Vector3d x_mm = target.ct_from_index() * Vector3d(i, j, k);
      const auto rest = math::InvertDisplacement(u, x_mm, x_mm - u_mm, kInverse);
      u_mm = x_mm - rest.rest_mm;
      visit(target.Index(i, j, k), Vector3d(index_from_ct * rest.rest_mm));
    }
  }
}

std::int16_t Trilinear(const volume::CtVolume& ct, const Vector3d& at) {
  const Eigen::Array3d last = ct.geometry.size.cast<double>() - 1.0;
  if ((at.array() < -0.5).any() || (at.array() > last + 0.5).any()) return kPaddingHu;
  const Eigen::Array3d inside = at.array().max(0.0).min(last);
  const Eigen::Array3i low = inside.cast<int>().min((ct.geometry.size - 2).max(0));
  double value = 0.0;
  for (int c = 0; c < 8; ++c) {
    Eigen::Array3i corner = low;
    double weight = 1.0;
    for (int axis = 0; axis < 3; ++axis) {
      const double share = inside[axis] - low[axis];
      const bool high = ((c >> axis) & 1) != 0;
      weight *= high ? share : 1.0 - share;
      corner[axis] = std::min(low[axis] + (high ? 1 : 0), ct.geometry.size[axis] - 1);
    }
    if (weight > 0.0) value += weight * ct.At(corner[0], corner[1], corner[2]);
  }
  return static_cast<std::int16_t>(std::lround(value));
}

}  // namespace

volume::Geometry GrownGeometry(const volume::Geometry& ct, const LatticeField& field) {
  Eigen::Array3d most_mm = Eigen::Array3d::Zero();
  for (const Vector3d& u_mm : field.nodes_mm()) {
    most_mm = most_mm.max((ct.direction.transpose() * u_mm).array().abs());
  }
  const Eigen::Array3i extra = (most_mm / ct.spacing_mm).ceil().cast<int>();
  volume::Geometry grown = ct;
  grown.size = ct.size + 2 * extra;
  grown.origin_mm = ct.ct_from_index() * Vector3d(-extra.cast<double>().matrix());
  return grown;
}

volume::CtVolume WarpCt(const volume::CtVolume& ct, const LatticeField& field,
                        const RunContext& context) {
  volume::CtVolume warped(GrownGeometry(ct.geometry, field), kPaddingHu);
  const Eigen::Affine3d index_from_ct = ct.geometry.index_from_ct();
  context.Checkpoint("CT in the mannequin's shape", 0.0);
  ParallelFor(warped.geometry.size[2], context.num_threads, [&](int k) {
    ForSlice(warped.geometry, index_from_ct, field, k, [&](std::size_t voxel, const Vector3d& at) {
      warped.voxels[voxel] = Trilinear(ct, at);
    });
  });
  context.Checkpoint("CT in the mannequin's shape", 1.0);
  return warped;
}

volume::LabelMap WarpLabels(const volume::LabelMap& labels, const LatticeField& field,
                            const RunContext& context) {
  volume::LabelMap warped(GrownGeometry(labels.geometry, field));
  warped.names = labels.names;
  const Eigen::Affine3d index_from_ct = labels.geometry.index_from_ct();
  context.Checkpoint("labels in the mannequin's shape", 0.0);
  ParallelFor(warped.geometry.size[2], context.num_threads, [&](int k) {
    ForSlice(warped.geometry, index_from_ct, field, k, [&](std::size_t voxel, const Vector3d& at) {
      const Eigen::Array3i near = at.array().round().cast<int>();
      if (!labels.geometry.Contains(near[0], near[1], near[2])) return;
      warped.voxels[voxel] = labels.At(near[0], near[1], near[2]);
    });
  });
  context.Checkpoint("labels in the mannequin's shape", 1.0);
  return warped;
}

volume::DisplacementField ToDisplacementField(const LatticeField& field) {
  volume::DisplacementField file;
  file.geometry.size = field.size();
  file.geometry.spacing_mm.setConstant(field.spacing_mm());
  file.geometry.origin_mm = field.origin_mm();
  file.displacement_in_ct_mm.reserve(3 * field.nodes_mm().size());
  for (const Vector3d& u_mm : field.nodes_mm()) {
    for (const double x : u_mm) file.displacement_in_ct_mm.push_back(static_cast<float>(x));
  }
  return file;
}

}  // namespace acus::registration
