// Hard cases of breathing, each with a bound: what can be wrong with fields, signals and time.
#include <cmath>
#include <fstream>
#include <gmock/gmock.h>
#include <limits>

#include "acus/base/core/error.h"
#include "acus/imaging/volume_rendering/warped_ray.h"
#include "acus/physics/breathing/tool_at_rest.h"
#include "support/bound.h"
#include "support/breathing_patients.h"
#include "support/temporary_folder.h"

namespace acus::breathing {
namespace {

using Eigen::Vector3d;
using testing::HasSubstr;
using testing_support::Above;
using testing_support::AtMost;
using testing_support::Below;
using testing_support::BoundPlot;
using testing_support::BreathingPatient;
using testing_support::Exactly;
using testing_support::HardCase;
using testing_support::kAllMotionKinds;
using testing_support::Largest;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

BreathingPatient Patient(MotionKind kind, double largest_mm = 20.0) {
  BreathingPatient patient{.kind = kind, .nodes_per_axis = 48};
  patient.box.size.setConstant(201);
  patient.largest_mm = largest_mm;
  return patient;
}

/// Displacement along z of a component by place.
template <typename Along>
MotionField FieldAlongZ(int per_axis, const Along& along_mm) {
  volume::Geometry box;
  box.size.setConstant(201);
  const volume::Geometry nodes = NodesOver(box, per_axis);
  MotionField field(nodes, 1);
  std::vector<float> values;
  const Eigen::Affine3d ct_from_index = nodes.ct_from_index();
  for (int k = 0; k < per_axis; ++k) {
    for (int j = 0; j < per_axis; ++j) {
      for (int i = 0; i < per_axis; ++i) {
        values.insert(values.end(),
                      {0.0F, 0.0F,
                       static_cast<float>(along_mm(Vector3d(ct_from_index * Vector3d(i, j, k))))});
      }
    }
  }
  field.SetComponent(0, values);
  return field;
}

MotionMap Whole(const MotionField& field, double share = 1.0) {
  MotionWeights weights;
  weights.Add(0, share);
  return {field, weights};
}

Eigen::Isometry3d PoseAt(const Vector3d& place_mm) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() = place_mm;
  return pose;
}

/// Whatever the field does, the answer is finite, not worse than the guess, and no farther away
/// than tissue moves.
void ExpectGuarded(const MotionMap& map, const Vector3d& world, const Vector3d& start,
                   double largest_mm) {
  constexpr int kIterations = 20;
  const auto found = map.RestOf(world, start, {.max_iterations = kIterations, .tolerance_mm = 0.0});
  ASSERT_TRUE(found.rest_mm.allFinite());
  ASSERT_LE(found.iterations, kIterations);
  ASSERT_LE(found.residual_mm, (map.WorldMm(start) - world).norm() * (1.0 + 1e-12));
  ASSERT_NEAR(found.residual_mm, (map.WorldMm(found.rest_mm) - world).norm(), 1e-9);
  ASSERT_LE((found.rest_mm - world).norm(), largest_mm + found.residual_mm + 1e-9);
}

// 150 mm over 200: strains to 2.4, the field folds over itself in the middle.
TEST(BreathingHardCases, AFoldingFieldCostsABoundedTimeAndGivesTheBestPlaceMet) {
  const HardCase hard("150 mm over 200: the field folds over itself and has no inverse there.");
  int num_folding = 0;
  for (const MotionKind kind : kAllMotionKinds) {
    const BreathingPatient patient = Patient(kind, 150.0);
    const MotionModel model = patient.Model();
    const MotionMap map(model.field(), model.WeightsAt(patient.BreathAt(0.5)));
    bool folds = false;
    for (double z = -10.0; z < 211.0; z += 1.7) {
      const Vector3d world(100.0, 90.0, z);
      folds = folds || map.GradientAt(world).determinant() < 0.0;
      ExpectGuarded(map, world, world, 160.0);
      ExpectGuarded(map, world, world + Vector3d(30.0, -20.0, 50.0), 160.0);
    }
    num_folding += folds ? 1 : 0;
  }
  hard.Expect("models whose field folds, each inverted within 20 iterations", num_folding,
              Exactly(std::size(kAllMotionKinds)));
}

// As it breathes back out of the fold, at six times the speed of normal breath, the hand's inverse
// is right again 20 ms after the field is one to one.
TEST(BreathingHardCases, AToolComesOutOfAFold) {
  const HardCase hard(
      "A hand's place is followed into a fold and out of it, at six times normal speed.");
  BoundPlot plot{.title = "Residual of the inverse at a hand, in and out of a fold",
                 .x_label = "time [s]",
                 .y_label = "residual [mm]",
                 .log_y = true,
                 .curves = {{}}};
  const BreathingPatient patient = Patient(MotionKind::kFullCycle, 120.0);
  const MotionModel model = patient.Model();
  const Eigen::Isometry3d pose = PoseAt({100.0, 95.0, 60.0});
  ToolTrack track;
  int good_steps = 0;
  Largest worst_mm;
  Largest worst_after_mm;
  Largest turned_most;
  for (int n = 0; n < 4000; ++n) {
    const double cycle = n / 4000.0;
    const MotionMap map(model.field(), model.WeightsAt(patient.BreathAt(cycle)));
    const ToolAtRest tool = AtRest(map, pose, Vector3d::UnitZ(), track);
    ASSERT_TRUE(tool.ct_from_tool.matrix().allFinite());
    ASSERT_NEAR(tool.world_from_rest.norm(), 1.0, 1e-9);
    worst_mm.Add(tool.residual_mm);
    turned_most.Add(tool.world_from_rest.angularDistance(Eigen::Quaterniond::Identity()));
    if (n % 8 == 0) plot.curves[0].Add(1e-3 * n, tool.residual_mm);
    // One to one: strains below 1 everywhere.
    const double strain = 120.0 * (0.5 - 0.5 * std::cos(2.0 * M_PI * cycle)) * M_PI / 200.0;
    good_steps = strain < 0.6 ? good_steps + 1 : 0;
    if (good_steps > 20) worst_after_mm.Add(tool.residual_mm);
  }
  hard.Expect("residual anywhere", worst_mm, AtMost(150.0), "mm");
  hard.Expect("residual 20 ms after the fold", worst_after_mm, Below(0.1), "mm");
  hard.Expect("turn of the tissue, at least", turned_most, Above(0.05), "rad");
  hard.Plot(plot);
}

// A strain of -3 everywhere: no step lowers the residual unless it is halved, twice over.
TEST(BreathingHardCases, AnInversionThatDoesNotConvergeIsCaught) {
  const MotionField field =
      FieldAlongZ(11, [](const Vector3d& place) { return -3.0 * (place.z() - 100.0); });
  const MotionMap map = Whole(field);
  for (double z = 20.0; z < 180.0; z += 3.3) {
    ExpectGuarded(map, {100.0, 100.0, z}, {100.0, 100.0, z}, 300.0);
  }
}

// Lung against ribs: 20 mm on one side of a plane, nothing on the other, between two nodes 5 mm
// apart. Two nodes away the inverse is as good as anywhere; at the interface it is bounded by the
// jump; and where tissue is torn apart there is no answer but the best one.
TEST(BreathingHardCases, ASlidingInterfaceIsBoundedByItsJump) {
  const HardCase hard("Lung against ribs: 20 mm between two nodes 5 mm apart, along and across.");
  Largest across_mm;
  Largest across_away_mm;
  constexpr double kJumpMm = 20.0;
  const auto slides = [](const Vector3d& place) { return place.x() < 100.0 ? 0.0 : kJumpMm; };
  const MotionField field = FieldAlongZ(41, slides);
  const MotionMap map = Whole(field);
  Largest worst_away_mm;
  Largest worst_near_mm;
  for (double x = 80.0; x < 120.0; x += 0.3) {
    volume_rendering::WarpedRay ray(map, {.max_iterations = 5, .tolerance_mm = 0.0});
    for (double z = 30.0; z < 170.0; z += 1.0) {
      const Vector3d world(x, 100.0, z);
      const Vector3d rest = ray.RestOf(world, Vector3d::UnitZ());
      ASSERT_TRUE(rest.allFinite());
      // Sliding: only x tells how far, and x does not change.
      const double off_mm = (map.WorldMm(rest) - world).norm();
      (std::abs(x - 100.0) > 10.0 ? worst_away_mm : worst_near_mm).Add(off_mm);
    }
  }
  hard.Expect("residual 10 mm away, sliding along", worst_away_mm, Below(1e-9), "mm");
  hard.Expect("residual at the interface, sliding along", worst_near_mm, Below(1e-3), "mm");
  // Across: pressed together and torn apart within one cell, strains of +-4.
  for (const double sign : {1.0, -1.0}) {
    const MotionField torn = FieldAlongZ(
        41, [sign](const Vector3d& place) { return place.z() < 100.0 ? 0.0 : sign * kJumpMm; });
    const MotionMap across = Whole(torn);
    for (double z = 60.0; z < 140.0; z += 0.3) {
      const Vector3d world(100.0, 100.0, z);
      ExpectGuarded(across, world, world, kJumpMm);
      const auto found = across.RestOf(world, world, {.max_iterations = 50, .tolerance_mm = 0.0});
      across_mm.Add(found.residual_mm);
      if (std::abs(z - 100.0) > kJumpMm + 5.0) across_away_mm.Add(found.residual_mm);
    }
  }
  hard.Expect("residual where tissue is torn or pressed together", across_mm, AtMost(kJumpMm),
              "mm");
  hard.Expect("residual 25 mm away from that", across_away_mm, Below(0.05), "mm");
}

TEST(BreathingHardCases, BeyondTheFieldItIsAsAtItsBorderAndBounded) {
  const HardCase hard("Places up to 1e300 mm outside the field, and some that are no numbers.");
  Largest off_border_mm;
  Largest after_rubbish_mm;
  const BreathingPatient patient = Patient(MotionKind::kSurrogate);
  const MotionModel model = patient.Model();
  const MotionMap map(model.field(), model.WeightsAt(patient.BreathAt(0.4)));
  const MotionField all = FieldAlongZ(5, [](const Vector3d&) { return 20.0; });
  for (const double far_mm : {250.0, 1e4, 1e9, 1e300}) {
    for (const Vector3d& way : {Vector3d(1, 0, 0), Vector3d(0, -1, 0), Vector3d(-1, 1, 1)}) {
      ExpectGuarded(map, far_mm * way, far_mm * way, 60.0);
      off_border_mm.Add(std::abs(Whole(all).DisplacementMm(far_mm * way).z() - 20.0));
    }
  }
  // What is no place comes back as it is, and the next good one is right.
  ToolTrack track;
  for (const double rubbish : {kNan, kInfinity, -kInfinity}) {
    const ToolAtRest tool = AtRest(map, PoseAt({rubbish, 0.0, 1.0}), Vector3d::UnitZ(), track);
    EXPECT_EQ(tool.residual_mm, 0.0);
    EXPECT_FALSE(track.started);
    const ToolAtRest next = AtRest(map, PoseAt({100.0, 90.0, 80.0}), Vector3d::UnitZ(), track);
    after_rubbish_mm.Add(next.residual_mm);
  }
  hard.Expect("displacement outside against that of the border", off_border_mm, AtMost(1e-3), "mm");
  hard.Expect("residual of a good pose after one that is none", after_rubbish_mm, Below(0.005),
              "mm");
}

// Three times as deep as the key frames, and breathed out far below them: where models go on, on a
// line; where they do not (full cycle), as in normal breath. The inverse holds while strain is < 1.
TEST(BreathingHardCases, DeeperBreathThanTheKeyFramesStaysOnALine) {
  const HardCase hard("Three times as deep as what was recorded, and far below it.");
  Largest full_mm;
  Largest off_line_mm;
  Largest residual_mm;
  for (const MotionKind kind : kAllMotionKinds) {
    const BreathingPatient patient = Patient(kind);
    const MotionModel model = patient.Model();
    const Vector3d place(100.0, 100.0, 70.0);
    for (const double level : {-2.0, -1.0, 1.5, 3.0}) {
      const Breath breath{.cycle = 0.5, .level = level, .level_per_s = 0.0};
      const MotionMap map(model.field(), model.WeightsAt(breath));
      const Vector3d moved = map.DisplacementMm(place);
      if (kind == MotionKind::kFullCycle) {
        full_mm.Add(moved.norm());
      } else {
        off_line_mm.Add((moved - patient.DisplacementMm(breath, place)).norm());
      }
      ExpectGuarded(map, place, place, 80.0);
      const auto found = map.RestOf(place, place, {.max_iterations = 50, .tolerance_mm = 0.0});
      residual_mm.Add(found.residual_mm);
    }
  }
  hard.Expect("displacement where a model does not go on", full_mm, Below(25.0), "mm");
  hard.Expect("displacement off the line where it does", off_line_mm, Below(0.1), "mm");
  hard.Expect("residual of the inverse", residual_mm, Below(0.05), "mm");
}

// A pant of 0.5 s, five times the speed of normal breath at the same depth: 190 mm/s.
TEST(BreathingHardCases, VeryFastBreathIsFollowed) {
  const HardCase hard(
      "A pant of half a second, 190 mm/s: the last place is a poor guess of the next.");
  const BreathSource source(BreathingPattern({.period_s = 0.5, .exponent = 3}), {});
  for (const MotionKind kind : kAllMotionKinds) {
    BreathingPatient patient = Patient(kind);
    patient.period_s = 0.5;
    const MotionModel model = patient.Model();
    const Vector3d world(100.0, 90.0, 60.0);
    ToolTrack track;
    Vector3d one = world;
    Largest worst_mm;
    Largest worst_of_one_mm;
    for (int n = 0; n < 3000; ++n) {
      const MotionMap map(model.field(), model.WeightsAt(source.At(1e-3 * n)));
      worst_mm.Add(AtRest(map, PoseAt(world), Vector3d::UnitZ(), track).residual_mm);
      one = map.RestOf(world, one, {.max_iterations = 1, .tolerance_mm = 0.0}).rest_mm;
      worst_of_one_mm.Add((map.WorldMm(one) - world).norm());
    }
    hard.Expect(Message("residual, ", NameOf(kind)), worst_mm, Below(0.01), "mm");
    hard.Expect(Message("residual with one iteration a step, ", NameOf(kind)), worst_of_one_mm,
                Below(0.15), "mm");
  }
}

// Ten minutes: nothing creeps, and breath goes on where it stopped.
TEST(BreathingHardCases, ALongHoldStandsStillBitForBit) {
  const HardCase hard(
      "Ten minutes of held breath: nothing creeps, and it goes on where it stopped.");
  const PatternSettings uneven{.period_s = 4.0,
                               .exponent = 2,
                               .period_spread = 0.1,
                               .speed_spread = 0.3,
                               .level_spread = 0.1,
                               .level = 1.0,
                               .seed = 5};
  const BreathSource source(BreathingPattern(uneven), {{.begin_s = 10.3, .end_s = 610.3}});
  const Breath held = source.At(11.0);
  EXPECT_EQ(held.level_per_s, 0.0);
  for (double t = 10.9; t < 609.7; t += 7.7) {
    EXPECT_EQ(source.At(t).level, held.level);
    EXPECT_EQ(source.At(t).cycle, held.cycle);
  }
  // 600 s of hold let one ramp's worth of breath pass: 0.5 s.
  const BreathSource free(BreathingPattern(uneven), {});
  hard.Expect("level after the hold against the breath without it",
              std::abs(source.At(620.0).level - free.At(620.0 - 600.0 + 0.5).level), AtMost(1e-9));
}

// Phase after an hour of a regular breath, and of a recording that goes round: as in the first
// minute, to a millionth of a breath; and a tool that was followed for an hour is where one that
// begins now is.
TEST(BreathingHardCases, AnHourDoesNotDriftInPhaseOrPlace) {
  const HardCase hard(
      "An hour of breath: phase and place must not drift by what each step rounds.");
  Largest phase;
  Largest residual_mm;
  const BreathingPattern regular({.period_s = 3.7, .exponent = 2});
  for (int n = 0; n < 20; ++n) {
    const double t = 0.17 * n + 0.05;
    const double later = t + 3.7 * 973;  // Just over an hour.
    phase.Add(std::abs(regular.At(later).level - regular.At(t).level));
    phase.Add(std::abs(regular.At(later).level_per_s - regular.At(t).level_per_s));
  }
  BreathSignal signal{.start_s = 0.0, .step_s = 0.02, .level = {}};
  for (int n = 0; n < 2000; ++n) signal.level.push_back(std::cos(2.0 * M_PI * 0.02 * n / 3.7));
  const RecordedBreath recorded(signal, {.smoothing_s = 0.05, .repeat = true});
  const double round_s = recorded.duration_s();
  for (int n = 0; n < 20; ++n) {
    const double t = 1.9 * n + 0.05;
    const double later = t + round_s * std::ceil(3600.0 / round_s);
    phase.Add(std::abs(recorded.At(later).level - recorded.At(t).level));
    phase.Add(std::abs(recorded.At(later).cycle - recorded.At(t).cycle));
  }
  hard.Expect("level and phase after an hour against the first minute", phase, AtMost(1e-6));
  const BreathingPatient patient = Patient(MotionKind::kSurrogate);
  const MotionModel model = patient.Model();
  const BreathSource source(regular, {});
  const Eigen::Isometry3d pose = PoseAt({110.0, 90.0, 70.0});
  ToolTrack old;
  for (int n = 0; n <= 360'000; ++n) {
    const MotionMap map(model.field(), model.WeightsAt(source.At(1e-2 * n)));
    const ToolAtRest tool = AtRest(map, pose, Vector3d::UnitZ(), old);
    residual_mm.Add(tool.residual_mm);
  }
  const MotionMap map(model.field(), model.WeightsAt(source.At(3600.0)));
  ToolTrack fresh;
  AtRest(map, pose, Vector3d::UnitZ(), fresh);
  hard.Expect("residual of a tool that is followed for an hour", residual_mm, Below(0.05), "mm");
  // Each is good to 2 um.
  hard.Expect("place after an hour against one that begins there",
              (old.rest_mm - fresh.rest_mm).norm(), Below(0.006), "mm");
  hard.Expect("turn after an hour against one that begins there",
              old.world_from_rest.angularDistance(fresh.world_from_rest), Below(1e-4), "rad");
}

TEST(BreathingHardCases, TimeThatIsNoneIsTheBeginningAndASignalThatIsNoneMovesNothing) {
  const BreathSource source(BreathingPattern({.period_s = 4.0, .exponent = 1}), {});
  for (const double t : {kNan, -kInfinity, -1e9}) EXPECT_EQ(source.At(t).level, 1.0);
  EXPECT_TRUE(std::isfinite(source.At(kInfinity).level));
  EXPECT_TRUE(std::isfinite(source.At(1e300).level));
  for (const MotionKind kind : kAllMotionKinds) {
    const MotionModel model = Patient(kind).Model();
    for (const double rubbish : {kNan, kInfinity}) {
      EXPECT_EQ(model.WeightsAt({.cycle = rubbish}).count, 0);
      EXPECT_EQ(model.WeightsAt({.level = rubbish}).count, 0);
      EXPECT_EQ(model.WeightsAt({.level_per_s = rubbish}).count, 0);
      EXPECT_EQ(model.WeightsAt({.level = 0.2}, rubbish).count, 0);
    }
  }
}

class SignalHardCases : public testing::Test {
 protected:
  /// A CSV of `seconds` at 25 Hz of what `level` says.
  template <typename Level>
  std::filesystem::path Csv(double seconds, const Level& level) {
    const std::filesystem::path path = folder_ / "signal.csv";
    std::ofstream out(path);
    out << "time_s,level\n";
    for (int n = 0; n < static_cast<int>(25.0 * seconds); ++n) {
      const std::string text = level(0.04 * n);
      if (!text.empty()) out << 0.04 * n << "," << text << "\n";
    }
    return path;
  }

