#include "acus/physics/breathing/moved_points.h"

#include "acus/base/core/error.h"
#include "acus/physics/breathing/displacement_kernel.h"

namespace acus::breathing {
namespace {

static_assert(kernels::FieldNow::kMaxComponents == MotionWeights::kMaxCount);

kernels::FieldNow FieldOf(const MotionMap& motion) {
  const MotionField& field = motion.field();
  kernels::FieldNow out;
  out.num_components = motion.weights().count;
  for (int n = 0; n < out.num_components; ++n) {
    const auto at = static_cast<std::size_t>(n);
    const int component = motion.weights().component[at];
    out.values[n] = field.StoredRow(component, 0, 0).data();
    out.unit_mm[n] = motion.weights().weight[at] * static_cast<float>(field.MmPerUnit(component));
  }
  const std::int16_t* first = field.StoredRow(0, 0, 0).data();
  out.row = field.StoredRow(0, 1, 0).data() - first;
  out.slice = field.StoredRow(0, 0, 1).data() - first;
  const Eigen::Affine3d index_from_ct = field.nodes().index_from_ct();
  for (int a = 0; a < 3; ++a) {
    out.last[a] = static_cast<float>(field.nodes().size[a] - 1);
    out.index_offset[a] = static_cast<float>(index_from_ct.translation()[a]);
    for (int b = 0; b < 3; ++b) {
      out.index_from_ct[3 * a + b] = static_cast<float>(index_from_ct.linear()(a, b));
    }
  }
  return out;
}

}  // namespace

void DisplacementsMm(const MotionMap& motion, Eigen::Ref<const Eigen::Matrix3Xf> rest_mm,
                     Eigen::Ref<Eigen::Matrix3Xf> displacement_mm) noexcept {
  ACUS_ASSERT(motion.moves() && rest_mm.cols() == displacement_mm.cols());
  kernels::Displacements(FieldOf(motion), rest_mm.data(), static_cast<int>(rest_mm.cols()),
                         displacement_mm.data());
}

void MoveWithNormals(const MotionMap& motion, Eigen::Ref<const Eigen::Matrix3Xf> rest_mm,
                     Eigen::Ref<const Eigen::Matrix3Xf> rest_normals,
                     Eigen::Ref<Eigen::Matrix3Xf> world_mm,
                     Eigen::Ref<Eigen::Matrix3Xf> normals) noexcept {
  ACUS_ASSERT(motion.moves() && rest_mm.cols() == world_mm.cols() &&
              rest_mm.cols() == rest_normals.cols() && rest_mm.cols() == normals.cols());
  kernels::MoveWithNormals(FieldOf(motion), rest_mm.data(), rest_normals.data(),
                           static_cast<int>(rest_mm.cols()), world_mm.data(), normals.data());
}

}  // namespace acus::breathing
