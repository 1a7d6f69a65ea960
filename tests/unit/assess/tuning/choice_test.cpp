#include "acus/assess/tuning/choice.h"

#include <algorithm>
#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <set>

#include "acus/base/core/error.h"
#include "acus/base/core/random.h"

namespace acus::tuning {
namespace {

constexpr ChoiceSettings kExact{.most_joint = 40, .noise = 0.0};

/// Random knobs whose costs and squared errors add up, or multiply and add up.
class SyntheticScene {
 public:
  SyntheticScene(std::uint64_t seed, double coupling) : coupling_(coupling) {
    RandomStream random(seed, "synthetic scene");
    for (int i = 0; i < 6; ++i) {
      ChoiceKnob knob{.name = "knob " + std::to_string(i)};
      knob.num_values = 2 + static_cast<int>(random.Next() % 3);
      knob.given = static_cast<int>(random.Next() % static_cast<unsigned>(knob.num_values));
      knob.acts_on_force = i < 3;
      knob.acts_on_image = i > 2 || i == 1;
      knobs.push_back(knob);
      std::vector<double> cost{random.Uniform(0.5, 4.0)};
      std::vector<double> error{random.Uniform(0.1, 1.0)};
      for (int index = 1; index < knob.num_values; ++index) {
        cost.push_back(cost.back() * random.Uniform(1.1, 2.5));
        error.push_back(error.back() * random.Uniform(0.2, 0.9));
      }
      cost_.push_back(cost);
      error_.push_back(error);
    }
  }

  Outcome Of(const ValueIndices& indices) const {
    double cost[2] = {2.0, 3.0};
    double product[2] = {1.0, 1.0};
    double error[2] = {0.0, 0.0};
    for (std::size_t i = 0; i < knobs.size(); ++i) {
      const auto index = static_cast<std::size_t>(indices[i]);
      for (const int part : {0, 1}) {
        if (!(part == 0 ? knobs[i].acts_on_force : knobs[i].acts_on_image)) continue;
        cost[part] += cost_[i][index];
        product[part] *= cost_[i][index] / cost_[i][0];
        error[part] += error_[i][index] * error_[i][index];
      }
    }
    Outcome out;
    out.step_us = cost[0] + coupling_ * product[0];
    out.image_ms = cost[1] + coupling_ * product[1];
    out.force_error_n = std::sqrt(error[0]);
    out.image_error_db = -10.0 * std::log10(error[1]);
    return out;
  }

  std::vector<ValueIndices> All() const {
    std::vector<ValueIndices> all = {ValueIndices(knobs.size(), 0)};
    for (std::size_t i = 0; i < knobs.size(); ++i) {
      std::vector<ValueIndices> wider;
      for (const ValueIndices& indices : all) {
        for (int index = 0; index < knobs[i].num_values; ++index) {
          wider.push_back(indices);
          wider.back()[i] = index;
        }
      }
      all = std::move(wider);
    }
    return all;
  }

  /// The largest errors of knobs turned alone: what errors are counted in.
  std::pair<double, double> Scales() const {
    ValueIndices given;
    for (const ChoiceKnob& knob : knobs) given.push_back(knob.given);
    std::pair<double, double> scales{0.0, 0.0};
    for (std::size_t i = 0; i < knobs.size(); ++i) {
      for (int index = 0; index < knobs[i].num_values; ++index) {
        ValueIndices indices = given;
        indices[i] = index;
        const Outcome out = Of(indices);
        scales.first = std::max(scales.first, std::pow(out.force_error_n, 2));
        scales.second = std::max(scales.second, std::pow(10.0, -0.1 * out.image_error_db));
      }
    }
    return scales;
  }

  std::vector<ChoiceKnob> knobs;

