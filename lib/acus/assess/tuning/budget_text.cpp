// The texts of a budget's answer.
#include <algorithm>
#include <cmath>

#include "acus/assess/tuning/budget.h"
#include "acus/base/core/text_table.h"
#include "acus/base/core/words.h"

namespace acus::tuning {
namespace {

/// "0.061 ms", from the us of a step.
std::string StepText(double us) {
  return RoundedText(1e-3 * us, 2) + " ms";
}

std::string ImageText(double ms) {
  return RoundedText(ms, 3) + " ms";
}

/// "0.061 ms per force step of 0.5 ms": with the limit, if there is one.
std::string CostText(const scenario::Cost& cost, const Goal& goal) {
  const bool budget = goal.kind == GoalKind::kBudget;
  std::vector<std::string> parts;
  if (!std::isnan(cost.step_us_p999)) {
    parts.push_back(StepText(cost.step_us_p999) +
                    (budget && goal.force ? " of " + StepText(*goal.force) : "") +
                    " per force step (99.9th percentile)");
  }
  if (!std::isnan(cost.image_ms_p95)) {
    parts.push_back(ImageText(cost.image_ms_p95) +
                    (budget && goal.image ? " of " + ImageText(*goal.image) : "") +
                    " per image (95th percentile)");
  }
  return Joined(parts, " and ");
}

std::string ErrorText(const MeasuredSetting& setting) {
  std::vector<std::string> parts;
  if (!std::isnan(setting.force_rms_n)) {
    parts.push_back(setting.force_rms_n == 0.0
                        ? std::string("the same forces")
                        : RoundedText(setting.force_rms_n, 2) + " N RMS of force");
  }
  if (!std::isnan(setting.image_psnr_db)) {
    parts.push_back(std::isinf(setting.image_psnr_db)
                        ? std::string("the same images")
                        : RoundedText(setting.image_psnr_db, 3) + " dB of PSNR (SSIM " +
                              RoundedText(setting.image_ssim, 3) + ")");
  }
  return Joined(parts, " and ");
}

/// "needle_nodes 50 instead of 25, image_lines 128 instead of 256"; empty if nothing is changed.
std::string ChangesText(const BudgetAnswer& answer, const MeasuredSetting& setting) {
  std::vector<std::string> parts;
  const ValueIndices& given = answer.Given().indices;
  for (std::size_t k = 0; k < given.size(); ++k) {
    if (setting.indices[k] == given[k]) continue;
    const Knob& knob = answer.plan.knobs[k];
    const auto value = [&knob](int index) {
      return ValueText(knob.values[static_cast<std::size_t>(index)]);
    };
    parts.push_back(knob.name + " " + value(setting.indices[k]) + " instead of " + value(given[k]));
  }
  return Joined(parts, ", ");
}

/// "Of a force step tissue contact takes 71 %, needle force 20 %."
std::string StagesText(const MeasuredSetting& setting) {
  std::string text;
  for (const auto& [rate, what] : {std::pair{"step", "a force step"}, {"image", "an image"}}) {
    std::vector<std::string> parts;
    for (const auto& stage : setting.stages) {
      if (stage.rate != rate || stage.share < 0.005) continue;
      parts.push_back(stage.stage + (parts.empty() ? " takes " : " ") +
                      FixedText(100.0 * stage.share, 0) + " %");
    }
    if (!parts.empty()) text += std::string("Of ") + what + " " + Joined(parts, ", ") + ".\n";
  }
  return text;
}

/// A part of the simulation, and the text for its time.
struct TimedPart {
  double scenario::Cost::*cost;
  ActsOn acts_on;
  const char* name;
  std::string (*text)(double);
};

/// The parameter whose chosen value costs most relative to its cheapest one.
std::string MostExpensiveKnobText(const BudgetAnswer& answer, const TimedPart& part) {
  constexpr double kWorthTelling = 0.1;
  double scenario::Cost::*const cost = part.cost;
  double most = 0.0;
  std::string out;
  const ValueIndices& given = answer.Given().indices;
  const auto alone = static_cast<std::size_t>(answer.choice.num_one_at_a_time);
  for (std::size_t k = 0; k < given.size(); ++k) {
    const Knob& knob = answer.plan.knobs[k];
    if (knob.acts_on != ActsOn::kBoth && knob.acts_on != part.acts_on) continue;
    const MeasuredSetting* cheapest = nullptr;
    const MeasuredSetting* chosen = nullptr;
    for (std::size_t i = 0; i < alone; ++i) {
      ValueIndices indices = given;
      indices[k] = answer.measured[i].indices[k];
      if (indices != answer.measured[i].indices || !answer.measured[i].unusable.empty()) continue;
      if (indices[k] == answer.Best().indices[k]) chosen = &answer.measured[i];
      if (cheapest == nullptr || answer.measured[i].cost.*cost < cheapest->cost.*cost) {
        cheapest = &answer.measured[i];
      }
    }
    if (chosen == nullptr || cheapest == nullptr) continue;
    if (cheapest->indices[k] > chosen->indices[k]) continue;  // Noise: the finer one is no cheaper.
    const double gain = chosen->cost.*cost - cheapest->cost.*cost;
    if (!(gain > most) || !(gain > kWorthTelling * chosen->cost.*cost)) continue;
    most = gain;
    const auto value = [&](const MeasuredSetting* setting) {
      return ValueText(knob.values[static_cast<std::size_t>(setting->indices[k])]);
    };
    out = std::string("The most expensive knob of ") + part.name + " is " + knob.name + ": " +
          value(chosen) + " instead of " + value(cheapest) + " takes " + part.text(gain) +
          " more.\n";
  }
  return out;
}

std::string WhereTheTimeGoes(const BudgetAnswer& answer) {
  const TimedPart steps = {&scenario::Cost::step_us_p999, ActsOn::kForce, "a force step", StepText};
  const TimedPart images = {&scenario::Cost::image_ms_p95, ActsOn::kImage, "an image", ImageText};
  return StagesText(answer.Best()) + MostExpensiveKnobText(answer, steps) +
         MostExpensiveKnobText(answer, images);
}

std::string LiveText(const BudgetAnswer& answer) {
  const Goal& goal = answer.question.goal;
  const MeasuredSetting& given = answer.Given();
  const std::string cost = CostText(given.cost, goal);
  if (answer.choice.chosen == std::size_t{0}) {
    return "Yes, this machine runs the scene live: " + cost + ".\n";
  }
  std::string text = "No, this machine does not run the scene live as it is: " + cost + ".\n";
  if (answer.Found()) {
    text += "It would with " + ChangesText(answer, answer.Best()) + ": " +
            CostText(answer.Best().cost, goal) + ".\n";
  }
  return text;
}

std::string NothingFoundText(const BudgetAnswer& answer) {
  const Goal& goal = answer.question.goal;
  const bool budget = goal.kind == GoalKind::kBudget;
  const MeasuredSetting& nearest = answer.Best();
  const std::string changes = ChangesText(answer, nearest);
  return "None of the " + std::to_string(answer.measured.size()) + " settings measured " +
         (budget ? "fits " : "is accurate enough for ") + TextOf(goal) + ". The " +
         (budget ? "cheapest" : "most accurate") + " (" +
         (changes.empty() ? "the scenario as it is" : changes) + ") takes " +
         CostText(nearest.cost, goal) +
         "; against the most expensive setting: " + ErrorText(nearest) + ".\n";
}

std::string FoundText(const BudgetAnswer& answer) {
  const Goal& goal = answer.question.goal;
  const MeasuredSetting& best = answer.Best();
  const std::string changes = ChangesText(answer, best);
  std::string text =
      "Chosen for " + TextOf(goal) + " among " + std::to_string(answer.measured.size()) +
      " settings measured: " + (changes.empty() ? "the scenario as it is" : changes) + ".\n";
  text += "It takes " + CostText(best.cost, goal) +
          "; against the most expensive setting: " + ErrorText(best) + ".\n";
  if (!changes.empty()) {
    text += "The scenario as it was takes " + CostText(answer.Given().cost, goal) +
            "; against the most expensive setting: " + ErrorText(answer.Given()) + ".\n";
  }
  return text + "The most expensive setting takes " + CostText(answer.most_expensive.cost, goal) +
         ".\n";
}

}  // namespace

std::string AnswerText(const BudgetAnswer& answer) {
  std::string text = answer.question.live ? LiveText(answer) : std::string();
  if (!answer.Found()) text += NothingFoundText(answer);
  if (answer.Found() && !answer.question.live) text += FoundText(answer);
  return text + WhereTheTimeGoes(answer);
}

}  // namespace acus::tuning
