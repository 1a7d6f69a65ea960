#include "acus/assess/tuning/choice.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "acus/assess/tuning/choice_model.h"
#include "acus/base/core/error.h"

namespace acus::tuning {
namespace {

constexpr std::size_t kMostShared = 256;  ///< Combinations of knobs that act on both parts.
constexpr std::size_t kMostOnFront = 200;

/// The quality of a setting for the goal, or a part of it: less is better, in the order of members.
struct Score {
  double miss = 0.0;   ///< Logarithm of the factor by which limits are exceeded; 0: they are met.
  double merit = 0.0;  ///< The quantity to minimise under the limits.
  double tie = 0.0;    ///< The quantity that decides ties.

  Score& operator+=(const Score& other) {
    miss += other.miss;
    merit += other.merit;
    tie += other.tie;
    return *this;
  }
};

/// The limit of a part in the units of PartOf; nothing if the goal does not name it.
std::optional<double> LimitOf(const Goal& goal, int part) {
  const std::optional<double>& limit = part == 0 ? goal.force : goal.image;
  if (!limit || goal.kind == GoalKind::kBudget) return limit;
  return part == 0 ? *limit * *limit : std::pow(10.0, -0.1 * *limit);
}

class Search {
 public:
  Search(const std::vector<ChoiceKnob>& knobs, const Goal& goal, const ChoiceSettings& settings,
         const std::function<Outcome(const ValueIndices&)>& measure)
      : knobs_(knobs),
        goal_(goal),
        settings_(settings),
        measure_(measure),
        model_(knobs, settings.noise) {
    for (const ChoiceKnob& knob : knobs) given_.push_back(knob.given);
  }

  Choice Run() {
    AsGiven();
    if (settings_.keep_given && Meets(choice_.measured[0].measured, goal_)) {
      choice_.measured[0].predicted = choice_.measured[0].measured;
      choice_.num_one_at_a_time = 1;
      choice_.chosen = 0;
      return std::move(choice_);
    }
    OneAtATime();
    choice_.num_one_at_a_time = static_cast<int>(choice_.measured.size());
    PrepareFronts();
    for (int n = 0; n < settings_.most_joint; ++n) {
      // The best expected setting; if it is measured, the best one if costs were lower than
      // expected by the errors of the expectations so far.
      ValueIndices next = MostPromising(false);
      if (IsMeasured(next)) next = MostPromising(true);
      if (IsMeasured(next)) break;
      Measure(next);
    }
    for (Candidate& candidate : choice_.measured) {
      for (int part = 0; part < kNumParts; ++part) {
        SetPart(candidate.predicted, part, model_.Predicted(candidate.indices, part, kSum));
      }
    }
    choice_.nearest = BestMeasured();
    const Outcome& best = choice_.measured[choice_.nearest].measured;
    if (Meets(best, goal_)) choice_.chosen = choice_.nearest;
    return std::move(choice_);
  }

 private:
  void AsGiven() {
    const Outcome given = measure_(given_);
    for (int part = 0; part < kNumParts; ++part) {
      ACUS_REQUIRE(!LimitOf(goal_, part) || !std::isnan(PartOf(given, part).cost), "the goal ",
                   TextOf(goal_), " names the ", part == 0 ? "force" : "image",
                   ", but this scene has none; leave it out of the goal, or give the scenario such "
                   "an effect");
    }
    model_.AddGiven(given);
    Keep(given_, given);
  }

  void OneAtATime() {
    for (std::size_t knob = 0; knob < knobs_.size(); ++knob) {
      if (!IsTurned(knobs_[knob])) continue;
      for (int index = 0; index < knobs_[knob].num_values; ++index) {
        if (index == knobs_[knob].given) continue;
        ValueIndices indices = given_;
        indices[knob] = index;
        const Outcome alone = measure_(indices);
        model_.AddAlone(knob, index, alone);
        Keep(indices, alone);
      }
    }
  }

  /// Parameters without influence on the goal keep the scenario's values.
  bool IsTurned(const ChoiceKnob& knob) const {
    return (knob.acts_on_force && goal_.force) || (knob.acts_on_image && goal_.image);
  }

  bool IsShared(const ChoiceKnob& knob) const {
    return IsTurned(knob) && knob.acts_on_force && knob.acts_on_image;
  }

  void Measure(const ValueIndices& indices) { Keep(indices, measure_(indices)); }

  void Keep(const ValueIndices& indices, const Outcome& outcome) {
    model_.AddMeasured(indices, outcome);
    choice_.measured.push_back({indices, outcome, {}});
  }

