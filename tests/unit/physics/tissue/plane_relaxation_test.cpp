// Tissue of the 2D model that relaxes, and its friction by rate and dwell: closed forms.
#include <cmath>
#include <gtest/gtest.h>
#include <vector>

#include "acus/base/core/random.h"
#include "acus/physics/tissue/plane_contact.h"
#include "acus/physics/tissue/plane_model_2010.h"
#include "support/layered_tissue.h"

namespace acus::tissue {
namespace {

using testing_support::Layers;
using testing_support::ModelInsertion;

mechanics::Relaxation SeriesOf(const std::vector<mechanics::Relaxation::Term>& terms) {
  mechanics::Relaxation out;
  for (const auto& term : terms) out.term[static_cast<std::size_t>(out.num_terms++)] = term;
  return out;
}

const mechanics::Relaxation kTwoTerms = SeriesOf({{0.3, 0.05}, {0.25, 1.0}});
constexpr double kFree = 1e6;  // Bounds that nothing comes near.

Eigen::MatrixXd TwoNodes() {
  Eigen::MatrixXd c(4, 4);
  c << 0.8, 0.1, 0.3, 0.0, 0.1, 0.9, 0.05, 0.2, 0.3, 0.05, 0.7, 0.1, 0.0, 0.2, 0.1, 0.6;
  return c;
}

/// Two nodes whose four slots are moved to the same displacement.
struct MovedNodes {
  Eigen::MatrixXd compliance = TwoNodes();
  PlaneContact contact;
  explicit MovedNodes(const mechanics::Relaxation& relaxation = {})
      : contact(compliance, 4, PlaneUpdate::kRestricted, relaxation) {
    contact.Append(0, 1.0, 0.0);
    contact.Append(2, 1.0, 0.0);
  }
  void MoveTo(double to_mm, double duration_s) {
    contact.Pass(duration_s);
    for (int i = 0; i < 4; ++i) contact.SetDemand(i, to_mm, -kFree, kFree);
    ASSERT_TRUE(contact.Solve(1e-10));
  }
};

/// Share of the elastic force at `t_s` of a ramp of `ramp_s` that is then held.
double RampThenHold(const mechanics::Relaxation& relaxation, double ramp_s, double t_s) {
  double share = std::min(1.0, t_s / ramp_s);
  for (int k = 0; k < relaxation.num_terms; ++k) {
    const auto& [lost, time_s] = relaxation.term[static_cast<std::size_t>(k)];
    const double ramped_s = std::min(t_s, ramp_s);
    const double begun = lost / ramp_s * (ramped_s + time_s * std::expm1(-ramped_s / time_s));
    share -= t_s <= ramp_s ? begun : lost + (begun - lost) * std::exp(-(t_s - ramp_s) / time_s);
  }
  return share;
}

TEST(PlaneRelaxation, ARampAndAHoldAreThePronySeriesWhateverTheStep) {
  MovedNodes elastic;
  elastic.MoveTo(2.0, 1.0);
  for (const double step_s : {1e-5, 1e-3, 0.02, 0.1}) {
    MovedNodes relaxing(kTwoTerms);
    constexpr double kRampS = 0.1;
    double t_s = 0.0;
    for (const double at_s : {0.1, 0.12, 0.2, 0.5, 1.2, 5.0}) {
      const double now_s = at_s < 0.2 || step_s > 1e-4 ? step_s : 1e-3;
      while (t_s < at_s - 1e-9) {
        const double dt_s = std::min(now_s, at_s - t_s);
        t_s += dt_s;
        relaxing.MoveTo(2.0 * std::min(1.0, t_s / kRampS), dt_s);
      }
      const double share = RampThenHold(kTwoTerms, kRampS, t_s);
      for (int i = 0; i < 4; ++i) {
        EXPECT_NEAR(relaxing.contact.ForceN(i), share * elastic.contact.ForceN(i), 1e-10)
            << at_s << " s in steps of " << step_s;
        EXPECT_NEAR(relaxing.contact.DisplacementMm(i), 2.0, 1e-12);
      }
    }
  }
}

TEST(PlaneRelaxation, AHeldForceCreepsByTheRetardationOfOneTerm) {
  constexpr double kShare = 0.6, kTimeS = 0.4, kHeldN = 1.5;
  const auto error_of = [&](double step_s) {
    MovedNodes nodes(SeriesOf({{kShare, kTimeS}}));
    double worst = 0.0;
    double t_s = 0.0;
    double duration_s = 1e-9;  // The force begins at once.
    while (t_s < 3.0) {
      nodes.contact.Pass(duration_s);
      for (int i = 0; i < 4; ++i) nodes.contact.SetDemand(i, 0.0, i == 0 ? kHeldN : 0.0, 0.0);
      EXPECT_TRUE(nodes.contact.Solve(1e-10));
      t_s += duration_s;
      duration_s = step_s;
      const double left = 1.0 - kShare;
      const double crept = 1.0 / left - kShare / left * std::exp(-left * t_s / kTimeS);
      EXPECT_NEAR(nodes.contact.ForceN(0), kHeldN, 1e-12);
      worst = std::max(worst, std::abs(nodes.contact.DisplacementMm(0) - crept * kHeldN * 0.8));
    }
    return worst;
  };
  const double coarse = error_of(0.02), fine = error_of(0.01);
  EXPECT_LT(error_of(0.001), 2e-6);
  EXPECT_NEAR(coarse / fine, 4.0, 0.3);  // Second order.
}

TEST(PlaneRelaxation, KeepsTheBitsOfElasticTissueWithoutASeries) {
  RandomStream random(3, "demands");
  MovedNodes with, without;
  for (int n = 0; n < 500; ++n) {
    with.contact.Pass(random.Uniform(1e-5, 1.0));
    for (int i = 0; i < 4; ++i) {
      const double target_mm = random.Uniform(-1.0, 1.0), bound_n = random.Uniform(0.0, 2.0);
      with.contact.SetDemand(i, target_mm, -bound_n, bound_n);
      without.contact.SetDemand(i, target_mm, -bound_n, bound_n);
    }
    ASSERT_EQ(with.contact.Solve(1e-10), without.contact.Solve(1e-10));
    for (int i = 0; i < 4; ++i) EXPECT_EQ(with.contact.ForceN(i), without.contact.ForceN(i));
  }
}

TEST(PlaneRelaxation, HardTimesAndStepsStayBetweenSlowAndFastTissue) {
  const mechanics::Relaxation hard =
      SeriesOf({{0.4, 1e-6}, {0.3, 1e6}, {0.2, 1e-3}, {0.0999, 1.0}});
  MovedNodes elastic;
  elastic.MoveTo(1.0, 1.0);
  for (const double step_s : {1e-5, 1e-3, 1.0}) {
    MovedNodes nodes(hard);
    nodes.MoveTo(1.0, step_s);
    double before = 1.0;
    for (int n = 1; n < 5000; ++n) {
      nodes.MoveTo(1.0, step_s);
      const double share = nodes.contact.ForceN(0) / elastic.contact.ForceN(0);
      ASSERT_LE(share, before + 1e-9);
      before = share;
    }
    // All that is faster than the hold is gone, and what takes 1e6 s has hardly begun.
    const double held_s = 5000 * step_s;
    EXPECT_NEAR(before, RampThenHold(hard, step_s, held_s), 1e-9) << step_s;
    nodes.MoveTo(-50.0, step_s);
    nodes.MoveTo(50.0, step_s);
    EXPECT_TRUE(std::isfinite(nodes.contact.ForceN(0)));
    EXPECT_LE(std::abs(nodes.contact.ForceN(0)), 101.0 * elastic.contact.ForceN(0));
  }
}

TEST(PlaneRelaxation, NeverGivesBackMoreThanItTook) {
  RandomStream random(11, "strokes");
  MovedNodes nodes(kTwoTerms);
  double at_mm = 0.0, work_n_mm = 0.0, least_n_mm = 0.0;
  std::array<double, 4> before_n{};
  for (int stroke = 0; stroke < 2000; ++stroke) {
    const double target_mm = stroke % 3 == 2 ? at_mm : random.Uniform(-2.0, 2.0);
    for (int k = 0; k < 40; ++k) {
      const double to_mm = at_mm + (target_mm - at_mm) / (40 - k);
      nodes.contact.Pass(0.002);
      // Slots 0 and 1 stick by as much as friction can hold, 2 and 3 wholly.
      for (int i = 0; i < 4; ++i) {
        nodes.contact.SetDemand(i, to_mm, i < 2 ? -0.4 : -kFree, i < 2 ? 0.4 : kFree);
      }
      ASSERT_TRUE(nodes.contact.Solve(1e-10));
      for (int i = 0; i < 4; ++i) {
        work_n_mm += 0.5 * (before_n[i] + nodes.contact.ForceN(i)) * (to_mm - at_mm);
        before_n[i] = nodes.contact.ForceN(i);
      }
      at_mm = to_mm;
      least_n_mm = std::min(least_n_mm, work_n_mm);
    }
  }
  EXPECT_GT(least_n_mm, -1e-9);
  EXPECT_GT(work_n_mm, 100.0);
}

PlaneModel2010 TimedPlane(const mechanics::Relaxation& relaxation,
                          const forces::ForceTable& table = testing_support::RoundForces()) {
  const Layers layers{{{0, "skin"}, {2, "fat"}}};
  mechanics::ElasticityTable elasticity = testing_support::RoundElasticity();
  elasticity.relaxation = relaxation;
  return PlaneModel2010({}, {}, table, testing_support::Trocar18(), elasticity, layers.At());
}

TEST(PlaneRelaxation, PressedSkinFallsByTheSeriesAndShowsTheSameDimple) {
  const PlaneModel2010 elastic = TimedPlane({}), relaxing = TimedPlane(kTwoTerms);
  ModelInsertion<PlaneModel2010> still{elastic}, falling{relaxing};
  still.MoveToDepth(2.0, 20.0);
  falling.MoveToDepth(2.0, 20.0);
  const double pressed_s = 0.1;
  for (const double held_s : {0.01, 0.1, 0.4, 1.0, 4.0}) {
    ModelInsertion<PlaneModel2010> held = falling;
    const int steps = static_cast<int>(std::lround(held_s / 0.001));
    for (int n = 0; n < steps; ++n) held.StepTo(held.tip_mm);
    const double share = RampThenHold(kTwoTerms, pressed_s, pressed_s + held_s);
    EXPECT_NEAR(held.last.puncture_n, share * still.last.puncture_n, 1e-6) << held_s;
    EXPECT_NEAR(held.state.contact.DisplacementMm(0), still.state.contact.DisplacementMm(0), 1e-9);
    TissueLoad shown, shown_elastic;
    relaxing.LoadOf(held.state, shown);
    elastic.LoadOf(still.state, shown_elastic);
    EXPECT_LT((shown.point[0].force_in_ct_n - shown_elastic.point[0].force_in_ct_n).norm(), 1e-6);
  }
}

TEST(PlaneRelaxation, SlowHandsPressDeeperBeforeThePuncture) {
  const PlaneModel2010 elastic = TimedPlane({}), model = TimedPlane(SeriesOf({{0.5, 2.0}}));
  const auto punctured_mm = [&](const PlaneModel2010& of, double speed_mm_per_s) {
    ModelInsertion<PlaneModel2010> insertion{of};
    while (insertion.Count(forces::NeedleEvent::kPuncture) == 0 && insertion.tip_mm.z() < 60.0) {
      insertion.StepTo(insertion.tip_mm + Eigen::Vector3d(0, 0, 0.01), 0.01 / speed_mm_per_s);
    }
    return insertion.tip_mm.z();
  };
  const double elastic_mm = punctured_mm(elastic, 100.0);
  EXPECT_NEAR(punctured_mm(model, 10000.0), elastic_mm, 0.02);
  // f = k (z / 2 + v tau / 2) in a slow ramp: half is gone, save what the last 2 s pressed.
  const double slow_mm = punctured_mm(model, 0.1);
  EXPECT_NEAR(slow_mm, 2.0 * elastic_mm - 0.1 * 2.0, 0.02);
}

TEST(PlaneRelaxation, TissueThatComesBackLateDoesNotJumpWhenTheNeedleIsWithdrawn) {
  const PlaneModel2010 model = TimedPlane(kTwoTerms);
  ModelInsertion<PlaneModel2010> insertion{model};
  insertion.MoveToDepth(40.0, 40.0);
  for (int n = 0; n < 3000; ++n) insertion.StepTo(insertion.tip_mm);
  double before_n = insertion.last.force_in_ct_n.z(), largest_n = 0.0;
  while (insertion.tip_mm.z() > 1.0) {
    insertion.StepTo(insertion.tip_mm - Eigen::Vector3d(0, 0, 0.02));
    const double now_n = insertion.last.force_in_ct_n.z();
    largest_n = std::max(largest_n, std::abs(now_n - before_n));
    before_n = now_n;
  }
  EXPECT_LT(largest_n, 0.05);
  insertion.MoveToDepth(-3.0, 40.0);
  EXPECT_EQ(insertion.last.force_in_ct_n.norm(), 0.0);
  EXPECT_FALSE(insertion.state.in_body());
}

TEST(PlaneRelaxation, NoClosedStrokeOfTheNeedleGivesWork) {
  const PlaneModel2010 model = TimedPlane(kTwoTerms);
  for (const double stroke_mm : {0.05, 0.5, 4.0}) {
    ModelInsertion<PlaneModel2010> insertion{model};
    insertion.MoveToDepth(30.0);
    insertion.MoveToDepth(30.0 - stroke_mm);
    for (int n = 0; n < 4; ++n) {  // What the insertion has stored comes back at first.
      insertion.MoveToDepth(30.0);
      insertion.MoveToDepth(30.0 - stroke_mm);
    }
    insertion.work_n_mm = 0.0;
    for (int n = 0; n < 4; ++n) {
      insertion.MoveToDepth(30.0);
      insertion.MoveToDepth(30.0 - stroke_mm);
    }
    EXPECT_GT(insertion.work_n_mm, 0.0) << stroke_mm;
  }
}

forces::ForceTable TimedForces(double rate, double dwell) {
  forces::ForceTable table = testing_support::RoundForces();
  table.num_times = 2;
  table.times[1].friction_rate = rate;
  table.times[1].friction_dwell = dwell;
  for (const char* tissue : {"skin", "fat"}) {
    const volume::Label label = volume::LabelOf(tissue);
    table.tissue[label].time = table.times[1];
    table.time_of[label] = 1;
  }
  return table;
}

TEST(PlaneFriction, GrowsWithTheLogarithmOfSpeedAndOfRest) {
  const PlaneModel2010 plain = TimedPlane({}), timed = TimedPlane({}, TimedForces(0.1, 0.08));
  const forces::FrictionTime& time = timed.table().friction_time;
  for (const double speed_mm_per_s : {2.0, 5.0, 50.0}) {
    ModelInsertion<PlaneModel2010> of_plain{plain}, of_timed{timed};
    of_plain.MoveToDepth(50.0, speed_mm_per_s);
    of_timed.MoveToDepth(50.0, speed_mm_per_s);
    const double share = 1.0 + 0.1 * time.RateLog(speed_mm_per_s) +
                         0.08 * time.DwellLog(time.slip_mm / speed_mm_per_s);
    EXPECT_NEAR(of_timed.last.friction_n / of_plain.last.friction_n, share, 2e-3) << speed_mm_per_s;
  }
  const auto peak_n = [&](double rest_s) {
    ModelInsertion<PlaneModel2010> insertion{timed};
    insertion.MoveToDepth(50.0, 5.0);
    const double sliding_n = insertion.last.friction_n;
    for (double t_s = 0.0; t_s < rest_s; t_s += 0.01) insertion.StepTo(insertion.tip_mm, 0.01);
    insertion.MoveToDepth(35.0, 5.0);
    double peak = 0.0;
    for (const forces::NeedleForce& force : insertion.log) peak = std::min(peak, force.friction_n);
    return -peak / sliding_n;
  };
  EXPECT_GT(peak_n(60.0), peak_n(0.1) + 0.05);
  EXPECT_LT(peak_n(60.0), 1.0 + 0.08 * time.DwellLog(60.0) + 0.01);
}

}  // namespace
}  // namespace acus::tissue
