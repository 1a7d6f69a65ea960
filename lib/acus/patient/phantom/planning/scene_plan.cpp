#include "acus/patient/phantom/planning/scene_plan.h"

#include <algorithm>

#include "acus/base/core/text_table.h"
#include "acus/data/volume/labels.h"
#include "acus/patient/phantom/planning/window_plan.h"

namespace acus::phantom {
namespace {

ScenePlan FromWindow(const WindowPlan& plan, const std::string& name, const std::string& reason) {
  const std::string inside =
      plan.target.depth_mm > 0.0
          ? Message(", ", FixedText(plan.target.depth_mm, 1), " mm inside it")
          : std::string();
  return {.insertion = plan.insertion,
          .choice = {.target = name + inside,
                     .window = Message(plan.window->name, " (", plan.window->what, ")"),
                     .reason = reason},
          .touches_bone = plan.window->is_spinal};
}

/// An organ that is named in the map and that a search from around the body does not go for.
std::optional<ScenePlan> IntoOtherOrgan(const volume::LabelMap& labels, const PatientField& field,
                                        const BodyFrame& frame, const PlanSettings& settings,
                                        const RunContext& context) {
  const PlanSettings wider = SettingsForTarget(settings);
  const std::vector<std::string> present = TargetNames(labels);
  for (const char* organ : {"kidney", "spinal_canal"}) {
    if (std::ranges::find(present, organ) == present.end()) continue;
    const SceneTarget target = FindSceneTarget(labels, field, frame, organ, context.num_threads);
    std::vector<const ApproachWindow*> windows = UsualWindows(organ, "");
    windows.pop_back();  // Not from any side: that is no exercise.
    const auto plan = PlanThroughWindows(field, frame, target, windows, wider, context, nullptr);
    if (!plan) continue;
    return FromWindow(*plan, organ,
                      Message("no good path to a lesion or the liver was found; the ", organ,
                              " is reached through its usual window"));
  }
  return std::nullopt;
}

}  // namespace

PlanSettings SettingsForTarget(PlanSettings settings) {
  settings.min_length_mm = std::min(settings.min_length_mm, 15.0);
  settings.max_length_mm = std::max(settings.max_length_mm, 150.0);
  settings.clearance_mm = std::min(settings.clearance_mm, 2.0);
  for (const char* tissue : {"cartilage", "vessel", "heart", "spinal_canal", "liver", "kidney",
                             "spleen", "pancreas", "bowel", "stomach", "bladder", "gallbladder"}) {
    const volume::Label label = volume::LabelOf(tissue);
    if (std::ranges::find(settings.avoid, label) == settings.avoid.end()) {
      settings.avoid.push_back(label);
    }
  }
  return settings;
}

ScenePlan PlanScene(const volume::LabelMap& labels, const PatientField& field,
                    const PlanSettings& settings, const SceneRequest& request,
                    const RunContext& context) {
  const BodyFrame frame(labels);
  if (!request.target.empty() || !request.window.empty()) {
    const WindowPlan plan = PlanAsRequested(labels, field, frame, request, settings, context);
    const std::string name =
        request.target.empty() ? std::string(plan.window->structure) : request.target;
    return FromWindow(plan, name, "");
  }
  const InsertionPlan plan = PlanAnywhere(field, settings, context, &frame);
  const std::string tissue = TissueNameAt(field, plan.target_ct_mm);
  const bool is_organ = tissue == "liver" || tissue == "lesion";
  if (!is_organ) {
    if (auto other = IntoOtherOrgan(labels, field, frame, settings, context)) return *other;
  }
  const bool is_trunk = frame.IsTrunk(plan.target_ct_mm);
  return {.insertion = plan,
          .choice = {.target = tissue,
                     .window = "",
                     .reason = is_organ ? "a lesion or the liver comes first, and a path is free"
                               : is_trunk
                                   ? "no path to a lesion, the liver, a kidney or the spinal canal "
                                     "was found; this is the best one in the trunk"
                                   : "no path in the trunk is free"},
          .touches_bone = true};
}

}  // namespace acus::phantom
