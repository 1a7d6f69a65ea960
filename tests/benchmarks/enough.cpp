#include "benchmarks/enough.h"

#include <algorithm>
#include <cmath>

#include "acus/base/core/error.h"
#include "acus/base/core/text_table.h"

namespace acus::benchmarks {
namespace {

double CpuSeconds(const Row& row) {
  constexpr double kSteps = 10'000.0;
  const auto known = [](double value) { return std::isfinite(value) ? value : 0.0; };
  return known(row.preparation_s) + 1e-6 * kSteps * known(row.step_us_median);
}

std::string CostText(const Row& row) {
  std::string text;
  const auto add = [&text](double value, const char* unit) {
    if (std::isfinite(value)) text += (text.empty() ? "" : ", ") + RoundedText(value, 2) + unit;
  };
  add(row.step_us_median, " us per step");
  add(row.preparation_s, " s of preparation");
  add(row.memory_mb, " MB");
  return text;
}

std::string Sentence(const std::vector<const Row*>& rows, double limit_n) {
  const std::string limit = RoundedText(limit_n, 3) + " N";
  const Row* cheapest = nullptr;
  const Row* nearest = nullptr;
  for (const Row* row : rows) {
    if (nearest == nullptr || row->error < nearest->error) nearest = row;
    if (row->error > limit_n) continue;
    if (cheapest == nullptr || CpuSeconds(*row) < CpuSeconds(*cheapest)) cheapest = row;
  }
  if (cheapest != nullptr) {
    return Message(cheapest->knob, ": ", cheapest->value, " is enough for ", limit, ": ",
                   RoundedText(cheapest->error, 2), " N off ", cheapest->reference, "; ",
                   CostText(*cheapest), ".\n");
  }
  return Message(nearest->knob, ": no setting measured is enough for ", limit, "; the nearest, ",
                 nearest->value, ", is ", RoundedText(nearest->error, 2), " N off ",
                 nearest->reference, "; ", CostText(*nearest), ".\n");
}

}  // namespace

std::string EnoughText(const std::vector<Row>& rows, double limit_n) {
  std::vector<std::pair<std::string, std::vector<const Row*>>> knobs;
  for (const Row& row : rows) {
    // What is not off at all is what the others are held against.
    if (row.error_unit != "N" || !row.unusable.empty() || !(row.error > 0.0)) continue;
    const auto knob = std::ranges::find(knobs, row.knob, [](const auto& k) { return k.first; });
    if (knob != knobs.end()) {
      knob->second.push_back(&row);
    } else {
      knobs.push_back({row.knob, {&row}});
    }
  }
  ACUS_REQUIRE(!knobs.empty(), "this sweep has no errors in N that --accuracy could be held to");
  std::string text;
  for (const auto& [knob, settings] : knobs) text += Sentence(settings, limit_n);
  return text;
}

}  // namespace acus::benchmarks
