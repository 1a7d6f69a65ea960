// What a session can throw at each force model: bounded, finite, repeatable, and the same at any
// rate.
#include <algorithm>
#include <cstdio>
#include <gmock/gmock.h>
#include <numbers>

#include "acus/physics/forces/models/force_model.h"
#include "support/allocation_counter.h"
#include "support/bound.h"
#include "support/force_scenes.h"
#include "support/stability_length.h"
#include "support/wild_hand.h"

namespace acus::forces {
namespace {

using Eigen::Vector3d;
using testing_support::Abdomen;
using testing_support::AtMost;
using testing_support::Below;
using testing_support::BoundPlot;
using testing_support::Driven;
using testing_support::DrivenAlamilla;
using testing_support::DrivenLayered;
using testing_support::DrivenProbe;
using testing_support::DrivenVidal;
using testing_support::Exactly;
using testing_support::HardCase;
using testing_support::Largest;
using testing_support::LayeredBodyField;
using testing_support::SameBits;
using testing_support::ShippedTable;
using testing_support::Trocar18G;
using testing_support::WildHand;

/// Each test for each model with the table that is made for it.
template <typename T>
struct Kind;
template <>
struct Kind<DrivenLayered> {
  static constexpr const char* kTable = "bovine_2021.json";
  static constexpr const char* kName = "layered";
  static NeedleForceModel Make(const ForceTable& table, const HuField&) {
    return NeedleForceModel(table, Trocar18G());
  }
};
template <>
struct Kind<DrivenAlamilla> {
  static constexpr const char* kTable = "alamilla.json";
  static constexpr const char* kName = "alamilla";
  static AlamillaModel Make(const ForceTable& table, const HuField&) {
    return AlamillaModel(table, Trocar18G());
  }
};
template <>
struct Kind<DrivenVidal> {
  static constexpr const char* kTable = "vidal.json";
  static constexpr const char* kName = "vidal";
  static VidalModel Make(const ForceTable& table, const HuField& field) {
    return VidalModel(table, Trocar18G(), field);
  }
};

template <typename D>
class EveryModel : public testing::Test {
 protected:
  const ForceTable table = ShippedTable(Kind<D>::kTable);
  const LayeredBodyField body = Abdomen();
  const decltype(Kind<D>::Make(table, body)) model = Kind<D>::Make(table, body);
  D New() const { return D{model, body}; }
  static std::string Of(const std::string& what) { return what + ", " + Kind<D>::kName; }
};
using Models = testing::Types<DrivenLayered, DrivenAlamilla, DrivenVidal>;
TYPED_TEST_SUITE(EveryModel, Models);

TYPED_TEST(EveryModel, HalfAMillionRandomStepsStayFiniteAndBounded) {
  const HardCase hard(
      "Tremor, pushes, jumps of 50 mm, turns, lost poses, NaN, time that goes back.");
  const double bound_n = this->table.settings.largest_force_n * (1.0 + 1e-12);
  const int num_steps = testing_support::StabilitySteps(500'000);
  Largest largest_n;
  Largest off_unit;
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    WildHand hand(seed);
    auto driven = this->New();
    for (int i = 0; i < num_steps / 5; ++i) {
      const NeedleForce out = this->model.Step(driven.state, hand.Next());
      ASSERT_TRUE(out.force_in_ct_n.allFinite() && out.torque_in_ct_n_mm.allFinite() &&
                  std::isfinite(out.AxialN()) && std::isfinite(out.depth_mm))
          << seed << " " << i;
      largest_n.Add(out.force_in_ct_n.norm());
      off_unit.Add(std::abs(driven.state.path.direction_in_ct.norm() - 1.0));
      ASSERT_GE(out.bone_n, 0.0);
    }
    EXPECT_GT(driven.state.num_rejected, 0);
    EXPECT_GT(driven.state.num_time_back, 0);
  }
  hard.Expect(this->Of("largest force"), largest_n, AtMost(bound_n), "N");
  hard.Expect(this->Of("length of the path's direction, off one"), off_unit, AtMost(1e-9));
  hard.Note(this->Of("wild steps"), std::to_string(num_steps));
}

TYPED_TEST(EveryModel, TheSameSamplesGiveTheSameBitsAlsoFromASavedState) {
  const HardCase hard("Wild samples twice, and once from a state that was saved on the way.");
  WildHand a(3);
  WildHand b(3);
  auto first = this->New();
  auto second = this->New();
  auto saved = second.state;
  for (int i = 0; i < 30000; ++i) {
    const NeedleInput input = a.Next();
    ASSERT_TRUE(
        SameBits(this->model.Step(first.state, input), this->model.Step(second.state, b.Next())));
    if (i == 20000) saved = first.state;
    if (i > 20000) {
      ASSERT_TRUE(SameBits(this->model.Step(saved, input), second.state.held) || !input.valid ||
                  saved.time_s == second.state.time_s);
    }
  }
  hard.Expect(this->Of("same bits at the end"), SameBits(saved.held, second.state.held),
              Exactly(1));
}

TYPED_TEST(EveryModel, AStepAllocatesNothing) {
  const HardCase hard("Memory taken in a step of 1 ms can make it late.");
  WildHand hand(5);
  auto driven = this->New();
  this->model.Step(driven.state, hand.Next());
  const long before = testing_support::num_allocations;
  for (int i = 0; i < 20000; ++i) this->model.Step(driven.state, hand.Next());
  const long allocated = testing_support::num_allocations - before;
  hard.Expect(this->Of("allocations in 20000 wild steps"), allocated, Exactly(0));
}

TYPED_TEST(EveryModel, ZeroHugeAndReversingSpeeds) {
  const HardCase hard(
      "0 to 1 km/s, reversed at each step of 0.1 to 10 ms: friction is stiff there.");
  Largest largest_n;
  Largest drift_n;
  const double bound_n = this->table.settings.largest_force_n * (1.0 + 1e-12);
  for (const double dt_s : {1e-4, 1e-3, 1e-2}) {
    for (const double speed : {0.0, 1e-9, 1.0, 200.0, 1e4, 1e6}) {
      auto driven = this->New();
      double t = 0.0;
      for (double z = -1.0; z < 25.0; z += 0.05) driven.Step(t += dt_s, {0, 0, z});
      for (int i = 0; i < 400; ++i) {
        const double half_mm = std::min(speed * dt_s, 50.0);
        const NeedleForce& out =
            driven.Step(t += dt_s, {0, 0, 25.0 + (i % 2 == 0 ? half_mm : 0.0)});
        largest_n.Add(out.force_in_ct_n.norm());
      }
      const double last_n = driven.last.AxialN();
      const Vector3d place(0, 0, 25.0);
      for (int i = 0; i < 3000; ++i) driven.Step(t += 1e-3, place);
      const double rest_n = driven.last.AxialN();
      for (int i = 0; i < 1000; ++i) {
        drift_n.Add(std::abs(driven.Step(t += 1e-3, place).AxialN() - rest_n));
      }
      EXPECT_TRUE(std::isfinite(last_n));
    }
  }
  hard.Expect(this->Of("largest force"), largest_n, AtMost(bound_n), "N");
  hard.Expect(this->Of("drift in a second at rest after it"), drift_n, AtMost(1e-9), "N");
}

/// In and out again: skin, tissue, bone, a turn, a way out; smooth, so that samples at any rate are
/// of one motion.
double Scripted(double t) {
  const double from_to[][2] = {{-3, 20},   {20, 20}, {20, 36.5}, {36.5, 36.5},
                               {36.5, 18}, {18, 28}, {28, -4}};
  const int part = std::min(6, static_cast<int>(t));
  const double s = std::clamp(t - part, 0.0, 1.0);
  const double share = s * s * s * (10.0 + s * (-15.0 + 6.0 * s));
  return from_to[part][0] + share * (from_to[part][1] - from_to[part][0]);
}

// The same motion at 500 Hz to 4 kHz against 16 kHz: at 1 kHz within 15 mN RMS and 0.12 N, in
// proportion to the step. It is the place of skin, tissue and bone that a step finds only to its
// half; where a force jumps (puncture, bone), a coarse sample comes up to one step later, and that
// step is left out.
TYPED_TEST(EveryModel, TheRateOfTheStepsDoesNotMatter) {
  const HardCase hard(
      "One motion at 500 Hz to 16 kHz, through skin, tissue and bone and out again.");
  BoundPlot plot{.title = std::string("Difference from 16 kHz, ") + Kind<TypeParam>::kName,
                 .x_label = "rate [Hz]",
                 .y_label = "difference [N]",
                 .log_x = true,
                 .log_y = true,
                 .curves = {{.name = "root mean square"}, {.name = "largest"}}};
  constexpr int kRate = 16000;
  std::vector<double> events_s;
  const auto run = [&](int rate_hz) {
    auto driven = this->New();
    std::vector<NeedleForce> every_10_ms;
    const int per = rate_hz / 100;
    for (int i = 0; i < 700 * per; ++i) {
      const double t = static_cast<double>(i) / rate_hz;
      driven.Step(t, {0.5 * std::sin(t), 0, Scripted(t)});
      if (i % per == 0) every_10_ms.push_back(driven.last);
      if (rate_hz == kRate && driven.last.event != NeedleEvent::kNone) events_s.push_back(t);
    }
    return every_10_ms;
  };
  const std::vector<NeedleForce> reference = run(kRate);
  EXPECT_GE(events_s.size(), 4U);
  for (const int rate_hz : {500, 1000, 2000, 4000}) {
    const std::vector<NeedleForce> forces = run(rate_hz);
    double worst_n = 0.0;
    double sum = 0.0;
    for (std::size_t i = 0; i < forces.size(); ++i) {
      const double t = 0.01 * static_cast<double>(i);
      const double step_s = 1.0 / rate_hz + 1e-9;
      if (std::ranges::any_of(events_s, [&](double e) { return std::abs(t - e) <= step_s; }))
        continue;
      const double off_n = (forces[i].force_in_ct_n - reference[i].force_in_ct_n).norm();
      sum += off_n * off_n;
      worst_n = std::max(worst_n, off_n);
    }
    const double rms_n = std::sqrt(sum / static_cast<double>(forces.size()));
    std::printf("  %-14s %4d Hz: rms %.4f N, worst %.4f N\n", Kind<TypeParam>::kTable, rate_hz,
                rms_n, worst_n);
    hard.Expect(this->Of(Message("root mean square difference from 16 kHz at ", rate_hz, " Hz")),
                rms_n, Below(0.015 * 1000.0 / rate_hz), "N");
    hard.Expect(this->Of(Message("largest difference from 16 kHz at ", rate_hz, " Hz")), worst_n,
                Below(0.12 * 1000.0 / rate_hz), "N");
    plot.curves[0].Add(rate_hz, rms_n);
    plot.curves[1].Add(rate_hz, worst_n);
  }
  hard.Plot(plot);
}

// A force of exactly the threshold is enough, one bit less is not.
TEST(Puncture, ExactlyAtTheThreshold) {
  const HardCase hard("A force of exactly the threshold is enough, one bit less is not.");
  ForceTable table = ShippedTable("alamilla.json");
  const volume::Label skin = volume::LabelOf("skin");
  table.tissue[skin].membrane = {0.25, 0.0, 1.0};  // 4 mm, exactly.
  const AlamillaModel alamilla(table, Trocar18G());
  const NeedleForceModel layered(table, Trocar18G());
  const auto punctured = [&](const auto& model, auto state, double to_mm) {
    // Starting on the skin: the path begins at 0 exactly.
    model.Step(state, {0.0, Vector3d(0, 0, 0), Vector3d::UnitZ(), skin, true});
    return model.Step(state, {0.001, Vector3d(0, 0, to_mm), Vector3d::UnitZ(), skin, true}).event ==
           NeedleEvent::kPuncture;
  };
  const double less_mm = std::nextafter(4.0, 0.0);
  hard.Expect(
      "models of two that puncture at the threshold",
      punctured(alamilla, AlamillaState(), 4.0) + punctured(layered, NeedleForceState(), 4.0),
      Exactly(2));
  hard.Expect("models of two that puncture one bit before",
              punctured(alamilla, AlamillaState(), less_mm) +
                  punctured(layered, NeedleForceState(), less_mm),
              Exactly(0));
}

// Jumps of up to 60 mm through all layers, each searched and split.
TEST(Sweep, AllocatesNothingAndStaysBoundedHoweverFarTheTipJumps) {
  const HardCase hard("Jumps through all layers, every one searched for tissue and split.");
  const LayeredBodyField body = Abdomen();
  volume::Geometry geometry;
  geometry.size = {3, 3, 120};
  geometry.origin_mm = {-1.0, -1.0, -19.5};
  volume::LabelMap labels(geometry);
  for (int k = 0; k < 120; ++k) {
    const volume::Label label = body.LabelAt({0.0, 0.0, k - 19.5});
    std::fill_n(labels.voxels.begin() + 9 * k, 9, label);
  }
  const TissueLookup lookup(labels);
  const ForceModel models[] = {
      ForceModel(NeedleForceModel(ShippedTable("default.json"), Trocar18G())),
      ForceModel(AlamillaModel(ShippedTable("alamilla.json"), Trocar18G())),
      ForceModel(VidalModel(ShippedTable("vidal.json"), Trocar18G(), body))};
  Largest share;
  long allocated = 0;
  for (const ForceModel& model : models) {
    ForceState state = model.NewState();
    PassedEvents events;
    acus::RandomStream random(4, "jumps");
    for (int i = 0; i < 5000; ++i) {
      const Vector3d tip_mm(0.3 * random.Normal(), 0.3 * random.Normal(),
                            random.Uniform(-15.0, 60.0));
      const NeedleInput input{0.01 * i, tip_mm, Vector3d::UnitZ(), lookup.At(tip_mm), true};
      const long before = testing_support::num_allocations;
      const NeedleForce force = model.StepAlong(state, input, {&lookup}, events);
      allocated += testing_support::num_allocations - before;
      share.Add(force.force_in_ct_n.norm() / model.table().settings.largest_force_n);
    }
  }
  hard.Expect("allocations", allocated, Exactly(0));
  hard.Expect("largest force, of its limit", share, AtMost(1.0 + 1e-9));
}

/// Poses that turn as wildly as they move, some of them no rotations.
template <typename Model, typename Driven>
void CheckWildProbe(const HardCase& hard, const std::string& name, const Model& probe) {
  const int num_steps = testing_support::StabilitySteps(50'000);
  Largest largest_n;
  Driven first{probe};
  Driven second{probe};
  WildHand hand(9);
  const long before = testing_support::num_allocations;
  for (int i = 0; i < num_steps; ++i) {
    const NeedleInput needle = hand.Next();
    ProbeInput input;
    input.time_s = needle.time_s;
    input.ct_from_probe.translation() = needle.tip_in_ct_mm;
    input.ct_from_probe.linear() =
        Eigen::AngleAxisd(0.01 * i, Vector3d(1.0, 0.3 * (i % 7), 0.2).normalized())
            .toRotationMatrix();
    if (i % 101 == 0) input.ct_from_probe.linear() *= 1e9;
    if (i % 103 == 0) input.ct_from_probe.linear()(1, 2) = NAN;
    input.valid = needle.valid;
    const ProbeForce a = probe.Step(first.state, input);
    const ProbeForce b = probe.Step(second.state, input);
    ASSERT_TRUE(a.force_in_ct_n.allFinite() && a.torque_in_ct_n_mm.allFinite());
    largest_n.Add(a.force_in_ct_n.norm());
    ASSERT_EQ(a.force_in_ct_n, b.force_in_ct_n);
    ASSERT_EQ(a.torque_in_ct_n_mm, b.torque_in_ct_n_mm);
  }
  const long allocated = testing_support::num_allocations - before;
  hard.Expect("allocations, " + name, allocated, Exactly(0));
  hard.Expect("largest force, " + name, largest_n, AtMost(15.0 * (1.0 + 1e-12)), "N");
  hard.Note("wild steps, " + name, std::to_string(num_steps));
}

TEST(Probe, RandomPosesStayBoundedAndRepeat) {
  const HardCase hard("A probe that turns as wildly as it moves, some poses no rotations at all.");
  const LayeredBodyField body = Abdomen();
  const ForceTable table = ShippedTable("vidal.json");
  CheckWildProbe<VidalProbe, DrivenProbe>(hard, "one proxy", VidalProbe(table, body));
  CheckWildProbe<MultiProxyProbe, testing_support::DrivenPalpation>(
      hard, "16 proxies",
      MultiProxyProbe(table, ProbeFaceNodes(40.0, 12.0, 60.0, 16),
                      testing_support::FieldsOf(table, body)));
}

}  // namespace
}  // namespace acus::forces
