// A patient who breathes, as a scenario calls for it.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <vector>

#include "acus/physics/breathing/breath_source.h"

namespace acus::scenario {

/// Whether a session that recorded the patient's breath says how he breathes.
enum class SessionBreath { kIfRecorded, kAlways, kNever };

/// A patient who breathes.
struct BreathingEffect {
  std::filesystem::path motion;  ///< Folder of acus-breathing.
  double amplitude = 1.0;        ///< Of the motion; 0 holds the patient in the reference state.

  std::filesystem::path signal;  ///< A recording; empty: the pattern.
  breathing::SignalFileOptions signal_file;
  breathing::RecordedBreathSettings recorded;
  bool normalise = true;  ///< The recording's own levels stand for normal breath.
  /// period_s 0: that of the motion.
  breathing::PatternSettings pattern;
  std::vector<breathing::BreathHold> holds;  ///< Seconds since the session began.
  /// The signal or pattern is then only for a live session without a belt.
  SessionBreath from_session = SessionBreath::kIfRecorded;

  bool image = true;  ///< The images show the motion.
  double warp_spacing_mm = 0.0;
  int inverse_iterations = 0;  ///< Of the images.
};

/// @param settings  /effects/breathing, checked against the schema.
/// @param folder  What paths are relative to.
BreathingEffect ReadBreathingEffect(const nlohmann::json& settings,
                                    const std::filesystem::path& folder);

}  // namespace acus::scenario
