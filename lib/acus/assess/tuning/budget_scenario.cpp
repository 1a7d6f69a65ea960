#include "acus/assess/tuning/budget_scenario.h"

#include "acus/base/config/json_file.h"
#include "acus/base/core/machine.h"
#include "acus/base/core/provenance.h"
#include "acus/scene/scenario/scenario_document.h"

namespace acus::tuning {
namespace {

namespace fs = std::filesystem;

/// Changes of the parameters that were varied. Unchanged ones are omitted.
std::vector<scenario::Override> ChangesOf(const BudgetAnswer& answer) {
  Setting setting;
  for (const auto& [name, value] : SettingOf(answer.plan.knobs, answer.Best().indices)) {
    const Knob& knob = KnobNamed(answer.plan.knobs, name);
    if (!SameValue(value, knob.scenario_value)) setting[name] = value;
  }
  return OverridesOf(answer.plan.knobs, setting);
}

}  // namespace

scenario::Evidence EvidenceOf(const BudgetAnswer& answer) {
  const MeasuredSetting& best = answer.Best();
  const Candidate& candidate =
      answer.choice.measured[answer.choice.chosen.value_or(answer.choice.nearest)];
  scenario::Evidence evidence;
  evidence.asked = answer.question.asked;
  evidence.machine = MachineName();
  evidence.acus_version = Version();
  evidence.session = answer.plan.request.scene.session.filename().string();
  evidence.session_s = answer.plan.seconds;
  evidence.settings_measured = static_cast<int>(answer.measured.size());
  evidence.repetitions = answer.plan.request.repetitions;
  evidence.predicted.step_us_p999 = candidate.predicted.step_us;
  evidence.predicted.image_ms_p95 = candidate.predicted.image_ms;
  evidence.measured = best.cost;
  evidence.force_rms_n = best.force_rms_n;
  evidence.image_psnr_db = best.image_psnr_db;
  evidence.image_ssim = best.image_ssim;
  evidence.stages = best.stages;
  return evidence;
}

nlohmann::json ChosenScenario(const BudgetAnswer& answer) {
  ACUS_ASSERT(answer.Found());
  const SweptScene& scene = answer.plan.request.scene;
  std::vector<scenario::Override> changes = scene.changes;
  const std::vector<scenario::Override> chosen = ChangesOf(answer);
  changes.insert(changes.end(), chosen.begin(), chosen.end());
  nlohmann::json document =
      scenario::ForAnyFolder(scenario::ScenarioDocument(scene.scenario, changes),
                             fs::absolute(scene.scenario).parent_path());
  document["evidence"] = scenario::ToJson(EvidenceOf(answer));
  return document;
}

void WriteChosenScenario(const fs::path& path, const BudgetAnswer& answer) {
  config::WriteJson(path, ChosenScenario(answer));
  scenario::ReadScenario(path, {});
}

}  // namespace acus::tuning