 private:
  testing_support::TemporaryFolder folder_;
};

TEST_F(SignalHardCases, GapsConstantsAndInvalidDataAreClearErrors) {
  const testing_support::HardCase hard(
      "A breathing belt that comes loose half way, gaps and rubbish.");
  testing_support::Largest level;
  testing_support::Largest level_per_s;
  const auto breath = [](double t) { return std::to_string(std::cos(2.0 * M_PI * t / 4.0)); };
  EXPECT_NO_THROW(ReadBreathSignal(Csv(30.0, breath), {}));
  EXPECT_THAT(
      [&] {
        ReadBreathSignal(Csv(30.0, [&](double t) { return t > 10.0 && t < 12.0 ? "" : breath(t); }),
                         {});
      },
      testing::ThrowsMessage<InputError>(HasSubstr("gap")));
  EXPECT_THAT([&] { ReadBreathSignal(Csv(30.0, [](double) { return "0.7"; }), {}); },
              testing::ThrowsMessage<InputError>(HasSubstr("no breathing")));
  for (const char* rubbish : {"nan", "inf", "-inf", "cough", "1e999"}) {
    EXPECT_THROW(
        ReadBreathSignal(
            Csv(30.0, [&](double t) { return t > 10.0 && t < 10.1 ? rubbish : breath(t); }), {}),
        InputError)
        << rubbish;
  }
  // A sensor that comes loose half way: what is there of breath is used, and nothing jumps.
  const BreathSignal loose = ReadBreathSignal(
      Csv(60.0, [&](double t) { return t < 30.0 ? breath(t) : std::string("-1"); }), {});
  const RecordedBreath recorded(loose, {});
  for (double t = 0.0; t < 80.0; t += 0.01) {
    const Breath at = recorded.At(t);
    ASSERT_TRUE(std::isfinite(at.level) && std::isfinite(at.level_per_s));
    level.Add(std::abs(at.level));
    level_per_s.Add(std::abs(at.level_per_s));
    ASSERT_TRUE(at.cycle >= 0.0 && at.cycle < 1.0);
  }
  hard.Expect("level of a belt that comes loose", level, AtMost(1.05));
  hard.Expect("speed of its level", level_per_s, AtMost(5.0), "1/s");
}

}  // namespace
}  // namespace acus::breathing
