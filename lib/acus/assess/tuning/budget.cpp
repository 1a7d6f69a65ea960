#include "acus/assess/tuning/budget.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <set>

#include "acus/assess/tuning/case_run.h"
#include "acus/assess/tuning/scene_sweep.h"
#include "acus/base/core/error.h"

namespace acus::tuning {
namespace {

constexpr const char* kRate = "step_rate_hz";

/// True for numbers and switches: another model would be another scene.
bool IsTurnedUnasked(const Knob& knob) {
  if (knob.is_folder || knob.pointers.empty() || knob.values.size() < 2) return false;
  const nlohmann::json& value = knob.values.front();
  return value.is_number() || value.is_boolean();
}

double Least(const std::vector<Measured>& runs, double Measured::*value) {
  double least = kNotMeasured;
  for (const Measured& run : runs) {
    if (!(least <= run.*value)) least = run.*value;
  }
  return least;
}

double Mean(const std::vector<Measured>& runs,
            const std::function<double(const Measured&)>& value) {
  double sum = 0.0;
  for (const Measured& run : runs) sum += value(run);
  return sum / static_cast<double>(runs.size());
}

std::vector<scenario::EvidenceStage> MeanShares(const std::vector<Measured>& runs) {
  std::vector<scenario::EvidenceStage> stages;
  for (const Measured& run : runs) {
    for (const StageShare& share : run.stages) {
      auto stage = std::ranges::find(stages, share.stage, &scenario::EvidenceStage::stage);
      if (stage == stages.end()) {
        stages.push_back({share.stage, share.rate, 0.0});
        stage = stages.end() - 1;
      }
      stage->share += share.share / static_cast<double>(runs.size());
    }
  }
  for (auto& stage : stages) stage.share = std::min(stage.share, 1.0);
  std::ranges::stable_sort(stages, [](const auto& a, const auto& b) { return a.share > b.share; });
  return stages;
}

MeasuredSetting Summary(const ValueIndices& indices, std::vector<Measured> runs) {
  MeasuredSetting out;
  out.indices = indices;
  out.cost = {.step_us_median = Least(runs, &Measured::step_us_median),
              .step_us_p999 = Least(runs, &Measured::step_us_p999),
              .image_ms_median = Least(runs, &Measured::image_ms_median),
              .image_ms_p95 = Least(runs, &Measured::image_ms_p95)};
  out.force_rms_n = Mean(runs, [](const Measured& run) { return run.force_rms_n; });
  const double grey = Mean(runs, [](const Measured& run) { return run.image_rms_grey; });
  out.image_psnr_db = 20.0 * std::log10(255.0 / grey);
  out.image_ssim = Mean(runs, [](const Measured& run) { return run.image_ssim; });
  out.stages = MeanShares(runs);
  for (const Measured& run : runs) {
    if (out.unusable.empty()) out.unusable = run.unusable;
  }
  out.runs = std::move(runs);
  return out;
}

Outcome OutcomeOf(const MeasuredSetting& setting) {
  return {.step_us = setting.cost.step_us_p999,
          .image_ms = setting.cost.image_ms_p95,
          .force_error_n = setting.force_rms_n,
          .image_error_db = setting.image_psnr_db,
          .usable = setting.unusable.empty()};
}

std::vector<ChoiceKnob> ChoiceKnobs(const std::vector<Knob>& knobs) {
  std::vector<ChoiceKnob> out;
  for (const Knob& knob : knobs) {
    const auto given = std::ranges::find_if(
        knob.values, [&](const auto& value) { return SameValue(value, knob.scenario_value); });
    const auto count = static_cast<int>(knob.values.size());
    out.push_back({.name = knob.name,
                   .num_values = count,
                   .given = given != knob.values.end()
                                ? static_cast<int>(given - knob.values.begin())
                                : count - 1,
                   .acts_on_force = knob.acts_on != ActsOn::kImage,
                   .acts_on_image = knob.acts_on != ActsOn::kForce});
  }
  return out;
}

/// Measures settings, each once, and stores the results.
class Measuring {
 public:
  Measuring(SweepPlan& plan, const RunStore& store, RunContext& context)
      : plan_(plan), store_(store), context_(context), inner_(context) {
    inner_.on_warning = [this](std::string_view text) {
      if (warned_.insert(std::string(text)).second) context_.Warn(text);
    };
  }
  ~Measuring() { context_.provenance = inner_.provenance; }
  Measuring(const Measuring&) = delete;
  Measuring& operator=(const Measuring&) = delete;

  MeasuredSetting Run(const ValueIndices& indices, int repetitions) {
    std::vector<Measured> runs;
    for (int repetition = 0; repetition < repetitions; ++repetition) {
      const Case one = JointCase(plan_, indices, repetition);
      if (std::ranges::find(plan_.cases, one.name, &Case::name) == plan_.cases.end()) {
        plan_.cases.push_back(one);
      }
      RunCases(plan_, store_, one.name, inner_);
      std::optional<Measured> run = store_.Find(one.name);
      ACUS_REQUIRE(run, store_.folder().string(), ": the run ", one.name,
                   " cannot be read back; is the disk full?");
      runs.push_back(std::move(*run));
    }
    return Summary(indices, std::move(runs));
  }

