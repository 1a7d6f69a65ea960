#include "acus/scene/effects/view_3d/patient_surfaces.h"

#include <algorithm>

#include "acus/base/core/error.h"
#include "acus/data/volume/labels.h"
#include "acus/patient/segmentation/surfaces/surface_extraction.h"

namespace acus::effects {
namespace {

/// The outer border of all labelled tissue.
constexpr std::string_view kSkin = "skin";
constexpr double kLeastPartMl = 0.1;

segmentation::Mask MaskOf(const volume::LabelMap& labels, std::string_view tissue) {
  const volume::Label wanted = volume::LabelOf(tissue);
  segmentation::Mask mask(labels.geometry);
  std::ranges::transform(labels.voxels, mask.voxels.begin(), [&](volume::Label label) {
    return static_cast<std::uint8_t>(tissue == kSkin ? label != 0 : label == wanted);
  });
  return mask;
}

Eigen::Array3f StandardColour(std::string_view tissue) {
  const auto rgb = volume::ColourOf(volume::LabelOf(tissue));
  return Eigen::Array3f(rgb[0], rgb[1], rgb[2]) / 255.0F;
}

}  // namespace

std::vector<volume_rendering::SurfaceInView> SurfacesOf(const View3dSettings& settings,
                                                        const volume::LabelMap& labels,
                                                        const RunContext& context) {
  std::vector<volume_rendering::SurfaceInView> out;
  for (const auto& surface : settings.surfaces) {
    const segmentation::Mask mask = MaskOf(labels, surface.tissue);
    const double ml =
        1e-3 * static_cast<double>(segmentation::Count(mask)) * labels.geometry.voxel_volume_mm3();
    if (ml < kLeastPartMl) continue;
    context.Checkpoint("surfaces of the view", 0.0);
    segmentation::SurfaceOptions options;
    options.grid_mm = settings.surface_grid_mm;
    options.min_part_ml = kLeastPartMl;
    volume_rendering::SurfaceInView seen;
    seen.name = surface.tissue;
    seen.opacity = surface.opacity;
    seen.colour = surface.colour ? *surface.colour : StandardColour(surface.tissue);
    seen.surface = segmentation::ExtractSurface(mask, options, context.num_threads);
    out.push_back(std::move(seen));
  }
  ACUS_REQUIRE(!out.empty() || !settings.layers.empty(),
               "view_3d: the label map has none of the tissues that are to be shown");
  return out;
}

}  // namespace acus::effects