 private:
  double coupling_;
  std::vector<std::vector<double>> cost_;
  std::vector<std::vector<double>> error_;
};

/// What a budget leaves to be made small.
double ErrorSum(const Outcome& out, const std::pair<double, double>& scales) {
  return std::pow(out.force_error_n, 2) / scales.first +
         std::pow(10.0, -0.1 * out.image_error_db) / scales.second;
}

/// A budget in the middle of what settings cost, so that it binds.
Goal BindingBudget(const SyntheticScene& scene, double share) {
  std::vector<double> step;
  std::vector<double> image;
  for (const ValueIndices& indices : scene.All()) {
    step.push_back(scene.Of(indices).step_us);
    image.push_back(scene.Of(indices).image_ms);
  }
  std::ranges::sort(step);
  std::ranges::sort(image);
  const auto at = static_cast<std::size_t>(share * static_cast<double>(step.size() - 1));
  return {.kind = GoalKind::kBudget, .force = 1.000001 * step[at], .image = 1.000001 * image[at]};
}

TEST(ChooseSetting, FindsTheBestOfAllWhereCostsAddUp) {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    const SyntheticScene scene(seed, 0.0);
    const Goal goal = BindingBudget(scene, 0.3);
    const auto measure = [&](const ValueIndices& indices) { return scene.Of(indices); };
    const Choice choice = ChooseSetting(scene.knobs, goal, kExact, measure);
    double best = std::numeric_limits<double>::infinity();
    const auto scales = scene.Scales();
    for (const ValueIndices& indices : scene.All()) {
      if (Meets(scene.Of(indices), goal))
        best = std::min(best, ErrorSum(scene.Of(indices), scales));
    }
    ASSERT_EQ(choice.chosen.has_value(), std::isfinite(best)) << "seed " << seed;
    if (!choice.chosen) continue;
    const Outcome& chosen = choice.measured[*choice.chosen].measured;
    EXPECT_TRUE(Meets(chosen, goal));
    EXPECT_NEAR(ErrorSum(chosen, scales), best, 1e-9 * best) << "seed " << seed;
    // Where the model is right, few joint settings say so.
    EXPECT_LE(choice.measured.size(), static_cast<std::size_t>(choice.num_one_at_a_time) + 4);
    const Outcome& predicted = choice.measured[*choice.chosen].predicted;
    EXPECT_NEAR(predicted.step_us, chosen.step_us, 1e-9);
    EXPECT_NEAR(predicted.image_error_db, chosen.image_error_db, 1e-9);
  }
}

TEST(ChooseSetting, FindsTheCheapestOfAllWhereCostsAddUp) {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    const SyntheticScene scene(seed, 0.0);
    const Outcome middle = scene.Of({1, 1, 1, 1, 1, 1});
    const Goal goal{.kind = GoalKind::kAccuracy,
                    .force = 1.000001 * middle.force_error_n,
                    .image = middle.image_error_db - 1e-6};
    const auto measure = [&](const ValueIndices& indices) { return scene.Of(indices); };
    const Choice choice = ChooseSetting(scene.knobs, goal, kExact, measure);
    const Outcome given = choice.measured[0].measured;
    const auto cost = [&](const Outcome& out) {
      return out.step_us / given.step_us + out.image_ms / given.image_ms;
    };
    double least = std::numeric_limits<double>::infinity();
    for (const ValueIndices& indices : scene.All()) {
      if (Meets(scene.Of(indices), goal)) least = std::min(least, cost(scene.Of(indices)));
    }
    ASSERT_TRUE(choice.chosen.has_value()) << "seed " << seed;
    EXPECT_NEAR(cost(choice.measured[*choice.chosen].measured), least, 1e-9) << "seed " << seed;
  }
}

