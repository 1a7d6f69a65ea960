#include "acus/physics/forces/laws/tissue_time.h"

#include <cmath>
#include <gmock/gmock.h>

#include "acus/base/core/error.h"
#include "acus/base/core/random.h"
#include "acus/physics/forces/laws/shaft_friction.h"
#include "unit/physics/forces/layered_body.h"

namespace acus::forces {
namespace {

constexpr double kTimeS = 0.8;

TEST(CreptMm, FollowsTheClosedFormsOfAMaxwellBranch) {
  // From rest at constant speed: y = v tau (1 - exp(-t / tau)).
  const double pressed_mm = 6.0 - CreptMm(0.0, {0.0, 6.0, 1.2}, 0.0, kTimeS);
  EXPECT_NEAR(pressed_mm, 5.0 * kTimeS * (1.0 - std::exp(-1.2 / kTimeS)), 1e-12);
  // Held: y = y0 exp(-t / tau), also over an hour.
  EXPECT_NEAR(6.0 - CreptMm(2.0, {6.0, 6.0, 0.5}, 0.0, kTimeS), 4.0 * std::exp(-0.5 / kTimeS),
              1e-12);
  EXPECT_NEAR(CreptMm(2.0, {6.0, 6.0, 3600.0}, 0.0, kTimeS), 6.0, 1e-12);
  // Drawn back at 10 mm/s from y = 1 mm: off after tau ln(1 + y / (v tau)), then home.
  const double off_s = kTimeS * std::log1p(1.0 / (10.0 * kTimeS));
  const double off_mm = 6.0 - 10.0 * off_s;
  EXPECT_NEAR(CreptMm(5.0, {6.0, 1.0, 0.5}, 0.0, kTimeS),
              off_mm * std::exp(-(0.5 - off_s) / kTimeS), 1e-12);
}

// Pressed, held, drawn back, pressed again before it has recovered: however the way is cut.
TEST(CreptMm, DoesNotDependOnTheStep) {
  struct Part {
    double to_mm, duration_s;
  };
  const std::vector<Part> parts = {{4.0, 0.8}, {4.0, 1.5}, {0.5, 0.35}, {3.0, 0.5}, {6.0, 0.006}};
  std::vector<std::vector<double>> ends;
  for (const double dt_s : {0.0001, 0.001, 0.01}) {
    double rest_mm = 0.0;
    double at_mm = 0.0;
    std::vector<double>& end = ends.emplace_back();
    for (const Part& part : parts) {
      const int steps = static_cast<int>(std::ceil(part.duration_s / dt_s));
      const double from_mm = at_mm;
      for (int i = 1; i <= steps; ++i) {
        const double to_mm = from_mm + (part.to_mm - from_mm) * i / steps;
        rest_mm = CreptMm(rest_mm, {at_mm, to_mm, part.duration_s / steps}, 0.0, kTimeS);
        at_mm = to_mm;
      }
      end.push_back(rest_mm);
    }
  }
  for (std::size_t i = 0; i < parts.size(); ++i) {
    EXPECT_NEAR(ends[0][i], ends[2][i], 1e-4) << i;
    EXPECT_NEAR(ends[0][i], ends[1][i], 1e-5) << i;
  }
  EXPECT_GT(ends[0][2], 0.5);  // Off the tip, and not yet home.
}

// A linear spring behind such a branch: y v - d(y^2 / 2)/dt is never below 0.
TEST(CreptMm, NeverGivesBackMoreThanItTook) {
  RandomStream random(5, "creep");
  double rest_mm = 0.0;
  double at_mm = 0.0;
  double taken = 0.0;
  double least = 0.0;
  for (int i = 0; i < 20'000; ++i) {
    const double target_mm = random.Uniform(-2.0, 6.0);
    const double hold = random.Uniform() < 0.3 ? 0.0 : 1.0;
    for (int k = 0; k < 50; ++k) {
      const double to_mm = at_mm + hold * (target_mm - at_mm) / (50 - k);
      const double before = std::max(0.0, at_mm - rest_mm);
      rest_mm = CreptMm(rest_mm, {at_mm, to_mm, 0.004}, 0.0, kTimeS);
      ASSERT_GE(rest_mm, 0.0);
      taken += 0.5 * (before + std::max(0.0, to_mm - rest_mm)) * (to_mm - at_mm);
      at_mm = to_mm;
      least = std::min(least, taken);
    }
  }
  EXPECT_GT(least, -1e-9);
  EXPECT_GT(taken, 100.0);
}

/// One tissue of 0.02 N/mm in and 0.01 out.
ForceTable TimedTable(const char* time, const char* settings = "{}") {
  const std::string text = std::string(R"({"format": "acus-forces/1", "friction_time": )") +
                           settings + R"(, "tissues": [{"tissue": "soft_tissue", "source": "test",
      "friction_n_per_mm": 0.02, "withdrawal_friction_n_per_mm": 0.01, )" +
                           time + "}]}";
  return ForceTableFromJson(nlohmann::json::parse(text), "timed");
}

/// 50 mm of shaft, so that full friction is 1 N on the way in and 0.5 N out.
struct Shaft {
  ShaftFriction law;
  NeedlePath path{};
  ShaftFrictionState state{};

