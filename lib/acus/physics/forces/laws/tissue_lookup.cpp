#include "acus/physics/forces/laws/tissue_lookup.h"

#include "acus/data/volume/label_lookup.h"

namespace acus::forces {

volume::Label TissueLookup::At(const Eigen::Vector3d& place_in_ct_mm) const noexcept {
  if (labels_ == nullptr) return tissues_->At(field_->HuAt(place_in_ct_mm));
  return volume::LabelAt(*labels_, index_from_ct_, place_in_ct_mm);
}

}  // namespace acus::forces
