#include "acus/scene/scenario/breathing_effect.h"

#include <string>

#include "acus/scene/scenario/optional_path.h"

namespace acus::scenario {

BreathingEffect ReadBreathingEffect(const nlohmann::json& settings,
                                    const std::filesystem::path& folder) {
  BreathingEffect effect;
  effect.motion = OptionalPath(settings, "motion", folder);
  effect.signal = OptionalPath(settings, "signal", folder);
  effect.amplitude = settings.at("amplitude");
  effect.signal_file = {settings.at("column"), settings.at("rate_hz")};
  effect.recorded = {settings.at("smoothing_s"), settings.at("repeat")};
  effect.normalise = settings.at("normalise");
  const nlohmann::json& pattern = settings.at("pattern");
  effect.pattern = {.period_s = pattern.at("period_s"),
                    .exponent = pattern.at("exponent"),
                    .period_spread = pattern.at("period_spread"),
                    .speed_spread = pattern.at("speed_spread"),
                    .level_spread = pattern.at("level_spread"),
                    .level = pattern.at("level"),
                    .seed = pattern.at("seed")};
  const std::string from_session = settings.at("from_session");
  if (from_session == "always") effect.from_session = SessionBreath::kAlways;
  if (from_session == "never") effect.from_session = SessionBreath::kNever;
  for (const nlohmann::json& hold : settings.at("hold")) {
    effect.holds.push_back({hold.at(0), hold.at(1)});
  }
  effect.adds_motion = settings.at("tools") == "printed";
  effect.image = settings.at("image");
  effect.warp_spacing_mm = settings.at("warp_spacing_mm");
  effect.inverse_iterations = settings.at("inverse_iterations");
  return effect;
}

}  // namespace acus::scenario
