// What B-mode does with Hounsfield units: acoustic tables by HU, and which stages take part.
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace acus::ultrasound {

/// One knot of a curve over HU. Linear in between, constant beyond the ends.
struct HuKnot {
  double hu = 0.0;
  double value = 0.0;
};

/// The array of {hu, value} under `key`. @throws InputError if the knots are not in order of HU;
/// `label` names the file.
std::vector<HuKnot> ReadHuCurve(const nlohmann::json& json, const char* key,
                                const std::string& label);

/// As in configs/schema/acus-acoustics.schema.json, where the ranges, defaults and sources are.
/// A stage that is off needs no table and costs nothing.
struct BModeOptions {
  std::string name;
  std::vector<HuKnot> impedance_mrayl;  ///< Acoustic impedance by HU; > 0.
  double interface_span_mm = 0.0;       ///< Impedances this far apart along the beam are compared.

  /// Reflections above the threshold are set to `boosted_reflection` (bone and gas shadow).
  double shadow_threshold = 1.0;
  double boosted_reflection = 1.0;

  double needle_reflection = 1.0;  ///< The same for the needle, which is thinner than the slice.

  int angle_exponent = 0;  ///< Echo times cos^n of the angle between beam and interface; 0 = off.

  bool attenuation = false;
  std::vector<HuKnot> attenuation_db_per_cm_mhz;  ///< One way, by HU.

  bool texture = false;
  std::uint64_t seed = 0;              ///< Of the texture.
  std::vector<HuKnot> backscatter_db;  ///< Share per mm of tissue, by HU.
  double texture_grain_mm = 0.4;

  double coupling_gap_mm = 0.0;  ///< Gel fills gaps up to this between face and skin.
};

/// Reads configs/acoustics/<name>.json (format acus-acoustics/1).
/// @throws InputError listing all problems.
BModeOptions ReadBModeOptions(const std::filesystem::path& path);

/// The defaults of the schema: the 2010 paper's way.
BModeOptions DefaultBModeOptions();

}  // namespace acus::ultrasound