  bool IsMeasured(const ValueIndices& indices) const {
    return std::ranges::find(choice_.measured, indices, &Candidate::indices) !=
           choice_.measured.end();
  }

  Score ScoreOf(const CostAndError& value, int part) const {
    const std::optional<double> limit = LimitOf(goal_, part);
    if (!limit) return {};
    const bool budget = goal_.kind == GoalKind::kBudget;
    const double held = budget ? value.cost : value.error;
    const double cost = value.cost / model_.Given(part).cost;
    const double error = value.error / model_.LargestError(part);
    return {.miss = held > *limit ? std::log(held / *limit) : 0.0,
            .merit = budget ? error : cost,
            .tie = budget ? cost : error};
  }

  Score ScoreOf(const ValueIndices& indices, bool hopeful) const {
    Score score;
    for (int part = 0; part < kNumParts; ++part) {
      if (LimitOf(goal_, part)) score += ScoreOf(model_.Best(indices, part, hopeful), part);
    }
    return score;
  }

  /// Uses the setting's own run, not runs that share one part with it.
  Score ScoreOf(const Candidate& candidate) const {
    Score score;
    for (int part = 0; part < kNumParts; ++part) {
      if (LimitOf(goal_, part)) score += ScoreOf(PartOf(candidate.measured, part), part);
    }
    return score;
  }

  /// A cost that is lower by no more than the noise is not lower. Among equally accurate settings
  /// within a budget, none is better: less time is not required, and parameters stay unchanged.
  bool IsBetter(const Score& a, const Score& b) const {
    const double worth_miss = a.miss > 0.0 && b.miss > 0.0 ? std::log1p(settings_.noise) : 0.0;
    if (std::abs(a.miss - b.miss) > worth_miss) return a.miss < b.miss;
    const bool budget = goal_.kind == GoalKind::kBudget;
    const double worth_merit = budget ? 0.0 : settings_.noise * std::abs(b.merit);
    if (std::abs(a.merit - b.merit) > worth_merit) return a.merit < b.merit;
    return !budget && a.tie < b.tie;
  }

  std::size_t BestMeasured() const {
    std::size_t best = 0;
    for (std::size_t i = 1; i < choice_.measured.size(); ++i) {
      if (IsBetter(ScoreOf(choice_.measured[i]), ScoreOf(choice_.measured[best]))) best = i;
    }
    return best;
  }

  void PrepareFronts() {
    for (int part = 0; part < kNumParts; ++part) {
      if (!LimitOf(goal_, part)) continue;
      auto& front = front_[static_cast<std::size_t>(part)];
      front = FrontOf(part, kSum);
      const std::vector<ValueIndices> other = FrontOf(part, kProduct);
      front.insert(front.end(), other.begin(), other.end());
    }
    shared_ = {given_};
    for (std::size_t knob = 0; knob < knobs_.size(); ++knob) {
      if (!IsShared(knobs_[knob])) continue;
      const std::size_t count = shared_.size();
      for (int index = 0; index < knobs_[knob].num_values; ++index) {
        if (index == knobs_[knob].given || !model_.IsUsable(knob, index)) continue;
        for (std::size_t i = 0; i < count && shared_.size() < kMostShared; ++i) {
          shared_.push_back(shared_[i]);
          shared_.back()[knob] = index;
        }
      }
    }
  }

  /// The settings of the parameters that affect this part alone which are on the model's Pareto
  /// front; built parameter by parameter, which loses none: a dominated setting stays so whatever
  /// is added to both.
  std::vector<ValueIndices> FrontOf(int part, ProductShare law) const {
    std::vector<ValueIndices> front = {given_};
    for (std::size_t knob = 0; knob < knobs_.size(); ++knob) {
      if (!Touches(knobs_[knob], part) || !IsTurned(knobs_[knob]) || IsShared(knobs_[knob])) {
        continue;
      }
      // The scenario's value first: of settings with the same sum, the one that changes the fewest.
      std::vector<ValueIndices> wider = front;
      for (int index = 0; index < knobs_[knob].num_values; ++index) {
        if (index == knobs_[knob].given || !model_.IsUsable(knob, index)) continue;
        for (ValueIndices indices : front) {
          indices[knob] = index;
          wider.push_back(std::move(indices));
        }
      }
      front = Thinned(wider, part, law);
    }
    return front;
  }

