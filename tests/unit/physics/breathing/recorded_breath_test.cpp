#include "acus/physics/breathing/recorded_breath.h"

#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <numbers>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "support/fuzz.h"
#include "support/temporary_folder.h"

namespace acus::breathing {
namespace {

constexpr double kPeriodS = 3.2;

double Level(double t) {
  return 20.0 + 5.0 * std::cos(2.0 * std::numbers::pi * t / kPeriodS);
}

BreathSignal Sine(double duration_s, double step_s = 0.01) {
  BreathSignal signal{.start_s = 0.0, .step_s = step_s, .level = {}};
  for (double t = 0.0; t <= duration_s; t += step_s) signal.level.push_back(Level(t));
  return signal;
}

TEST(RecordedBreath, FindsLevelRateAndCycleOfASine) {
  const RecordedBreath breath(Sine(30.0), {.smoothing_s = 0.05});
  EXPECT_EQ(breath.num_breaths(), 8);
  EXPECT_NEAR(breath.inspiration_level(), 25.0, 0.05);
  EXPECT_NEAR(breath.expiration_level(), 15.0, 0.05);
  for (double t = 1.0; t < 28.0; t += 0.31) {
    const Breath at = breath.At(t);
    EXPECT_NEAR(at.level, Level(t), 0.05);
    const double rate =
        -5.0 * 2.0 * std::numbers::pi / kPeriodS * std::sin(2.0 * std::numbers::pi * t / kPeriodS);
    EXPECT_NEAR(at.level_per_s, rate, 0.1);
    const double cycle = t / kPeriodS - std::floor(t / kPeriodS);
    const double off = std::abs(at.cycle - cycle);
    EXPECT_LT(std::min(off, 1.0 - off), 0.01) << t;
  }
}

TEST(RecordedBreath, NormalisedItsMedianBreathRunsFromOneToZero) {
  const RecordedBreath breath(Sine(30.0), {.smoothing_s = 0.05});
  EXPECT_NEAR(breath.Normalised(breath.At(kPeriodS)).level, 1.0, 0.01);
  EXPECT_NEAR(breath.Normalised(breath.At(1.5 * kPeriodS)).level, 0.0, 0.01);
  const Breath falling = breath.Normalised(breath.At(1.25 * kPeriodS));
  EXPECT_NEAR(falling.level_per_s, -std::numbers::pi / kPeriodS, 0.02);
}

TEST(RecordedBreath, IsHeldAfterItsEndOrGoesRoundWithoutAStep) {
  const RecordedBreath held(Sine(30.0), {});
  EXPECT_EQ(held.At(1000.0).level, held.At(30.0).level);
  EXPECT_EQ(held.At(1000.0).level_per_s, 0.0);
  const RecordedBreath round(Sine(30.7), {.repeat = true});
  double before = round.At(0.0).level;
  for (double t = 0.0; t < 3.0 * round.duration_s(); t += 0.005) {
    const double level = round.At(t).level;
    ASSERT_LT(std::abs(level - before), 0.15) << t;
    before = level;
  }
}

TEST(RecordedBreath, RefusesASignalWithoutBreaths) {
  EXPECT_THROW(RecordedBreath(Sine(3.0), {}), InputError);
  EXPECT_THROW(RecordedBreath(Sine(5.5), {.repeat = true}), InputError);
  EXPECT_THROW(RecordedBreath(Sine(30.0), {.smoothing_s = 0.0}), InputError);
  EXPECT_THROW(RecordedBreath(Sine(30.0), {.smoothing_s = 5.1}), InputError);
}

class SignalFile : public testing::Test {
 protected:
  std::filesystem::path Write(const std::string& text) {
    const auto path = folder_.path() / "signal.csv";
    WriteTextFile(path, text);
    return path;
  }
  static std::string Csv(double step_s, int count) {
    std::string text = "time_s,belt,skin_mm\n";
    for (int n = 0; n < count; ++n) {
      text += Message(step_s * n, ",", n % 7, ",", 0.5 * n, "\n");
    }
    return text;
  }
  testing_support::TemporaryFolder folder_;
};

TEST_F(SignalFile, ReadsCsvByColumn) {
  const auto path = Write(Csv(0.1, 20));
  EXPECT_NEAR(ReadBreathSignal(path, {}).level[3], 3.0, 1e-12);
  const BreathSignal skin = ReadBreathSignal(path, {.column = "skin_mm"});
  EXPECT_NEAR(skin.level[3], 1.5, 1e-12);
  EXPECT_NEAR(skin.step_s, 0.1, 1e-12);
  EXPECT_EQ(skin.level.size(), 20U);
}

TEST_F(SignalFile, ReadsPlainColumnsWithTheirRateOrOurs) {
  std::string text = "# Sampling Rate (Hz):= 50.00\n";
  for (int n = 0; n < 20; ++n) text += Message(n, " ", -n, "\n");
  const auto path = Write(text);
  EXPECT_EQ(ReadBreathSignal(path, {}).step_s, 0.02);
  EXPECT_EQ(ReadBreathSignal(path, {.column = "1", .rate_hz = 10}).level[4], -4.0);
  EXPECT_EQ(ReadBreathSignal(path, {.column = "1", .rate_hz = 10}).step_s, 0.1);
  EXPECT_THROW(ReadBreathSignal(path, {.column = "2"}), InputError);
}

TEST_F(SignalFile, SaysWhatIsWrong) {
  const auto message = [&](const std::string& text, const SignalFileOptions& options = {}) {
    try {
      ReadBreathSignal(Write(text), options);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("no error");
  };
  using testing::HasSubstr;
  EXPECT_THAT(message(Csv(0.1, 15)), HasSubstr("15 samples"));
  EXPECT_THAT(message(Csv(0.1, 20) + "3.0,1,1\n"), HasSubstr("gap of 1.1 s"));
  EXPECT_THAT(message(Csv(0.1, 20) + "1.9,1,1\n"), HasSubstr("not later"));
  EXPECT_THAT(message("1\n2\n3\n"), HasSubstr("sampling rate"));
  EXPECT_THAT(message("1 2\n3\n", {.column = "", .rate_hz = 10}),
              HasSubstr("1 numbers in this row"));
  EXPECT_THAT(message("1\nx\n", {.column = "", .rate_hz = 10}), HasSubstr("'x'"));
  EXPECT_THAT(message("", {.column = "", .rate_hz = 10}), HasSubstr("no numbers"));
  std::string constant;
  for (int n = 0; n < 40; ++n) constant += "2094\n";
  EXPECT_THAT(message(constant, {.column = "", .rate_hz = 10}), HasSubstr("no breathing"));
}

TEST_F(SignalFile, SurvivesDamage) {
  const auto path = folder_.path() / "signal.csv";
  for (const std::string& valid :
       {Csv(0.1, 60), "# Sampling Rate (Hz):= 50\n" + Csv(1, 60).substr(20)}) {
    testing_support::ReadDamagedCopies(valid, path, 300, [&] { ReadBreathSignal(path, {}); });
  }
}

}  // namespace
}  // namespace acus::breathing
