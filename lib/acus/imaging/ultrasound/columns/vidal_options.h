// What Vidal's image does with Hounsfield units.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "acus/imaging/ultrasound/columns/bmode_options.h"

namespace acus::ultrasound {

/// As in configs/schema/acus-image-vidal.schema.json, where the ranges and defaults are.
/// A stage that is off (`shadow`, `noise`, `reflections`) is not computed.
struct VidalOptions {
  std::string name;
  std::vector<HuKnot> grey;  ///< Look-up table: share of white by HU.

  bool shadow = true;
  double bone_above_hu = 0.0;
  double gas_below_hu = 0.0;
  double surface_mm = 0.0;    ///< Of bone and gas that is seen before the shadow begins.
  double shadow_share = 0.0;  ///< Left of what lies behind.
  double needle_share = 1.0;  ///< The same behind the needle, which is thinner than the slice.

  bool noise = true;
  std::uint64_t seed = 0;  ///< Of the noise.
  double noise_grain_mm = 0.0;
  double noise_contrast = 0.0;  ///< 0: none; 1: from black to the table's grey.

  bool reflections = true;
  double sobel_span_mm = 0.0;              ///< Distance of the rows that are compared.
  double reflection_min_hu_per_mm = 0.0;   ///< Along the beam.
  double reflection_max_angle_rad = 0.0;   ///< Between the beam and the gradient.
  double reflection_full_hu_per_mm = 0.0;  ///< From here on a reflection is as bright as it gets.
  double reflection_grey = 0.0;            ///< Share of white.

  double contrast = 1.0;
  double brightness = 0.0;
  double coupling_gap_mm = 0.0;
  /// Gain of the probe for which the table of greys holds, dB; nothing: the probe's, whatever it
  /// is.
  std::optional<double> gain_of_table_db;
};

/// Reads configs/acoustics/<name>.json (format acus-image-vidal/1).
/// @throws InputError listing all problems.
VidalOptions ReadVidalOptions(const std::filesystem::path& path);

/// The defaults of the schema.
VidalOptions DefaultVidalOptions();

}  // namespace acus::ultrasound