  std::vector<ValueIndices> Thinned(const std::vector<ValueIndices>& settings, int part,
                                    ProductShare law) const {
    std::vector<CostAndError> predicted;
    for (const ValueIndices& indices : settings) {
      predicted.push_back(model_.Predicted(indices, part, law));
    }
    const std::vector<std::size_t> order = ParetoFront(predicted);
    std::vector<ValueIndices> front;
    const std::size_t count = std::min(order.size(), kMostOnFront);
    for (std::size_t i = 0; i < count; ++i) {
      front.push_back(settings[order[count > 1 ? i * (order.size() - 1) / (count - 1) : 0]]);
    }
    return front;
  }

  /// The best expected setting: of the fronts, and of those around the best measured one. A
  /// measured one wins a tie.
  ValueIndices MostPromising(bool hopeful) const {
    const ValueIndices& incumbent = choice_.measured[BestMeasured()].indices;
    ValueIndices best = incumbent;
    Score best_score = ScoreOf(best, false);
    const auto consider = [&](const ValueIndices& indices) {
      const Score score = ScoreOf(indices, hopeful);
      if (IsBetter(score, best_score)) {
        best = indices;
        best_score = score;
      }
    };
    for (const ValueIndices& shared : shared_) consider(WithBestParts(shared, hopeful));
    Around(incumbent, consider);
    return best;
  }

  /// The best parameters for each part, given those that affect both.
  ValueIndices WithBestParts(const ValueIndices& shared, bool hopeful) const {
    ValueIndices out = shared;
    for (int part = 0; part < kNumParts; ++part) {
      const auto& front = front_[static_cast<std::size_t>(part)];
      std::optional<Score> best_score;
      ValueIndices best = out;
      for (const ValueIndices& own : front) {
        const ValueIndices indices = Joined(out, own, part);
        const Score score = ScoreOf(model_.Best(indices, part, hopeful), part);
        if (!best_score || IsBetter(score, *best_score)) {
          best = indices;
          best_score = score;
        }
      }
      out = best;
    }
    return out;
  }

  /// `base` with the parameters that affect this part alone from `own`.
  ValueIndices Joined(ValueIndices base, const ValueIndices& own, int part) const {
    for (std::size_t knob = 0; knob < knobs_.size(); ++knob) {
      if (Touches(knobs_[knob], part) && !IsShared(knobs_[knob])) base[knob] = own[knob];
    }
    return base;
  }

  /// All settings that change one parameter or two.
  template <typename Consider>
  void Around(const ValueIndices& middle, const Consider& consider) const {
    for (std::size_t a = 0; a < knobs_.size(); ++a) {
      for (const ValueIndices& one : Turned(middle, a)) {
        consider(one);
        for (std::size_t b = a + 1; b < knobs_.size(); ++b) {
          for (const ValueIndices& two : Turned(one, b)) consider(two);
        }
      }
    }
  }

  std::vector<ValueIndices> Turned(const ValueIndices& middle, std::size_t knob) const {
    std::vector<ValueIndices> turned;
    if (!IsTurned(knobs_[knob])) return turned;
    for (int index = 0; index < knobs_[knob].num_values; ++index) {
      if (index == middle[knob] || !model_.IsUsable(knob, index)) continue;
      turned.push_back(middle);
      turned.back()[knob] = index;
    }
    return turned;
  }

  const std::vector<ChoiceKnob>& knobs_;
  const Goal& goal_;
  const ChoiceSettings& settings_;
  const std::function<Outcome(const ValueIndices&)>& measure_;
  ChoiceModel model_;
  ValueIndices given_;
  std::array<std::vector<ValueIndices>, kNumParts> front_;  ///< For parts that the goal names.
  std::vector<ValueIndices> shared_;
  Choice choice_;
};

}  // namespace

Choice ChooseSetting(const std::vector<ChoiceKnob>& knobs, const Goal& goal,
                     const ChoiceSettings& settings,
                     const std::function<Outcome(const ValueIndices&)>& measure) {
  return Search(knobs, goal, settings, measure).Run();
}

bool Meets(const Outcome& outcome, const Goal& goal) {
  if (!outcome.usable) return false;
  if (goal.kind == GoalKind::kBudget) {
    return !(goal.force && !(outcome.step_us <= *goal.force)) &&
           !(goal.image && !(outcome.image_ms <= *goal.image));
  }
  return !(goal.force && !(outcome.force_error_n <= *goal.force)) &&
         !(goal.image && !(outcome.image_error_db >= *goal.image));
}

}  // namespace acus::tuning