  explicit Shaft(const ForceTable& table) : law(table) {
    path.Append(volume::LabelOf("soft_tissue"), 0.02, 0.01);
    path.ExtendTo(50.0);
  }
  double Move(double speed_mm_per_s, double duration_s, double dt_s = 0.001) {
    const int steps = static_cast<int>(std::lround(duration_s / dt_s));
    for (int i = 0; i < steps; ++i) law.Slide(state, speed_mm_per_s * dt_s, dt_s);
    return law.ForceN(state, path, 50.0);
  }
};

TEST(ShaftFriction, RelaxesInAHoldAndRecovers) {
  const ForceTable table =
      TimedTable(R"("relaxation": [{"share": 0.3, "time_s": 1}, {"share": 0.2, "time_s": 10}])");
  Shaft shaft(table);
  EXPECT_NEAR(shaft.Move(5.0, 4.0), 1.0, 1e-9);  // The row's friction is that at 5 mm/s.
  for (const double held_s : {0.5, 2.0, 30.0}) {
    Shaft held = shaft;
    const double expected = 0.5 + 0.3 * std::exp(-held_s) + 0.2 * std::exp(-0.1 * held_s);
    EXPECT_NEAR(held.Move(0.0, held_s), expected, 1e-9) << held_s;
    EXPECT_NEAR(held.Move(5.0, 4.0), 1.0, 1e-9);
    EXPECT_NEAR(held.Move(-5.0, 4.0), -0.5, 1e-9);
  }
  // Too slow for the fast branch: strain v tau / b = 0.2 of it.
  EXPECT_NEAR(shaft.Move(-0.1, 40.0), -0.5 * (0.5 + 0.3 * 0.2 + 0.2), 1e-3);
}

TEST(ShaftFriction, GrowsWithTheLogarithmOfSpeed) {
  const ForceTable table = TimedTable(R"("friction_rate": 0.1)");
  for (const double speed_mm_per_s : {0.01, 1.0, 5.0, 40.0, 1000.0}) {
    Shaft shaft(table);
    const double expected = 1.0 + 0.1 * std::log((speed_mm_per_s + 0.1) / 5.1);
    EXPECT_NEAR(shaft.Move(speed_mm_per_s, 0.3 + 6.0 / speed_mm_per_s), expected, 2e-4)
        << speed_mm_per_s;
  }
}

// After a rest the friction is the larger the longer the rest, and the slip takes it off again.
TEST(ShaftFriction, GrowsWithTheLogarithmOfRestUntilItHasSlid) {
  const ForceTable table =
      TimedTable(R"("friction_dwell": 0.1)", R"({"slip_mm": 20, "least_mm_per_s": 0.1})");
  double before = 1.0;
  for (const double rest_s : {1.0, 10.0, 100.0, 3600.0}) {
    Shaft shaft(table);
    EXPECT_NEAR(shaft.Move(5.0, 40.0), 1.0, 1e-4);
    EXPECT_NEAR(shaft.Move(0.0, rest_s, 0.1), 1.0, 1e-4);  // At rest nothing pushes.
    double peak = 0.0;
    for (int i = 0; i < 2000; ++i) peak = std::max(peak, shaft.Move(5.0, 0.001));
    // The bristles (0.5 mm) follow before the slip (20 mm) has taken much off.
    const double age_s = 4.0 + rest_s;
    EXPECT_NEAR(peak, 1.0 + 0.1 * std::log((age_s + 1.0) / 5.0), 0.06 * (peak - 1.0)) << rest_s;
    EXPECT_GT(peak, before);
    before = peak;
    EXPECT_NEAR(shaft.Move(5.0, 60.0), 1.0, 1e-4);
  }
  EXPECT_LT(before, 1.8);
}

constexpr const char* kAllOfIt =
    R"("relaxation": [{"share": 0.4, "time_s": 0.7}], "friction_rate": 0.1, "friction_dwell": 0.1)";

TEST(ShaftFriction, IsBoundedFromStandstillToAMetrePerSecondAndAnHourOfRest) {
  const ForceTable table = TimedTable(kAllOfIt);
  const double most = 2.33;  // 1 + 0.1 ln(1000.1 / 5.1) + 0.1 ln(3601 / 1.2).
  for (const double dt_s : {0.0001, 0.001, 0.01, 0.5}) {
    Shaft shaft(table);
    shaft.Move(0.0, 3600.0, 1800.0);
    for (const double speed_mm_per_s : {1000.0, -1000.0, 0.001, -30.0, 500.0}) {
      for (int i = 0; i < 300; ++i) {
        const double force_n = shaft.Move(speed_mm_per_s, dt_s, dt_s);
        ASSERT_TRUE(force_n > -0.5 * most && force_n < most) << dt_s << " " << speed_mm_per_s;
      }
    }
  }
}

TEST(ShaftFriction, DoesNotDependOnTheSamples) {
  const ForceTable table = TimedTable(kAllOfIt);
  for (const auto& [speed_mm_per_s, rest_s] :
       {std::pair{0.5, 1.0}, {5.0, 30.0}, {50.0, 600.0}, {1000.0, 3600.0}}) {
    std::vector<std::vector<double>> forces;
    for (const double dt_s : {0.0001, 0.001, 0.01}) {
      Shaft shaft(table);
      std::vector<double>& force = forces.emplace_back();
      force.push_back(shaft.Move(speed_mm_per_s, 0.2, dt_s));
      force.push_back(shaft.Move(0.0, rest_s, rest_s / 100.0));
      force.push_back(shaft.Move(speed_mm_per_s, 0.02, dt_s));
      force.push_back(shaft.Move(-speed_mm_per_s, 0.4, dt_s));
    }
    for (std::size_t i = 0; i < forces[0].size(); ++i) {
      EXPECT_NEAR(forces[1][i], forces[0][i], 0.005) << speed_mm_per_s << " mm/s, part " << i;
      EXPECT_NEAR(forces[2][i], forces[0][i], 0.02) << speed_mm_per_s << " mm/s, part " << i;
    }
  }
}

TEST(ShaftFriction, AnEncodersJitterIsNeitherSpeedNorSlip) {
  Shaft still(TimedTable(R"("friction_dwell": 0.1)"));
  const double slid_n = still.Move(5.0, 4.0);
  for (int i = 0; i < 20'000; ++i) still.Move(i % 2 == 0 ? -4.0 : 4.0, 0.001);
  EXPECT_NEAR(still.Move(0.0, 0.001), slid_n, 1e-9);
  EXPECT_LT(std::abs(still.state.speed_mm_per_s), 1e-6);
  EXPECT_GT(still.state.age_s, 19.0);
}

// Random strokes and rests: the bristles never give back more than they took, by any limit.
TEST(ShaftFriction, GivesNoEnergyToARandomHand) {
  for (const char* time : {R"("friction_rate": 0.15)", R"("friction_dwell": 0.15)", kAllOfIt}) {
    Shaft shaft(TimedTable(time));
    RandomStream random(11, "strokes");
    double taken_mj = 0.0;
    double least_mj = 0.0;
    double force_n = 0.0;
    for (int stroke = 0; stroke < 3000; ++stroke) {
      const double speed_mm_per_s =
          random.Uniform() < 0.3 ? 0.0 : random.Normal() * std::exp(random.Uniform(-2.0, 4.0));
      const double steps = random.Uniform(5.0, 400.0);
      for (int i = 0; i < static_cast<int>(steps); ++i) {
        // The shaft stays as deep: only its bristles store energy.
        const double dt_s = std::min(0.001, 0.02 / std::max(0.1, std::abs(speed_mm_per_s)));
        const double now_n = shaft.Move(speed_mm_per_s, dt_s, dt_s);
        taken_mj += 0.5 * (force_n + now_n) * speed_mm_per_s * dt_s;
        force_n = now_n;
        least_mj = std::min(least_mj, taken_mj);
      }
    }
    EXPECT_GT(least_mj, -1e-4) << time;
    EXPECT_GT(taken_mj, 100.0) << time;
  }
}

TEST(ForceTable, RefusesTimesThatLeaveNothing) {
  const auto message = [](const char* time, const char* settings = "{}") -> std::string {
    try {
      TimedTable(time, settings);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(message(kAllOfIt), "");
  EXPECT_THAT(
      message(R"("relaxation": [{"share": 0.6, "time_s": 1}, {"share": 0.5, "time_s": 9}])"),
      testing::HasSubstr("/tissues/0/relaxation: the shares sum to 1.1; allowed: up to 0.95"));
  EXPECT_THAT(message(R"("friction_rate": 0.5)"),
              testing::HasSubstr("/tissues/0: friction_rate 0.5 and friction_dwell 0 leave -0.9"));
  EXPECT_THAT(message(R"("relaxation": [{"share": 0.2, "time_s": 0}])"),
              testing::HasSubstr("/tissues/0/relaxation/0/time_s"));
}

TEST(ForceTable, HasAtMostSixteenDifferentTimes) {
  nlohmann::json table = {{"format", "acus-forces/1"}, {"tissues", nlohmann::json::array()}};
  for (int label = 1; label < 20; ++label) {
    const std::string name(volume::StandardLabels()[label].name);
    table["tissues"].push_back({{"tissue", name},
                                {"source", "test"},
                                {"friction_rate", label < 16 ? 0.001 * label : 0.0}});
  }
  EXPECT_EQ(ForceTableFromJson(table, "many").num_times, 16);
  table["tissues"][17]["friction_rate"] = 0.1;
  EXPECT_THROW(ForceTableFromJson(table, "many"), InputError);
}

}  // namespace
}  // namespace acus::forces