TEST(ChooseSetting, ComesNearTheBestWhereCostsMultiply) {
  int num_best = 0;
  int num_found = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    const SyntheticScene scene(seed, 2.0);
    const Goal goal = BindingBudget(scene, 0.4);
    std::set<ValueIndices> seen;
    const auto measure = [&](const ValueIndices& indices) {
      EXPECT_TRUE(seen.insert(indices).second) << "measured twice";
      return scene.Of(indices);
    };
    const Choice choice = ChooseSetting(scene.knobs, goal, kExact, measure);
    EXPECT_EQ(seen.size(), choice.measured.size());
    const auto scales = scene.Scales();
    std::vector<double> fitting;
    for (const ValueIndices& indices : scene.All()) {
      if (Meets(scene.Of(indices), goal)) fitting.push_back(ErrorSum(scene.Of(indices), scales));
    }
    if (fitting.empty()) {
      EXPECT_FALSE(choice.chosen.has_value());
      continue;
    }
    std::ranges::sort(fitting);
    ASSERT_TRUE(choice.chosen.has_value()) << "seed " << seed << ": " << fitting.size() << " fit";
    const Outcome& chosen = choice.measured[*choice.chosen].measured;
    EXPECT_TRUE(Meets(chosen, goal));
    const double error = ErrorSum(chosen, scales);
    ++num_found;
    num_best += error <= fitting.front() * (1.0 + 1e-9) ? 1 : 0;
    EXPECT_LE(error, 1.5 * fitting.front()) << "seed " << seed;
  }
  EXPECT_GE(num_best, num_found * 8 / 10) << num_best << " of " << num_found;
}

TEST(ChooseSetting, NearestIsTheCheapestIfNothingFits) {
  const SyntheticScene scene(7, 0.0);
  const Goal goal{.kind = GoalKind::kBudget, .force = 0.1};
  const auto measure = [&](const ValueIndices& indices) { return scene.Of(indices); };
  const Choice choice = ChooseSetting(scene.knobs, goal, kExact, measure);
  EXPECT_FALSE(choice.chosen.has_value());
  double least = std::numeric_limits<double>::infinity();
  for (const ValueIndices& indices : scene.All())
    least = std::min(least, scene.Of(indices).step_us);
  EXPECT_NEAR(choice.measured[choice.nearest].measured.step_us, least, 1e-9);
}

TEST(ChooseSetting, LeavesKnobsAloneThatActOnNothingNamed) {
  const SyntheticScene scene(3, 1.0);
  const Goal goal{.kind = GoalKind::kBudget, .force = 1e9};
  const auto measure = [&](const ValueIndices& indices) {
    for (std::size_t i = 0; i < indices.size(); ++i) {
      if (!scene.knobs[i].acts_on_force) {
        EXPECT_EQ(indices[i], scene.knobs[i].given);
      }
    }
    return scene.Of(indices);
  };
  const Choice choice = ChooseSetting(scene.knobs, goal, kExact, measure);
  // With all the time in the world, the most expensive.
  ASSERT_TRUE(choice.chosen.has_value());
  const ValueIndices& chosen = choice.measured[*choice.chosen].indices;
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    if (scene.knobs[i].acts_on_force) {
      EXPECT_EQ(chosen[i], scene.knobs[i].num_values - 1);
    }
  }
}

TEST(ChooseSetting, NeverTakesWhatIsNotUsable) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const SyntheticScene scene(seed, 1.0);
    // The most expensive index of the first knob diverges, and so do two knobs together.
    const auto measure = [&](const ValueIndices& indices) {
      Outcome out = scene.Of(indices);
      out.usable =
          indices[0] != scene.knobs[0].num_values - 1 && !(indices[1] == 1 && indices[2] == 1);
      if (indices == ValueIndices{scene.knobs[0].given, scene.knobs[1].given, scene.knobs[2].given,
                                  scene.knobs[3].given, scene.knobs[4].given,
                                  scene.knobs[5].given}) {
        out.usable = true;
      }
      return out;
    };
    const Goal goal{.kind = GoalKind::kBudget, .force = 1e9, .image = 1e9};
    const Choice choice = ChooseSetting(scene.knobs, goal, kExact, measure);
    ASSERT_TRUE(choice.chosen.has_value());
    EXPECT_TRUE(choice.measured[*choice.chosen].measured.usable) << "seed " << seed;
  }
}

TEST(ChooseSetting, TurnsNoKnobForNoise) {
  // A knob that changes nothing but a cost of the size of the noise.
  const std::vector<ChoiceKnob> knobs = {
      {.name = "idle", .num_values = 2, .given = 1, .acts_on_force = true}};
  const auto measure = [](const ValueIndices& indices) {
    Outcome out;
    out.step_us = indices[0] == 0 ? 9.95 : 10.0;
    out.force_error_n = 0.5;
    return out;
  };
  const Goal goal{.kind = GoalKind::kBudget, .force = 100.0};
  const Choice choice = ChooseSetting(knobs, goal, {}, measure);
  ASSERT_TRUE(choice.chosen.has_value());
  EXPECT_EQ(choice.measured[*choice.chosen].indices, (ValueIndices{1}));
}

