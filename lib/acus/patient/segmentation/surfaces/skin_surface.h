// The skin of a patient whose CT ends within the body.
#pragma once

#include "acus/data/mesh/surface.h"
#include "acus/data/volume/volume.h"

namespace acus::segmentation {

/// The triangles of the body's surface with air in front of them: without those on the border of
/// the volume or on the label `cut`, where the body extends beyond what the scanner has seen.
/// @param body  Closed, LPS mm, outwards, such as ExtractSurface makes from `labels`.
/// @param reach_mm  Above 0. Triangles closer than that to the border, along their normal, are
///     omitted; so deep behind a triangle is `cut` looked for.
mesh::Surface SkinOf(const mesh::Surface& body, const volume::LabelMap& labels, double reach_mm);

}  // namespace acus::segmentation
