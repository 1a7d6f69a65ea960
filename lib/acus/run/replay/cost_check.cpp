#include "acus/run/replay/cost_check.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "acus/base/core/cpu_time.h"
#include "acus/base/core/error.h"
#include "acus/base/core/text_table.h"
#include "acus/base/math/statistics.h"

namespace acus::replay {
namespace {

using scenario::Cost;

struct Line {
  const char* key;
  const char* name;
  const char* unit;
  double Cost::*value;
};
constexpr std::array<Line, 4> kLines = {
    {{"step_us_median", "force step, median", "us", &Cost::step_us_median},
     {"step_us_p999", "force step, 99.9th percentile", "us", &Cost::step_us_p999},
     {"image_ms_median", "image, median", "ms", &Cost::image_ms_median},
     {"image_ms_p95", "image, 95th percentile", "ms", &Cost::image_ms_p95}}};

bool Has(const CostCheck& check, const Line& line) {
  return std::isfinite(check.evidence.measured.*line.value) &&
         std::isfinite(check.measured.*line.value) && check.evidence.measured.*line.value > 0.0;
}

/// "12 % more"
std::string ChangeText(double ratio) {
  const double percent = 100.0 * (ratio - 1.0);
  if (std::abs(percent) < 1.0) return "the same";
  return RoundedText(std::abs(percent), 2) + (percent > 0.0 ? " % more" : " % less");
}

}  // namespace

double CpuClockCostSeconds() {
  // The minimum over many trials: no more than the actual cost may be subtracted from a time.
  double least_s = 1.0;
  for (int go = 0; go < 501; ++go) {
    const double begin_s = ThreadCpuSeconds();
    least_s = std::min(least_s, ThreadCpuSeconds() - begin_s);
  }
  return least_s;
}

Cost CostOf(std::span<const double> step_cpu_s, std::span<const double> image_cpu_s) {
  Cost cost;
  if (!step_cpu_s.empty()) {
    const std::vector<double> steps(step_cpu_s.begin(), step_cpu_s.end());
    cost.step_us_median = 1e6 * math::Median(steps);
    cost.step_us_p999 = 1e6 * math::Quantile(steps, 0.999);
  }
  if (!image_cpu_s.empty()) {
    const std::vector<double> images(image_cpu_s.begin(), image_cpu_s.end());
    cost.image_ms_median = 1e3 * math::Median(images);
    cost.image_ms_p95 = 1e3 * math::Quantile(images, 0.95);
  }
  return cost;
}

std::vector<std::pair<std::string, std::string>> FactsOf(const CostCheck& check) {
  std::vector<std::pair<std::string, std::string>> facts;
  for (const Line& line : kLines) {
    if (!Has(check, line)) continue;
    const double predicted = check.evidence.measured.*line.value;
    const double measured = check.measured.*line.value;
    facts.emplace_back(
        std::string("CPU time, ") + line.name,
        Message(RoundedText(measured, 3), " ", line.unit, ", predicted ", RoundedText(predicted, 3),
                " ", line.unit, " (", ChangeText(measured / predicted), ")"));
  }
  return facts;
}

std::string TextOf(const CostCheck& check) {
  const auto facts = FactsOf(check);
  if (facts.empty()) return {};
  std::string text = Message("Values chosen by acus-tradeoff ", check.evidence.asked,
                             ", predicted on ", check.evidence.machine, ":\n");
  for (const auto& [name, value] : facts) text += "  " + name + ": " + value + "\n";
  if (!check.OnSameMachine()) {
    text += "  This is another machine (" + check.machine +
            "): ask acus-tradeoff again for values that hold here.\n";
  }
  return text;
}

nlohmann::json ToJson(const CostCheck& check) {
  nlohmann::json ratios = nlohmann::json::object();
  for (const Line& line : kLines) {
    if (!Has(check, line)) continue;
    ratios[line.key] = check.measured.*line.value / (check.evidence.measured.*line.value);
  }
  return {{"asked", check.evidence.asked},
          {"machine", check.machine},
          {"predicted_on", check.evidence.machine},
          {"same_machine", check.OnSameMachine()},
          {"predicted", scenario::ToJson(check.evidence.measured)},
          {"measured", scenario::ToJson(check.measured)},
          {"measured_over_predicted", ratios}};
}

}  // namespace acus::replay