 private:
  SweepPlan& plan_;
  const RunStore& store_;
  RunContext& context_;
  RunContext inner_;
  std::set<std::string> warned_;
};

ValueIndices MostExpensiveOf(const std::vector<Knob>& knobs) {
  ValueIndices indices;
  for (const Knob& knob : knobs) indices.push_back(static_cast<int>(knob.values.size()) - 1);
  return indices;
}

}  // namespace

SweepPlan MakeBudgetPlan(const SweepRequest& request, const RunContext& context) {
  SweepRequest asked = request;
  asked.jointly = true;
  for (const std::string& text : request.knobs) {
    ACUS_REQUIRE(text.substr(0, text.find('=')) != kRate, "--knob ", text,
                 ": how fast samples come is said by the device, not by the scenario; it cannot be "
                 "chosen");
  }
  if (asked.knobs.empty()) {
    for (const Knob& knob : MakePlan(asked, context).knobs) {
      if (IsTurnedUnasked(knob)) asked.knobs.push_back(knob.name);
    }
    ACUS_REQUIRE(!asked.knobs.empty(), request.scene.scenario.string(),
                 ": calls for nothing that can be simulated coarser or finer by a number; name "
                 "knobs with --knob");
  }
  SweepPlan plan = MakePlan(asked, context);
  plan.cases.clear();
  plan.is_subset = false;
  return plan;
}

Goal LiveGoalOf(const SweepPlan& plan, const RunContext& context) {
  constexpr double kServoHz = 1000.0;
  const auto scenario =
      scenario::ReadScenario(plan.request.scene.scenario, plan.request.scene.changes);
  const session::Session session = ReadSessionOf(plan.request.scene, scenario, context);
  const bool images = (scenario.ultrasound || scenario.ct_slice) && !session.probe.empty();
  const bool forces = scenario.needle_force || scenario.probe_force || scenario.tissue;
  ACUS_REQUIRE(images || forces, plan.request.scene.scenario.string(),
               ": has neither forces nor images of the probe that a live session would wait for");
  Goal goal = LiveBudget(kServoHz, scenario.image_rate_hz);
  if (!forces) goal.force.reset();
  if (!images) goal.image.reset();
  return goal;
}

BudgetAnswer AnswerQuestion(const BudgetQuestion& question, SweepPlan plan, const RunStore& store,
                            RunContext& context) {
  BudgetAnswer answer;
  answer.question = question;
  answer.plan = std::move(plan);
  Measuring measuring(answer.plan, store, context);
  answer.plan.cases.push_back(JointCase(answer.plan, MostExpensiveOf(answer.plan.knobs), 0));
  if (!answer.plan.one_reference) {
    for (int r = 1; r < answer.plan.request.repetitions; ++r) {
      answer.plan.cases.push_back(JointCase(answer.plan, MostExpensiveOf(answer.plan.knobs), r));
    }
  }
  const std::vector<ChoiceKnob> knobs = ChoiceKnobs(answer.plan.knobs);
  const auto measure = [&](const ValueIndices& indices) {
    answer.measured.push_back(measuring.Run(indices, answer.plan.request.repetitions));
    return OutcomeOf(answer.measured.back());
  };
  ChoiceSettings settings;
  settings.keep_given = question.live;
  answer.choice = ChooseSetting(knobs, question.goal, settings, measure);
  answer.most_expensive = measuring.Run(MostExpensiveOf(answer.plan.knobs), 1);
  return answer;
}

Setting SettingOf(const std::vector<Knob>& knobs, const ValueIndices& indices) {
  Setting setting;
  for (std::size_t k = 0; k < knobs.size(); ++k) {
    setting[knobs[k].name] = knobs[k].values[static_cast<std::size_t>(indices[k])];
  }
  return setting;
}

SweepResult ResultOf(const BudgetAnswer& answer) {
  SweepPlan shown = answer.plan;
  shown.cases.clear();
  std::vector<Measured> runs;
  const auto add = [&](const std::string& knob, const Setting& setting,
                       const MeasuredSetting& measured) {
    for (const Measured& run : measured.runs) {
      Case one = JointCase(shown, measured.indices, run.repetition);
      one.knob = knob;
      one.setting = setting;
      shown.cases.push_back(std::move(one));
      runs.push_back(run);
      runs.back().knob = knob;
      runs.back().setting = setting;
    }
  };
  // The sweep of a single parameter is identified by its value alone. SettingsOf expects the most
  // expensive first.
  const auto alone = static_cast<std::size_t>(answer.choice.num_one_at_a_time);
  for (std::size_t k = 0; k < shown.knobs.size(); ++k) {
    const Knob& knob = shown.knobs[k];
    std::map<int, const MeasuredSetting*> by_index;
    for (std::size_t i = 0; i < alone; ++i) {
      ValueIndices given = answer.Given().indices;
      given[k] = answer.measured[i].indices[k];
      if (given == answer.measured[i].indices) by_index[given[k]] = &answer.measured[i];
    }
    if (by_index.size() < 2) continue;  // It has no influence on the goal.
    const auto show = [&](int index, const MeasuredSetting& measured) {
      add(knob.name, {{knob.name, knob.values[static_cast<std::size_t>(index)]}}, measured);
    };
    show(by_index.rbegin()->first, *by_index.rbegin()->second);
    by_index.erase(std::prev(by_index.end()));
    for (const auto& [index, measured] : by_index) show(index, *measured);
  }
  const auto joint = [&](const MeasuredSetting& measured) {
    add("jointly", SettingOf(shown.knobs, measured.indices), measured);
  };
  joint(answer.most_expensive);
  std::set<ValueIndices> listed = {answer.most_expensive.indices};
  for (std::size_t i = 0; i < answer.measured.size(); ++i) {
    const MeasuredSetting& measured = answer.measured[i];
    const bool wanted = i >= alone || i == 0 || &measured == &answer.Best();
    if (wanted && listed.insert(measured.indices).second) joint(measured);
  }
  SweepResult result = Summarise(shown, std::move(runs));
  result.jointly = true;
  return result;
}

}  // namespace acus::tuning