TEST(ChooseSetting, KeepsWhatIsGivenIfRequested) {
  const SyntheticScene scene(3, 1.0);
  int count = 0;
  const auto measure = [&](const ValueIndices& indices) {
    ++count;
    return scene.Of(indices);
  };
  const ChoiceSettings keep{.most_joint = 40, .noise = 0.0, .keep_given = true};
  const Goal wide{.kind = GoalKind::kBudget, .force = 1e9, .image = 1e9};
  const Choice kept = ChooseSetting(scene.knobs, wide, keep, measure);
  EXPECT_EQ(count, 1);
  EXPECT_EQ(kept.chosen, std::optional<std::size_t>(0));
  const Goal tight{
      .kind = GoalKind::kBudget, .force = 1e9, .image = 0.9 * kept.measured[0].measured.image_ms};
  const Choice other = ChooseSetting(scene.knobs, tight, keep, measure);
  EXPECT_GT(count, 2);
  EXPECT_NE(other.chosen, std::optional<std::size_t>(0));
}

TEST(ChooseSetting, RefusesAGoalForAPartThatTheSceneHasNot) {
  const std::vector<ChoiceKnob> knobs = {
      {.name = "lines", .num_values = 2, .given = 1, .acts_on_image = true}};
  const auto measure = [](const ValueIndices&) {
    Outcome out;
    out.image_ms = 1.0;
    out.image_error_db = 30.0;
    return out;
  };
  try {
    ChooseSetting(knobs, {.kind = GoalKind::kBudget, .force = 1.0}, {}, measure);
    FAIL() << "was taken";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("names the force, but this scene has none"));
  }
}

TEST(ChooseSetting, PredictsNoCostBelowZero) {
  // Each knob alone takes most of the time away; both together cannot take more than there is.
  const std::vector<ChoiceKnob> knobs = {
      {.name = "a", .num_values = 2, .given = 1, .acts_on_force = true},
      {.name = "b", .num_values = 2, .given = 1, .acts_on_force = true}};
  const auto measure = [](const ValueIndices& indices) {
    Outcome out;
    out.step_us = (indices[0] == 0 ? 0.1 : 1.0) * (indices[1] == 0 ? 0.1 : 1.0) * 100.0;
    out.force_error_n = 0.1 * (2 - indices[0] - indices[1]);
    return out;
  };
  const Goal goal{.kind = GoalKind::kBudget, .force = 2.0};
  const Choice choice = ChooseSetting(knobs, goal, {}, measure);
  ASSERT_TRUE(choice.chosen.has_value());
  const Candidate& chosen = choice.measured[*choice.chosen];
  EXPECT_EQ(chosen.indices, (ValueIndices{0, 0}));
  EXPECT_EQ(chosen.predicted.step_us, 0.0);
}

TEST(Meets, HoldsEveryLimitThatIsNamed) {
  Outcome out;
  out.step_us = 10.0;
  out.force_error_n = 0.1;
  EXPECT_TRUE(Meets(out, {.kind = GoalKind::kBudget, .force = 10.0}));
  EXPECT_FALSE(Meets(out, {.kind = GoalKind::kBudget, .force = 9.9}));
  EXPECT_FALSE(Meets(out, {.kind = GoalKind::kBudget, .image = 1.0}));
  EXPECT_TRUE(Meets(out, {.kind = GoalKind::kAccuracy, .force = 0.1}));
  EXPECT_FALSE(Meets(out, {.kind = GoalKind::kAccuracy, .force = 0.09}));
  out.image_error_db = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(Meets(out, {.kind = GoalKind::kAccuracy, .image = 60.0}));
  out.usable = false;
  EXPECT_FALSE(Meets(out, {.kind = GoalKind::kBudget, .force = 10.0}));
}

}  // namespace
}  // namespace acus::tuning
