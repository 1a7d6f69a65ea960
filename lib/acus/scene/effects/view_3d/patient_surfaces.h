// The patient's tissues as surfaces of a view in three dimensions.
#pragma once

#include <vector>

#include "acus/base/core/run_context.h"
#include "acus/imaging/volume_rendering/patient_view.h"
#include "acus/scene/effects/view_3d/view_settings.h"

namespace acus::effects {

/// Surfaces of the tissues that `settings` name and `labels` hold; those of other tissues are left
/// out.
/// @throws InputError for a tissue that there is none of in any patient, or if all are left out.
std::vector<volume_rendering::SurfaceInView> SurfacesOf(const View3dSettings& settings,
                                                        const volume::LabelMap& labels,
                                                        const RunContext& context);

}  // namespace acus::effects
