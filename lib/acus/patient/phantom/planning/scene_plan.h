// The insertion of a scene: as requested, or what suits the patient.
#pragma once

#include "acus/patient/phantom/planning/insertion_summary.h"
#include "acus/patient/phantom/planning/scene_request.h"

namespace acus::phantom {

struct ScenePlan {
  InsertionPlan insertion;
  SceneChoice choice;
  bool touches_bone = false;  ///< A first attempt on bone belongs to it, where bone is near.
};

/// Settings as the preset scene_target.json has them, for a target that is known: lengths of thin
/// and of obese patients, and organs are avoided.
PlanSettings SettingsForTarget(PlanSettings settings);

/// The plan for a requested target or window. Without a request: into a lesion or the liver if a
/// good path from around the body ends there, otherwise into a kidney or the spinal canal through
/// their usual windows, with SettingsForTarget, otherwise deep into soft tissue of the trunk.
/// @throws InputError, NoAnswerError as PlanAsRequested and PlanAnywhere.
ScenePlan PlanScene(const volume::LabelMap& labels, const PatientField& field,
                    const PlanSettings& settings, const SceneRequest& request,
                    const RunContext& context);

}  // namespace acus::phantom
