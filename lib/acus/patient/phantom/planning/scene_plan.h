// The insertion of a scene: as requested, or what suits the patient.
#pragma once

#include "acus/patient/phantom/planning/insertion_summary.h"
#include "acus/patient/phantom/planning/scene_request.h"

namespace acus::phantom {

struct ScenePlan {
  InsertionPlan insertion;
  SceneChoice choice;
  bool touches_bone = false;    ///< A first attempt on bone belongs to it, where bone is near.
  bool is_soft_tissue = false;  ///< None of the structures that the program looks for is reached.
};

/// Settings as the preset scene_target.json has them, for a target that is known: lengths of thin
/// and of obese patients, and organs are avoided.
PlanSettings SettingsForTarget(PlanSettings settings);

/// The plan for a requested target or window. Without a request: the first of lesion, liver, kidney
/// and spinal canal (at a lumbar level, if levels have names) that can be reached and that the
/// probe sees well; otherwise that of them which it sees best; otherwise deep into soft tissue of
/// the trunk. Known targets are reached with SettingsForTarget. The reason states what was not
/// possible.
/// @throws InputError, NoAnswerError as PlanAsRequested and PlanAnywhere.
ScenePlan PlanScene(const volume::LabelMap& labels, const PatientField& field,
                    const PlanSettings& settings, const SceneRequest& request,
                    const RunContext& context);

}  // namespace acus::phantom
