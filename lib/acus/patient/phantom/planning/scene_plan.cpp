#include "acus/patient/phantom/planning/scene_plan.h"

#include <algorithm>
#include <array>
#include <span>

#include "acus/base/core/text_table.h"
#include "acus/data/volume/labels.h"
#include "acus/patient/phantom/planning/window_plan.h"

namespace acus::phantom {
namespace {

/// What the program may choose, the first that the probe sees well before the others.
constexpr std::array<std::string_view, 3> kChoices = {"lesion", "liver", "kidney"};

std::string TitleOf(const std::string& name, const std::string& structure,
                    std::span<const NamedLevel> levels, const Eigen::Vector3d& target_ct_mm) {
  if (structure != "spinal_canal") return "Puncture of " + name;
  const std::string level = LevelNameAt(levels, target_ct_mm);
  const auto lumbar = LumbarPunctureLevels();
  if (std::ranges::find(lumbar, level) != lumbar.end()) return "Lumbar puncture at " + level;
  return level.empty() ? "Puncture of the spinal canal, at a level without a name"
                       : "Puncture of the spinal canal at " + level;
}

ScenePlan FromWindow(const WindowPlan& plan, const std::string& name, const std::string& structure,
                     std::span<const NamedLevel> levels) {
  const std::string inside =
      plan.target.depth_mm > 0.0
          ? Message(", ", FixedText(plan.target.depth_mm, 1), " mm inside it")
          : std::string();
  return {.insertion = plan.insertion,
          .choice = {.title = TitleOf(name, structure, levels, plan.insertion.target_ct_mm),
                     .target = name + inside,
                     .window = Message(plan.window->name, " (", plan.window->what, ")"),
                     .reason = "",
                     .view = plan.view},
          .touches_bone = plan.window->is_spinal};
}

/// The choice of the program, and what was not possible before it.
class Choice {
 public:
  Choice(const volume::LabelMap& labels, const PatientField& field, const BodyFrame& frame,
         const PlanSettings& settings, const std::vector<NamedLevel>& levels,
         const RunContext& context)
      : labels_(labels),
        field_(field),
        frame_(frame),
        settings_(settings),
        levels_(levels),
        context_(context),
        present_(TargetNames(labels)) {}

  ScenePlan Best() {
    const bool has_liver = IsPresent("liver") || IsPresent("lesion");
    if (has_liver) TryAnywhere();
    for (const std::string_view organ : kChoices) TryThroughWindows(std::string(organ));
    TryThroughWindows("spinal_canal");
    if (best_) return WithReason(*best_);
    if (!has_liver) TryAnywhere();
    if (anywhere_) {
      anywhere_->is_soft_tissue = true;
      return WithReason(*anywhere_);
    }
    throw NoAnswerError(Message(no_path_anywhere_, missed_.empty() ? "" : "; ", missed_));
  }

 private:
  bool IsPresent(const std::string& name) const {
    return std::ranges::find(present_, name) != present_.end();
  }

  bool IsDone() const { return best_ && best_->choice.view->IsGood(); }

  void Miss(const std::string& text) { missed_ += (missed_.empty() ? "" : "; ") + text; }

  void Take(ScenePlan plan) {
    if (!plan.choice.view->IsGood()) {
      Miss(Message(plan.choice.title, ": the probe would see ", ViewText(*plan.choice.view)));
    }
    const bool is_better = !best_ || plan.choice.view->Score() > best_->choice.view->Score();
    if (is_better) best_ = std::move(plan);
  }

  void TryAnywhere() {
    try {
      const InsertionPlan plan = PlanAnywhere(field_, settings_, context_, &frame_);
      const std::string tissue = TissueNameAt(field_, plan.target_ct_mm);
      ScenePlan found{.insertion = plan,
                      .choice = {.title = TitleOf(tissue, tissue, levels_, plan.target_ct_mm),
                                 .target = tissue,
                                 .window = "",
                                 .reason = "",
                                 .view = ViewOf(field_, plan)},
                      .touches_bone = true};
      anywhere_ = found;
      if (tissue == "liver" || tissue == "lesion") Take(std::move(found));
    } catch (const NoAnswerError& error) {
      no_path_anywhere_ = error.what();
    }
  }

  /// Through the usual windows; not from any side, which is no exercise.
  void TryThroughWindows(const std::string& structure) {
    if (IsDone() || !IsPresent(structure)) return;
    SceneTarget target = FindSceneTarget(labels_, field_, frame_, structure, context_.num_threads);
    if (structure == "spinal_canal") {
      PutLumbarFirst(labels_, frame_, levels_, context_.num_threads, target);
    }
    const std::string organ = structure == "lesion" ? "liver" : "";
    std::vector<const ApproachWindow*> windows = UsualWindows(structure, organ);
    windows.pop_back();
    Refusals refusals;
    const PlanSettings wider = SettingsForTarget(settings_);
    const auto plan =
        PlanThroughWindows(field_, frame_, target, windows, wider, context_, &refusals);
    if (plan) {
      Take(FromWindow(*plan, structure, structure, levels_));
    } else {
      Miss(Message("no path to ", structure, ": ", RefusalText(refusals, wider)));
    }
  }

  ScenePlan WithReason(ScenePlan plan) const {
    std::string& reason = plan.choice.reason;
    const bool is_organ = best_.has_value();
    reason = is_organ
                 ? "the first of lesion, liver, kidney and spinal canal that the probe sees well"
             : frame_.IsTrunk(plan.insertion.target_ct_mm)
                 ? "none of lesion, liver, kidney and spinal canal can be reached; this is the "
                   "best path in the trunk"
                 : "no path in the trunk is free";
    if (is_organ && !plan.choice.view->IsGood()) {
      reason = "the one of lesion, liver, kidney and spinal canal that the probe sees best";
    }
    std::string unlabelled;
    for (const char* organ : {"liver", "kidney"}) {
      if (!IsPresent(organ)) unlabelled += (unlabelled.empty() ? "" : ", ") + std::string(organ);
    }
    if (!unlabelled.empty()) reason += "; not labelled: " + unlabelled;
    if (!missed_.empty()) reason += ". Not possible: " + missed_;
    return plan;
  }

  const volume::LabelMap& labels_;
  const PatientField& field_;
  const BodyFrame& frame_;
  const PlanSettings& settings_;
  const std::vector<NamedLevel>& levels_;
  const RunContext& context_;
  std::vector<std::string> present_;
  std::optional<ScenePlan> best_, anywhere_;
  std::string missed_, no_path_anywhere_;
};

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
  const std::vector<NamedLevel> levels = request.Levels();
  if (request.empty()) return Choice(labels, field, frame, settings, levels, context).Best();
  const WindowPlan plan = PlanAsRequested(labels, field, frame, request, settings, context);
  const std::string name =
      request.target.empty() ? std::string(plan.window->structure) : request.target;
  return FromWindow(plan, name, TissueNameAt(field, plan.insertion.target_ct_mm), levels);
}

}  // namespace acus::phantom
