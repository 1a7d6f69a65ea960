// How the layer of one tissue lies around a place, from a label map.
#pragma once

#include <Eigen/Geometry>
#include <optional>

#include "acus/data/volume/volume.h"

namespace acus::effects {

/// Normal of the layer of the place's tissue, unit length: the direction in which the tissue is
/// thinnest within 6 mm. Nothing where it is no layer. Allocates nothing; about 900 look-ups.
/// @param index_from_ct  Of the label map: Geometry::index_from_ct().
std::optional<Eigen::Vector3d> LayerNormal(const volume::LabelMap& labels,
                                           const Eigen::Affine3d& index_from_ct,
                                           const Eigen::Vector3d& place_in_ct_mm) noexcept;

}  // namespace acus::effects
