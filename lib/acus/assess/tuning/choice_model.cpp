#include "acus/assess/tuning/choice_model.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace acus::tuning {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

bool IsFinite(const CostAndError& value) {
  return std::isfinite(value.cost) && std::isfinite(value.error);
}

}  // namespace

bool Touches(const ChoiceKnob& knob, int part) {
  return part == 0 ? knob.acts_on_force : knob.acts_on_image;
}

CostAndError PartOf(const Outcome& outcome, int part) {
  if (!outcome.usable) return {kInfinity, kInfinity};
  if (part == 0) return {outcome.step_us, outcome.force_error_n * outcome.force_error_n};
  return {outcome.image_ms, std::pow(10.0, -0.1 * outcome.image_error_db)};
}

void SetPart(Outcome& outcome, int part, const CostAndError& value) {
  // Sums of changes may be negative; NaN stays NaN.
  const double error = std::max(value.error, 0.0);
  const double cost = std::max(value.cost, 0.0);
  if (part == 0) {
    outcome.step_us = cost;
    outcome.force_error_n = std::isnan(value.error) ? value.error : std::sqrt(error);
  } else {
    outcome.image_ms = cost;
    outcome.image_error_db = std::isnan(value.error) ? value.error : -10.0 * std::log10(error);
  }
}

ChoiceModel::ChoiceModel(const std::vector<ChoiceKnob>& knobs, double noise)
    : knobs_(knobs), noise_(noise) {
  for (const ChoiceKnob& knob : knobs) {
    const auto indices = static_cast<std::size_t>(knob.num_values);
    change_.emplace_back(indices, std::array<CostAndError, kNumParts>{});
    usable_.emplace_back(indices, true);
  }
}

void ChoiceModel::AddGiven(const Outcome& outcome) {
  for (int part = 0; part < kNumParts; ++part) {
    given_[static_cast<std::size_t>(part)] = PartOf(outcome, part);
    largest_error_[static_cast<std::size_t>(part)] = Given(part).error;
  }
}

void ChoiceModel::AddAlone(std::size_t knob, int index, const Outcome& outcome) {
  usable_[knob][static_cast<std::size_t>(index)] = outcome.usable;
  if (!outcome.usable) return;
  for (int part = 0; part < kNumParts; ++part) {
    if (!Touches(knobs_[knob], part)) continue;
    const CostAndError alone = PartOf(outcome, part);
    const CostAndError& given = Given(part);
    double& largest = largest_error_[static_cast<std::size_t>(part)];
    largest = std::max(largest, alone.error);
    CostAndError change{alone.cost - given.cost, alone.error - given.error};
    if (std::abs(change.cost) <= noise_ * given.cost) change.cost = 0.0;
    change_[knob][static_cast<std::size_t>(index)][static_cast<std::size_t>(part)] = change;
  }
}

void ChoiceModel::AddMeasured(const ValueIndices& indices, const Outcome& outcome) {
  for (int part = 0; part < kNumParts; ++part) {
    auto& seen = seen_[static_cast<std::size_t>(part)];
    const CostAndError measured = PartOf(outcome, part);
    const auto same = std::ranges::find_if(
        seen, [&](const Seen& other) { return Distance(indices, other.indices, part) == 0; });
    if (same == seen.end()) {
      seen.push_back({indices, measured});
      if (!IsFinite(measured)) continue;
      num_joint_[static_cast<std::size_t>(part)] += NumTurned(indices, part) > 1 ? 1 : 0;
      for (std::size_t i = 0; i < kLaws.size(); ++i) {
        const double cost = std::max(Predicted(indices, part, kLaws[i]).cost, Tiny(part));
        wrong_[static_cast<std::size_t>(part)][i] += std::pow(std::log(measured.cost / cost), 2);
      }
    } else {
      // The same work twice: the larger of two times, so that a setting reported to meet a budget
      // meets it.
      same->measured.cost = std::max(same->measured.cost, measured.cost);
      same->measured.error = std::max(same->measured.error, measured.error);
    }
  }
}

