// Springs whose tissue relaxes, and friction by rate and dwell: closed forms.
#include <cmath>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "acus/base/core/random.h"
#include "acus/physics/tissue/spring_model.h"
#include "support/layered_tissue.h"

namespace acus::tissue {
namespace {

using Eigen::Vector3d;
using testing_support::Layers;
using testing_support::ModelInsertion;
using TimedSprings = ModelInsertion<SpringModel>;

constexpr double kShortS = 0.5, kLongS = 16.0;

/// Skin and fat with a series of two terms; `more` is appended to each of their rows.
forces::ForceTable SpringForces(const std::string& more = "") {
  const std::string series =
      R"(, "relaxation": [{"share": 0.4, "time_s": 0.5}, {"share": 0.3, "time_s": 16}])" + more;
  const std::string text = R"({"format": "acus-forces/1", "reference_diameter_mm": 1.27,
    "interface_hysteresis_mm": 0.2, "tissues": [
      {"tissue": "soft_tissue", "source": "test", "cutting_n": 0.5, "friction_n_per_mm": 0.02},
      {"tissue": "skin", "source": "test", "a1_n_per_mm": 0.1, "a2_n_per_mm2": 0.05,
       "puncture_n": 2.1, "cutting_n": 1.0, "friction_n_per_mm": 0.03)" +
                           series + R"(},
      {"tissue": "fat", "source": "test", "cutting_n": 0.4, "friction_n_per_mm": 0.01)" +
                           series + "}]}";
  return forces::ForceTableFromJson(nlohmann::json::parse(text), "timed springs");
}

SpringModel TimedSpringModel(const forces::ForceTable& table, const Layers& layers) {
  return SpringModel({}, table, testing_support::Trocar18(), testing_support::RoundElasticity(),
                     layers.Tissues(), layers.At());
}

const Layers kSkin{{{0, "skin"}}};
const Layers kFat{{{0, "fat"}}};

void Hold(TimedSprings& insertion, double held_s, double dt_s = 0.001) {
  const int steps = static_cast<int>(std::lround(held_s / dt_s));
  for (int n = 0; n < steps; ++n) insertion.StepTo(insertion.tip_mm, dt_s);
}

TEST(SpringTime, PressedSkinFollowsRampAndHoldOfThreeBranches) {
  const SpringModel model = TimedSpringModel(SpringForces(), kSkin);
  const auto polynomial = [](double x_mm) { return 0.1 * x_mm + 0.05 * x_mm * x_mm; };
  const auto branch_mm = [](double time_s, double held_s) {
    return 4.0 * time_s * -std::expm1(-0.75 / time_s) * std::exp(-held_s / time_s);
  };
  for (const double dt_s : {0.001, 0.01, 0.25}) {
    TimedSprings insertion{model};
    insertion.StepTo(Vector3d::Zero(), dt_s);  // At the skin.
    insertion.MoveToDepth(3.0, 4.0, dt_s);     // 0.75 s at 4 mm/s.
    for (const double held_s : {0.0, 0.25, 1.0, 4.0, 20.0}) {
      TimedSprings held = insertion;
      Hold(held, held_s, dt_s);
      const double expected_n = 0.3 * polynomial(3.0) +
                                0.4 * polynomial(branch_mm(kShortS, held_s)) +
                                0.3 * polynomial(branch_mm(kLongS, held_s));
      EXPECT_NEAR(held.last.puncture_n, expected_n, 1e-6) << held_s << " in steps of " << dt_s;
    }
  }
}

TEST(SpringTime, TipAndShaftRelaxByTheSeriesWhileTheNeedleIsHeld) {
  const SpringModel model = TimedSpringModel(SpringForces(), kFat);
  TimedSprings insertion{model};
  insertion.MoveToDepth(50.0, 5.0);
  const double cutting_n = insertion.last.cutting_n, friction_n = insertion.last.friction_n;
  EXPECT_NEAR(cutting_n, 0.4, 1e-9);
  EXPECT_NEAR(friction_n, 0.01 * (50.0 - 0.4 / model.table().settings.cutting_stiffness_n_per_mm),
              0.025);
  for (const double held_s : {0.1, 0.5, 2.0, 10.0, 60.0}) {
    TimedSprings held = insertion;
    Hold(held, held_s);
    const double share = 0.3 + 0.4 * std::exp(-held_s / kShortS) + 0.3 * std::exp(-held_s / kLongS);
    EXPECT_NEAR(held.last.cutting_n, share * cutting_n, 1e-9) << held_s;
    EXPECT_NEAR(held.last.friction_n, share * friction_n, 1e-9) << held_s;
    EXPECT_EQ(held.state.num_nodes, insertion.state.num_nodes);
    TissueLoad before, after;
    model.LoadOf(insertion.state, before);
    model.LoadOf(held.state, after);  // What is shown stays as it is.
    for (int i = 0; i < before.num_points - 1; ++i) {
      EXPECT_EQ(before.point[i].force_in_ct_n, after.point[i].force_in_ct_n);
    }
  }
}

TEST(SpringTime, TheForceDoesNotDependOnTheStep) {
  const SpringModel model =
      TimedSpringModel(SpringForces(R"(, "friction_rate": 0.1, "friction_dwell": 0.05)"),
                       {{{0, "skin"}, {2, "fat"}}});
  std::vector<double> ends_n;
  for (const double dt_s : {0.0001, 0.001, 0.01}) {
    TimedSprings insertion{model};
    insertion.MoveToDepth(25.0, 10.0, dt_s);
    Hold(insertion, 2.0, dt_s);
    insertion.MoveToDepth(22.0, 10.0, dt_s);
    Hold(insertion, 1.0, dt_s);
    insertion.MoveToDepth(40.0, 10.0, dt_s);
    ends_n.push_back(insertion.last.AxialN());
  }
  EXPECT_NEAR(ends_n[1], ends_n[0], 0.005);
  EXPECT_NEAR(ends_n[2], ends_n[0], 0.03);
}

TEST(SpringTime, FrictionGrowsWithTheLogarithmOfSpeedAndOfRest) {
  forces::ForceTable table = testing_support::RoundForces();
  table.num_times = 2;
  table.times[1].friction_rate = 0.1;
  table.times[1].friction_dwell = 0.08;
  const volume::Label fat = volume::LabelOf("fat");
  table.tissue[fat].time = table.times[1];
  table.time_of[fat] = 1;
  const SpringModel plain = TimedSpringModel(testing_support::RoundForces(), kFat);
  const SpringModel timed = TimedSpringModel(table, kFat);
  const forces::FrictionTime& time = table.friction_time;
  const auto share_at = [&](double speed_mm_per_s, double age_s) {
    return 1.0 + 0.1 * time.RateLog(speed_mm_per_s) + 0.08 * time.DwellLog(age_s);
  };
  for (const double speed_mm_per_s : {2.0, 5.0, 50.0}) {
    TimedSprings of_plain{plain}, of_timed{timed};
    for (const double depth_mm : {9.0, 60.0}) {  // A few nodes, and many.
      of_plain.MoveToDepth(depth_mm, speed_mm_per_s);
      of_timed.MoveToDepth(depth_mm, speed_mm_per_s);
      EXPECT_NEAR(of_timed.last.friction_n / of_plain.last.friction_n,
                  share_at(speed_mm_per_s, time.slip_mm / speed_mm_per_s), 5e-3)
          << speed_mm_per_s << " at " << depth_mm;
    }
  }
  TimedSprings rested{timed};
  rested.MoveToDepth(60.0, 5.0);
  const double sliding_n = rested.last.friction_n;
  Hold(rested, 60.0, 0.1);
  const std::size_t begin = rested.log.size();
  rested.MoveToDepth(75.0, 5.0);
  double peak = 0.0;  // Of friction over that of as much shaft in steady sliding.
  for (std::size_t i = begin; i < rested.log.size(); ++i) {
    const double steady_n = sliding_n + 0.01 * (rested.log[i].depth_mm - 60.0);
    peak = std::max(peak, rested.log[i].friction_n / steady_n);
  }
  EXPECT_GT(peak, share_at(5.0, 10.0));
  EXPECT_LT(peak, share_at(5.0, 60.1));
}

TEST(SpringTime, ATableWithoutTimeForTheTissueGivesItsForces) {
  forces::ForceTable table = testing_support::RoundForces();
  table.num_times = 2;  // Of the liver, which the needle does not meet.
  table.times[1].relaxation.num_terms = 1;
  table.times[1].relaxation.share[0] = 0.5;
  const volume::Label liver = volume::LabelOf("liver");
  table.tissue[liver].time = table.times[1];
  table.time_of[liver] = 1;
  const Layers layers{{{0, "skin"}, {2, "fat"}}};
  const SpringModel plain = TimedSpringModel(testing_support::RoundForces(), layers);
  const SpringModel timed = TimedSpringModel(table, layers);
  TimedSprings of_plain{plain}, of_timed{timed};
  for (const double depth_mm : {30.0, 28.0, 45.0, 10.0, -3.0, 20.0}) {
    of_plain.MoveToDepth(depth_mm, 40.0);
    of_timed.MoveToDepth(depth_mm, 40.0);
    EXPECT_NEAR(of_timed.last.AxialN(), of_plain.last.AxialN(), 1e-12) << depth_mm;
  }
}

// Tissues whose tip forces are equal in all but what they remember: the tip meets no step.
TEST(SpringTime, TheForceAheadOfTheTipIsTakenOverByTheNextTissue) {
  forces::ForceTable table = SpringForces();
  const volume::Label fat = volume::LabelOf("fat"), vessel = volume::LabelOf("vessel");
  table.tissue[vessel] = table.tissue[fat];
  table.num_times = std::max(table.num_times, 3);
  table.times[2].relaxation.num_terms = 1;
  table.times[2].relaxation.share[0] = 0.6;
  table.times[2].relaxation.time_s[0] = 3.0;
  table.tissue[vessel].time = table.times[2];
  table.time_of[vessel] = 2;
  const SpringModel model = TimedSpringModel(table, Layers{{{0, "fat"}, {20, "vessel"}}});
  TimedSprings insertion{model};
  const auto tissue = [&] { return insertion.state.node[insertion.state.num_nodes - 1].tissue; };
  bool has_crossed = false;
  insertion.MoveToDepth(19.0, 5.0);
  const double begin_mm = 19.95 + insertion.state.ahead_mm;  // The tip is just before the vessel.
  insertion.MoveToDepth(begin_mm, 5.0);
  Hold(insertion, 1.0);  // What is ahead of it creeps.
  for (int n = 1; n <= 1000; ++n) {
    const bool was_in_fat = tissue() == fat;
    const double before_n = insertion.last.cutting_n;
    insertion.StepTo({0.0, 0.0, begin_mm + 0.001 * n});
    if (!was_in_fat || tissue() != vessel) continue;
    has_crossed = true;
    EXPECT_LT(before_n, 0.35);
    EXPECT_GT(before_n, 0.2);
    EXPECT_NEAR(insertion.last.cutting_n, before_n, 0.002);
  }
  EXPECT_TRUE(has_crossed);
}

TEST(SpringTime, NoRandomHandGetsWorkFromIt) {
  const SpringModel model =
      TimedSpringModel(SpringForces(R"(, "friction_rate": 0.1, "friction_dwell": 0.08)"), kFat);
  RandomStream random(7, "strokes");
  for (int run = 0; run < 5; ++run) {
    TimedSprings insertion{model};
    double least_n_mm = 0.0;
    insertion.MoveToDepth(30.0, 20.0);
    insertion.work_n_mm = 0.0;
    double stored_n_mm = 0.0;  // Elastic energy of the springs at the beginning, at most.
    for (int i = 1; i < insertion.state.num_nodes; ++i) {
      const PathNode& node = insertion.state.node[i];
      stored_n_mm += 0.5 * node.axial_n_per_mm * model.Weight(insertion.state, i) * node.offset_mm *
                     node.offset_mm;
    }
    stored_n_mm += 0.5 * 0.4 * 0.4 / model.table().settings.cutting_stiffness_n_per_mm;
    for (int stroke = 0; stroke < 60; ++stroke) {
      insertion.MoveToDepth(30.0 + random.Uniform(-6.0, 6.0), random.Uniform(1.0, 80.0));
      if (stroke % 3 == 0) Hold(insertion, random.Uniform(0.0, 2.0));
      least_n_mm = std::min(least_n_mm, insertion.work_n_mm);
    }
    EXPECT_GT(least_n_mm, -stored_n_mm - 1e-9);
    EXPECT_GT(insertion.work_n_mm, 1.0);
  }
}

TEST(SpringTime, HardTimesStepsAndJumpsStayBounded) {
  for (const double time_s : {1e-6, 1e6}) {
    forces::ForceTable table = SpringForces();
    for (const char* tissue : {"skin", "fat"}) {
      forces::ForceRelaxation& relaxation = table.tissue[volume::LabelOf(tissue)].time.relaxation;
      relaxation.time_s = {time_s, 1.0, 1.0};
      relaxation.share = {0.6, 0.399, 0.0};
    }
    const SpringModel model = TimedSpringModel(table, {{{0, "skin"}, {2, "fat"}}});
    for (const double dt_s : {1e-5, 1e-3, 1.0}) {
      TimedSprings insertion{model};
      RandomStream random(9, "jumps");
      insertion.StepTo(Vector3d::Zero(), dt_s);
      for (int n = 0; n < 2000; ++n) {
        insertion.StepTo(Vector3d(0, 0, random.Uniform(-5.0, 60.0)), dt_s);
        ASSERT_TRUE(insertion.last.force_in_ct_n.allFinite());
        ASSERT_LE(insertion.last.force_in_ct_n.norm(), 2.1 + 1.0 + 60 * 0.03 + 1e-9);
      }
    }
  }
}

}  // namespace
}  // namespace acus::tissue
