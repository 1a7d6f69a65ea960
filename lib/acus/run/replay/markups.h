// Points of a session for 3D Slicer: the targets of the tip, and the positions of events.
#pragma once

#include <filesystem>
#include <vector>

#include "acus/data/transforms/landmarks.h"
#include "acus/run/replay/event_log.h"
#include "acus/run/training/exercise.h"
#include "acus/scene/scenario/scenario.h"

namespace acus::replay {

inline constexpr const char* kTargetMarkups = "target.mrk.json";
inline constexpr const char* kEventMarkups = "events.mrk.json";

/// The points of the patient's corridor, then the exercise's target if it is from another file: CT
/// space (LPS), mm; the last is the target of the tip. Empty if there are none.
/// @param exercise  May be null.
/// @throws InputError if a file is broken, or lacks the exercise's target.
transforms::Landmarks TargetsOf(const training::Exercise* exercise,
                                const scenario::Scenario& scenario);

/// Writes kTargetMarkups, if there are targets. @throws InputError if it cannot be written.
void WriteTargets(const std::filesystem::path& folder, const transforms::Landmarks& targets);

/// Writes kEventMarkups, if there are events: the tip at each, named "NUMBER EVENT TISSUE".
/// @throws InputError if it cannot be written.
void WriteEventMarkups(const std::filesystem::path& folder, const std::vector<LoggedEvent>& events);

}  // namespace acus::replay
