#include "acus/physics/forces/laws/force_curve.h"

#include <cmath>
#include <gmock/gmock.h>
#include <limits>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "acus/base/core/random.h"
#include "acus/base/math/statistics.h"
#include "support/temporary_folder.h"

namespace acus::forces {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

std::filesystem::path Temp(const std::string& name) {
  static const testing_support::TemporaryFolder folder;
  return folder / name;
}

std::string Rows(int count, double rate_hz, const std::function<double(double)>& value) {
  std::string text;
  for (int i = 0; i < count; ++i) {
    const double time = i / rate_hz;
    text += Message(time, ",", value(time), "\n");
  }
  return text;
}

TEST(CurveParameters, AreTheLawsOfTheirPhases) {
  const CurveParameters p{.contact_depth_mm = 5.0,
                          .puncture_depth_mm = 10.0,
                          .plateau_n = 0.6,
                          .plateau_slope_n_per_mm = 0.01};
  EXPECT_EQ(p.AdvanceForceN(4.9), 0.0);
  EXPECT_DOUBLE_EQ(p.AdvanceForceN(15.0), 0.48 + 0.52);  // Alamilla-2021: 10 mm.
  EXPECT_DOUBLE_EQ(p.PunctureForceN(), 1.0);
  EXPECT_DOUBLE_EQ(p.AdvanceForceN(25.0), 0.6 + 0.01 * 10.0);
}

TEST(SynthesizeForceCurve, PassesThroughAllPhases) {
  const CurveParameters truth{.offset_n = 0.25};
  const DrivePlan plan{};
  const ForceCurve curve = SynthesizeForceCurve(truth, plan, 0.0, 1, "clean");
  const auto at = [&](double time_s) { return static_cast<std::size_t>(time_s * 1000.0); };
  EXPECT_EQ(curve.force_n[at(0.5)], 0.25);
  EXPECT_NEAR(curve.force_n[at(1.0 + 15.0 / 5.0)], truth.AdvanceForceN(15.0) + 0.25, 1e-12);
  EXPECT_NEAR(curve.depth_mm[at(1.0 + 15.0 / 5.0)], 15.0, 1e-9);
  const double end_n = truth.AdvanceForceN(60.0);
  EXPECT_NEAR(curve.force_n[at(13.0 + 2.0)], end_n * (1.0 - 0.4 * (1.0 - std::exp(-1.0))) + 0.25,
              1e-9);
  EXPECT_NEAR(curve.force_n[at(23.0 + 30.0 / 5.0)], -0.015 * 25.0 + 0.25, 1e-9);  // 30 mm deep.
  EXPECT_EQ(curve.force_n.back(), 0.25);
  EXPECT_EQ(curve.depth_mm.back(), 0.0);
}

TEST(SynthesizeForceCurve, HasTheNoiseRequestedAndIsKeyedBySeed) {
  const DrivePlan plan{.rest_s = 20.0};
  const ForceCurve a = SynthesizeForceCurve({}, plan, 0.05, 1, "x");
  const ForceCurve b = SynthesizeForceCurve({}, plan, 0.05, 2, "x");
  EXPECT_EQ(a.force_n, SynthesizeForceCurve({}, plan, 0.05, 1, "x").force_n);
  EXPECT_NE(a.force_n, b.force_n);
  const std::span<const double> rest(a.force_n.data(), 20000);
  EXPECT_NEAR(math::StandardDeviation(rest), 0.05, 0.002);
}

TEST(SynthesizeForceCurve, RefusesWhatCannotBe) {
  EXPECT_THROW(SynthesizeForceCurve({.puncture_depth_mm = 60.0}, {}, 0.0, 1, "x"), InputError);
  EXPECT_THROW(SynthesizeForceCurve({.a1_n_per_mm = -1.0}, {}, 0.0, 1, "x"), InputError);
  EXPECT_THROW(SynthesizeForceCurve({.relaxation_fraction = 1.1}, {}, 0.0, 1, "x"), InputError);
  EXPECT_THROW(SynthesizeForceCurve({.plateau_n = NAN}, {}, 0.0, 1, "x"), InputError);
  EXPECT_THROW(SynthesizeForceCurve({}, {.rate_hz = 1.0}, 0.0, 1, "x"), InputError);
  EXPECT_THROW(SynthesizeForceCurve({}, {.rate_hz = 1e9}, 0.0, 1, "x"), InputError);
  EXPECT_THROW(SynthesizeForceCurve({}, {.advance_mm_per_s = 0.0}, 0.0, 1, "x"), InputError);
  EXPECT_THROW(SynthesizeForceCurve({}, {}, -0.1, 1, "x"), InputError);
}

TEST(ReadForceCurve, ReadsBackWhatWasWritten) {
  const ForceCurve curve = SynthesizeForceCurve({}, {.rate_hz = 50.0}, 0.02, 3, "phantom");
  WriteForceCurve(Temp("phantom.csv"), curve);
  const ForceCurve read = ReadForceCurve(Temp("phantom.csv"));
  EXPECT_EQ(read.name, "phantom");
  EXPECT_EQ(read.time_s, curve.time_s);
  EXPECT_EQ(read.depth_mm, curve.depth_mm);
  EXPECT_EQ(read.force_n, curve.force_n);
}

TEST(ReadForceCurve, BringsTwoClocksTogether) {
  const auto folder = Temp("two_clocks");
  std::filesystem::create_directories(folder);
  WriteTextFile(folder / "time_displacement.csv",
                Rows(100, 10.0, [](double t) { return 3.0 * t; }));
  WriteTextFile(folder / "time_force.csv", Rows(1500, 130.0, [](double t) { return t * t; }));
  const ForceCurve curve = ReadForceCurve(folder);
  EXPECT_EQ(curve.name, "two_clocks");
  EXPECT_EQ(curve.size(), 1288u);  // The depth ends at 9.9 s.
  for (std::size_t i = 0; i < curve.size(); ++i) {
    ASSERT_NEAR(curve.depth_mm[i], 3.0 * curve.time_s[i], 1e-7);
    ASSERT_NEAR(curve.force_n[i], curve.time_s[i] * curve.time_s[i], 1e-6);
  }
}

TEST(ReadForceCurve, SaysWhatIsWrongAndWhere) {
  const auto write = [](const std::string& rows) {
    WriteTextFile(Temp("bad.csv"), "time_s,depth_mm,force_n\n" + rows);
    return [] { ReadForceCurve(Temp("bad.csv")); };
  };
  EXPECT_THAT(write("0,0,0\n-1,1,1\n"),
              ThrowsMessage<InputError>(AllOf(HasSubstr("bad.csv:3"), HasSubstr("not go back"))));
  EXPECT_THAT(write("0,0,0\n1,2,inf\n"),
              ThrowsMessage<InputError>(HasSubstr("bad.csv:3: force_n")));
  EXPECT_THAT(write("0,0,5000\n"), ThrowsMessage<InputError>(HasSubstr("another unit")));
  EXPECT_THAT(write("0,-2001,1\n"), ThrowsMessage<InputError>(HasSubstr("depth_mm is -2001")));
  EXPECT_THAT(write("0,0,0\n1,1,1\n"),
              ThrowsMessage<InputError>(HasSubstr("has 2 usable samples")));
  EXPECT_THAT([] { ReadForceCurve(Temp("no_such.csv")); },
              ThrowsMessage<InputError>(HasSubstr("no_such")));
}

TEST(ReadForceCurve, ReadsExportsOfMachines) {
  const auto rows = [](const char* row, double scale) {
    std::string text;
    for (int i = 0; i < 40; ++i) {
      text += Message(0.01 * i * scale, row, 0.05 * i, row, -0.002 * i * scale, "\n");
    }
    return text;
  };
  WriteTextFile(Temp("machine.csv"),
                "Specimen,A1\n\nTime,Extension,Load\n(s),(mm),(N)\n" + rows(",", 1.0));
  const ForceCurve curve = ReadForceCurve(Temp("machine.csv"));
  EXPECT_NEAR(curve.depth_mm.back(), 1.95, 1e-9);
  EXPECT_NEAR(curve.force_n.back(), -0.078, 1e-9);
  EXPECT_THAT(curve.how_read, HasSubstr("force_n from 'Load (N)'"));
  const ForceCurve turned =
      ReadForceCurve(Temp("machine.csv"), {.time = {.column = "Time", .unit = {}},
                                           .depth = {.column = "2", .unit = {}},
                                           .force = {.column = "Load", .unit = {}, .sign = -1}});
  EXPECT_NEAR(turned.force_n.back(), 0.078, 1e-9);
  WriteTextFile(Temp("milli.csv"), "time_ms;depth_mm;force_mN\n" + rows(";", 1000.0));
  EXPECT_NEAR(ReadForceCurve(Temp("milli.csv")).force_n.back(), -0.078, 1e-9);
  WriteTextFile(Temp("two.csv"), "time_s,depth_mm,Load [N],Kraft [N]\n0,0,0,0\n");
  EXPECT_THAT([] { ReadForceCurve(Temp("two.csv")); },
              ThrowsMessage<InputError>(HasSubstr("may be column 'Load [N]' or 'Kraft [N]'")));
}

TEST(ReadForceCurve, MergesEqualStampsAndSkipsEmptyCells) {
  std::string text = "time_s,depth_mm,force_n\n";
  for (int i = 0; i < 50; ++i) text += Message(i / 2, ",", i, ",", i == 7 ? "" : "1.5", "\n");
  WriteTextFile(Temp("coarse.csv"), text);
  const ForceCurve curve = ReadForceCurve(Temp("coarse.csv"));
  ASSERT_EQ(curve.size(), 25u);
  EXPECT_EQ(curve.depth_mm[4], 8.5);  // The mean of 8 and 9.
  EXPECT_EQ(curve.depth_mm[3], 6.0);  // Row 7 has no force.
  EXPECT_THAT(curve.how_read, HasSubstr("1 row with empty cells omitted"));
  EXPECT_THAT(curve.how_read, HasSubstr("24 rows had the time stamp of the row before"));
}

TEST(ReadForceCurve, RefusesAForceThatNoNeedleTakes) {
  std::string text = "time_s,depth_mm,force_n\n";
  for (int i = 0; i < 50; ++i) text += Message(i, ",", i, ",", 4 * i, "\n");
  WriteTextFile(Temp("strong.csv"), text);
  EXPECT_THAT(
      [] { ReadForceCurve(Temp("strong.csv")); },
      ThrowsMessage<InputError>(AllOf(HasSubstr("reaches 196 N"), HasSubstr("--as-it-is"))));
  EXPECT_EQ(ReadForceCurve(Temp("strong.csv"), {}, true).size(), 50u);
}

// A damaged file reads or is refused; it never crashes.
TEST(ReadForceCurve, SurvivesTruncationAndFlippedBits) {
  WriteForceCurve(Temp("good.csv"), SynthesizeForceCurve({}, {.rate_hz = 10.0}, 0.02, 3, "x"));
  const std::string good = ReadTextFile(Temp("good.csv"));
  RandomStream random(5, "damage");
  for (int i = 0; i < 400; ++i) {
    std::string bad = good;
    if (i % 2 == 0) {
      bad.resize(static_cast<std::size_t>(random.Uniform() * static_cast<double>(good.size())));
    }
    for (int k = 0; k < i % 4 && !bad.empty(); ++k) {
      bad[random.Next() % bad.size()] ^= static_cast<char>(1u << (random.Next() % 8));
    }
    WriteTextFile(Temp("damaged.csv"), bad);
    try {
      const ForceCurve curve = ReadForceCurve(Temp("damaged.csv"));
      ASSERT_GE(curve.size(), 20u);
      for (const double force : curve.force_n) ASSERT_LE(std::abs(force), 1000.0);
    } catch (const InputError& error) {
      ASSERT_THAT(error.what(), HasSubstr("damaged.csv"));
    }
  }
}

TEST(ReadForceCurve, FindsOutADepthInMetres) {
  std::string text = "time_s,depth_mm,force_n\n";
  for (int i = 0; i < 400; ++i) {
    text += Message(0.05 * i, ",", 0.08 * std::min(1.0, i / 300.0), ",", 0.01 * i, "\n");
  }
  WriteTextFile(Temp("metres.csv"), text);
  EXPECT_THAT([] { ReadForceCurve(Temp("metres.csv")); },
              ThrowsMessage<InputError>(
                  AllOf(HasSubstr("metres.csv: the depth changes by 0.08 in all over"),
                        HasSubstr("seems to be in metres"), HasSubstr("multiply"))));
  // A short but real motion of half a second stays what it is.
  text = "time_s,depth_mm,force_n\n";
  for (int i = 0; i < 400; ++i) text += Message(0.001 * i, ",", 0.002 * i, ",", 0.01 * i, "\n");
  WriteTextFile(Temp("short.csv"), text);
  EXPECT_EQ(ReadForceCurve(Temp("short.csv")).size(), 400u);
}

TEST(ReadForceCurve, TakesHounsfieldUnitsAlongIfTheyAreThere) {
  std::string text = "time_s,depth_mm,force_n,hu,hu_gradient_per_mm\n";
  for (int i = 0; i < 30; ++i) text += Message(0.1 * i, ",", i, ",0.5,", 40 + i, ",", 2 * i, "\n");
  WriteTextFile(Temp("hu.csv"), text);
  const ForceCurve curve = ReadForceCurve(Temp("hu.csv"));
  ASSERT_EQ(curve.hu.size(), 30u);
  EXPECT_EQ(curve.hu[29], 69.0);
  EXPECT_EQ(curve.hu_gradient_per_mm[29], 58.0);
}

}  // namespace
}  // namespace acus::forces
