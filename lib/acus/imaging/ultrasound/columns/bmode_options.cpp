#include "acus/imaging/ultrasound/columns/bmode_options.h"

#include "acus/base/config/json_file.h"
#include "acus/base/core/error.h"

namespace acus::ultrasound {

std::vector<HuKnot> ReadHuCurve(const nlohmann::json& json, const char* key,
                                const std::string& label) {
  std::vector<HuKnot> knots;
  for (const auto& knot : json.at(key)) {
    knots.push_back({knot.at("hu").get<double>(), knot.at("value").get<double>()});
    const std::size_t n = knots.size();
    ACUS_REQUIRE(n < 2 || knots[n - 1].hu > knots[n - 2].hu, label, ": /", key, "/", n - 1,
                 "/hu: is ", knots[n - 1].hu, ", not above the knot before it (", knots[n - 2].hu,
                 "); sort the knots by HU");
  }
  return knots;
}

namespace {

BModeOptions FromJson(const nlohmann::json& json, const std::string& label) {
  BModeOptions options;
  options.name = json.at("name");
  options.impedance_mrayl = ReadHuCurve(json, "impedance_mrayl", label);
  for (const HuKnot& knot : options.impedance_mrayl) {
    ACUS_REQUIRE(knot.value > 0.0, label, ": /impedance_mrayl: ", knot.value, " MRayl at ", knot.hu,
                 " HU; an impedance is above 0 (air: 0.0004)");
  }
  options.interface_span_mm = json.at("interface_span_mm");
  options.shadow_threshold = json.at("shadow_threshold");
  options.boosted_reflection = json.at("boosted_reflection");
  options.needle_reflection = json.at("needle_reflection");
  options.angle_exponent = json.at("angle_exponent");
  options.attenuation = json.at("attenuation");
  options.attenuation_db_per_cm_mhz = ReadHuCurve(json, "attenuation_db_per_cm_mhz", label);
  for (const HuKnot& knot : options.attenuation_db_per_cm_mhz) {
    ACUS_REQUIRE(knot.value >= 0.0, label, ": /attenuation_db_per_cm_mhz: ", knot.value, " at ",
                 knot.hu, " HU; tissue cannot amplify, give 0 or more");
  }
  options.texture = json.at("texture");
  options.backscatter_db = ReadHuCurve(json, "backscatter_db", label);
  options.texture_grain_mm = json.at("texture_grain_mm");
  options.coupling_gap_mm = json.at("coupling_gap_mm");
  return options;
}

}  // namespace

BModeOptions ReadBModeOptions(const std::filesystem::path& path) {
  return FromJson(config::ReadConfig(path, "acus-acoustics"), path.string());
}

BModeOptions DefaultBModeOptions() {
  const nlohmann::json empty = {{"format", "acus-acoustics/1"}};
  return FromJson(config::CheckedConfig(empty, "acus-acoustics", "default acoustics"),
                  "default acoustics");
}

}  // namespace acus::ultrasound
