#include "acus/imaging/ultrasound/display/display_options.h"

#include <numbers>

#include "acus/base/config/json_file.h"
#include "acus/base/core/error.h"

namespace acus::ultrasound {

DisplayOptions ReadDisplayOptions(const std::filesystem::path& path) {
  DisplayOptions out;
  if (path.empty()) return out;
  const nlohmann::json json = config::ReadConfig(path, "acus-display");
  out.name = json.at("name");
  if (json.contains("dynamic_range_db")) out.dynamic_range_db = json.at("dynamic_range_db");
  const std::string curve = json.at("curve");
  out.curve = curve == "power"     ? GreyCurve::kPower
              : curve == "sigmoid" ? GreyCurve::kSigmoid
                                   : GreyCurve::kLog;
  if (out.curve == GreyCurve::kPower) out.curve_parameter = json.at("power_exponent");
  if (out.curve == GreyCurve::kSigmoid) out.curve_parameter = json.at("sigmoid_width");
  out.persistence_s = json.at("persistence_s");
  out.compound_angles = json.at("compound_angles");
  out.compound_span_rad = json.at("compound_span_deg").get<double>() * std::numbers::pi / 180.0;
  out.edge_strength = json.at("edge_strength");
  out.edge_sigma_mm = json.at("edge_sigma_mm");
  out.second_harmonic = json.at("second_harmonic");
  out.harmonic_db = json.at("harmonic_db");
  out.harmonic_clutter_db = json.at("harmonic_clutter_db");
  return out;
}

double SteeringRad(const DisplayOptions& display, int look) {
  if (display.compound_angles < 2) return 0.0;
  const double step_rad = display.compound_span_rad / (display.compound_angles - 1);
  const int from_middle = (look + 1) / 2 * (look % 2 == 1 ? -1 : 1);
  return step_rad * from_middle;
}

acoustics::Probe ProbeOfLook(const acoustics::Probe& probe, const DisplayOptions& display,
                             int look) {
  const int angles = display.compound_angles;
  ACUS_REQUIRE(angles >= 1 && angles <= 15 && angles % 2 == 1 && display.compound_span_rad >= 0.0 &&
                   display.compound_span_rad <= 1.05,
               "display: ", angles, " compound angles over ", display.compound_span_rad,
               " rad; allowed is an odd number, 1 to 15, over 0 to 1.05 rad");
  ACUS_REQUIRE(angles == 1 || probe.kind != acoustics::ProbeKind::kPhased, "display: ", angles,
               " compound angles for the phased probe ", probe.name,
               ", whose lines are steered already; give compound_angles 1, or a linear or "
               "curvilinear probe");
  acoustics::Probe out = probe;
  out.dynamic_range_db = display.dynamic_range_db.value_or(probe.dynamic_range_db);
  out.second_harmonic = display.second_harmonic;
  out.steer_rad = SteeringRad(display, look);
  return out;
}

}  // namespace acus::ultrasound