bool ChoiceModel::IsUsable(std::size_t knob, int index) const {
  return usable_[knob][static_cast<std::size_t>(index)];
}

CostAndError ChoiceModel::Change(std::size_t knob, int index, int part) const {
  return change_[knob][static_cast<std::size_t>(index)][static_cast<std::size_t>(part)];
}

double ChoiceModel::LargestError(int part) const {
  const double largest = largest_error_[static_cast<std::size_t>(part)];
  return largest > 0.0 && std::isfinite(largest) ? largest : 1.0;
}

CostAndError ChoiceModel::Predicted(const ValueIndices& indices, int part, ProductShare law) const {
  const CostAndError given = Given(part);
  CostAndError out = given;
  double product = given.cost;
  for (std::size_t knob = 0; knob < knobs_.size(); ++knob) {
    const CostAndError change = Change(knob, indices[knob], part);
    out.cost += change.cost;
    product *= 1.0 + change.cost / given.cost;
    out.error += change.error;
  }
  out.cost += law * (product - out.cost);
  return out;
}

ProductShare ChoiceModel::BestLaw(int part) const {
  const auto& wrong = wrong_[static_cast<std::size_t>(part)];
  std::size_t best = 0;  // The sum, unless another explains more than rounding.
  for (std::size_t i = 1; i < kLaws.size(); ++i) {
    if (wrong[i] < wrong[best] - 1e-9) best = i;
  }
  return kLaws[best];
}

double ChoiceModel::Doubt(int part) const {
  const auto index = static_cast<std::size_t>(part);
  const double mean_square =
      *std::ranges::min_element(wrong_[index]) / std::max(num_joint_[index], 1);
  return std::exp(2.0 * std::sqrt(mean_square));
}

double ChoiceModel::Tiny(int part) const {
  return 1e-6 * Given(part).cost;
}

CostAndError ChoiceModel::Best(const ValueIndices& indices, int part, bool hopeful) const {
  const Seen* nearest = nullptr;
  int least = std::numeric_limits<int>::max();
  for (const Seen& seen : seen_[static_cast<std::size_t>(part)]) {
    const int distance = Distance(indices, seen.indices, part);
    if (distance == 0) return seen.measured;
    // The last one at the smallest distance: it is closer to the end of the search.
    if (!IsFinite(seen.measured) || distance > least) continue;
    nearest = &seen;
    least = distance;
  }
  CostAndError best = Corrected(indices, part, nearest, BestLaw(part));
  if (!hopeful) return best;
  best.cost /= Doubt(part);
  if (num_joint_[static_cast<std::size_t>(part)] > 0) return best;
  for (const ProductShare law : kLaws) {  // The law is not determined yet.
    best.cost = std::min(best.cost, Corrected(indices, part, nearest, law).cost);
  }
  return best;
}

CostAndError ChoiceModel::Corrected(const ValueIndices& indices, int part, const Seen* nearest,
                                    ProductShare law) const {
  CostAndError out = Predicted(indices, part, law);
  out.cost = std::max(out.cost, Tiny(part));
  if (nearest == nullptr) return out;
  const CostAndError there = Predicted(nearest->indices, part, law);
  out.cost *= nearest->measured.cost / std::max(there.cost, Tiny(part));
  if (out.error > 0.0 && there.error > 0.0) out.error *= nearest->measured.error / there.error;
  return out;
}

int ChoiceModel::NumTurned(const ValueIndices& indices, int part) const {
  int count = 0;
  for (std::size_t knob = 0; knob < knobs_.size(); ++knob) {
    count += Touches(knobs_[knob], part) && indices[knob] != knobs_[knob].given ? 1 : 0;
  }
  return count;
}

int ChoiceModel::Distance(const ValueIndices& a, const ValueIndices& b, int part) const {
  int distance = 0;
  for (std::size_t knob = 0; knob < knobs_.size(); ++knob) {
    distance += Touches(knobs_[knob], part) && a[knob] != b[knob] ? 1 : 0;
  }
  return distance;
}

}  // namespace acus::tuning
