// The patient's tissues as surfaces of a view in three dimensions.
#pragma once

#include <vector>

#include "acus/base/core/run_context.h"
#include "acus/imaging/volume_rendering/patient_view.h"
#include "acus/scene/effects/view_3d/view_settings.h"

namespace acus::effects {

/// Surfaces of the tissues that `settings` name and `labels` hold; tissues without a label are
/// omitted.
/// @throws InputError for the name of an unknown tissue, or if none of the tissues has a label.
std::vector<volume_rendering::SurfaceInView> SurfacesOf(const View3dSettings& settings,
                                                        const volume::LabelMap& labels,
                                                        const RunContext& context);

}  // namespace acus::effects
