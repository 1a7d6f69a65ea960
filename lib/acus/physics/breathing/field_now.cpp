#include "acus/physics/breathing/field_now.h"

namespace acus::breathing {

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

}  // namespace acus::breathing
