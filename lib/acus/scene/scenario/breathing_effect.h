// The settings of the effect breathing in a scenario.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <vector>

#include "acus/physics/breathing/breath_source.h"

namespace acus::scenario {

/// Whether the breath comes from the session, if it was recorded there.
enum class SessionBreath { kIfRecorded, kAlways, kNever };

/// A patient who breathes.
struct BreathingEffect {
  std::filesystem::path motion;  ///< Output folder of acus-breathing.
  double amplitude = 1.0;        ///< Factor on the motion; 0 holds the patient at the reference.

  std::filesystem::path signal;  ///< A recording; empty: the pattern.
  breathing::SignalFileOptions signal_file;
  breathing::RecordedBreathSettings recorded;
  bool normalise = true;  ///< The recording's own levels stand for normal breath.
  /// A period_s of 0 stands for the period of the motion.
  breathing::PatternSettings pattern;
  std::vector<breathing::BreathHold> holds;  ///< Seconds since the session began.
  /// With the session's breath, the signal or pattern only serves live sessions without a belt.
  SessionBreath from_session = SessionBreath::kIfRecorded;

  bool adds_motion = false;  ///< Tools at rest by x + u, as printed, in place of the inverse.
  bool image = true;         ///< The images show the motion.
  double warp_spacing_mm = 0.0;
  int inverse_iterations = 0;  ///< For the images.
};

/// @param settings  /effects/breathing, checked against the schema.
/// @param folder  The base of relative paths.
BreathingEffect ReadBreathingEffect(const nlohmann::json& settings,
                                    const std::filesystem::path& folder);

}  // namespace acus::scenario
