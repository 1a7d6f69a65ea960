// A free path through a window to the best point of a target.
#pragma once

#include <map>
#include <string>

#include "acus/patient/phantom/planning/approach_window.h"
#include "acus/patient/phantom/planning/image_view.h"
#include "acus/patient/phantom/planning/insertion_plan.h"
#include "acus/patient/phantom/planning/scene_request.h"
#include "acus/patient/phantom/planning/scene_target.h"

namespace acus::phantom {

/// Why directions were refused, and how many of each: tissues by name, "length", "border", "probe",
/// "window".
using Refusals = std::map<std::string, int>;

struct WindowPlan {
  InsertionPlan insertion;
  const ApproachWindow* window;
  TargetPoint target;
  ImageView view;
};

/// The first free path with a good image, windows in order, the points of the target in theirs
/// (lumbar heights first for windows of the spine), directions from that of the window outwards. If
/// no image is good, the best one. "shortest" takes the shortest path, and after other windows only
/// if they have none. `refusals`, if given, gets what was in between.
std::optional<WindowPlan> PlanThroughWindows(const PatientField& field, const BodyFrame& frame,
                                             const SceneTarget& target,
                                             const std::vector<const ApproachWindow*>& windows,
                                             const PlanSettings& settings,
                                             const RunContext& context, Refusals* refusals);

/// "of 310 directions 61 % meet bone, 20 % meet lung": the most frequent reasons first.
std::string RefusalText(const Refusals& refusals, const PlanSettings& settings);

/// PlanThroughWindows for what was requested; without a window the usual ones, without a target the
/// window's structure.
/// @throws InputError as FindSceneTarget. @throws NoAnswerError if no path is free: what is in
///     between, and which other windows would be free.
WindowPlan PlanAsRequested(const volume::LabelMap& labels, const PatientField& field,
                           const BodyFrame& frame, const SceneRequest& request,
                           const PlanSettings& settings, const RunContext& context);

}  // namespace acus::phantom
