// Algorithm 1 with its parameters from HU.
#include <algorithm>
#include <cmath>
#include <gmock/gmock.h>

#include "acus/base/core/error.h"
#include "acus/base/core/random.h"
#include "acus/physics/tissue/spring_model.h"
#include "support/layered_tissue.h"

namespace acus::tissue {
namespace {

using Eigen::Vector3d;
using testing::HasSubstr;
using testing_support::Layers;
using testing_support::ModelInsertion;

/// 0 HU: f_cut 0.2 N, R 0.01 N/mm, k 0.1 N/mm^2; 100 HU: 1.2 N, 0.03 N/mm, 0.3 N/mm^2.
forces::ForceTable HuTable() {
  nlohmann::json document = nlohmann::json::parse(R"({
    "format": "acus-forces/1",
    "hu_springs": [
      {"hu": 0, "a1_n_per_mm": 2, "cutting_n": 0.2, "shaft_n_per_mm2": 0.1, "friction_n_per_mm": 0.01},
      {"hu": 100, "a1_n_per_mm": 2, "cutting_n": 1.2, "shaft_n_per_mm2": 0.3, "friction_n_per_mm": 0.03}],
    "tissues": [{"tissue": "soft_tissue", "source": "test"},
                {"tissue": "fat", "source": "test", "cutting_n": 0.7, "cutting_a1_n_per_mm": 2,
                 "shaft_n_per_mm2": 0.2, "friction_n_per_mm": 0.02},
                {"tissue": "bone", "source": "test", "impenetrable": true}]})");
  return forces::ForceTableFromJson(document, "hu");
}

SpringModel ByHu(const HuAt& hu_at, const Layers& layers = {{{0, "fat"}}}) {
  return SpringModel({}, HuTable(), testing_support::Trocar18(), testing_support::RoundElasticity(),
                     layers.Tissues(), layers.At(), hu_at);
}

TEST(HuSprings, AreLinearBetweenRowsAndConstantBeyondThem) {
  const forces::HuSprings springs = HuTable().hu_springs;
  EXPECT_EQ(springs.At(-500.0).cutting_n, 0.2);
  EXPECT_EQ(springs.At(0.0).cutting_n, 0.2);
  EXPECT_NEAR(springs.At(25.0).cutting_n, 0.45, 1e-15);
  EXPECT_NEAR(springs.At(25.0).shaft_n_per_mm2, 0.15, 1e-15);
  EXPECT_NEAR(springs.At(25.0).friction_n_per_mm, 0.015, 1e-15);
  EXPECT_EQ(springs.At(100.0).cutting_n, 1.2);
  EXPECT_EQ(springs.At(3000.0).cutting_n, 1.2);
  // All forces scale with the needle's diameter.
  const forces::ForceTable scaled = HuTable().ScaledTo(2.54);
  EXPECT_NEAR(scaled.hu_springs.At(25.0).cutting_n, 0.9, 1e-12);
  EXPECT_NEAR(scaled.hu_springs.At(25.0).friction_n_per_mm, 0.03, 1e-12);
}

TEST(HuSprings, OneHuIsATissueWithTheSameParameters) {
  const Layers layers{{{0, "fat"}}};
  const SpringModel by_label({}, HuTable(), testing_support::Trocar18(),
                             testing_support::RoundElasticity(), layers.Tissues(), layers.At());
  const SpringModel by_hu = ByHu([](const Vector3d&) { return 50.0; });
  ModelInsertion<SpringModel> a{by_label};
  ModelInsertion<SpringModel> b{by_hu};
  for (const double depth_mm : {20.0, 12.0, 45.0, 44.9, 45.1, 3.0}) {
    a.MoveToDepth(depth_mm);
    b.MoveToDepth(depth_mm);
    EXPECT_NEAR(b.last.AxialN(), a.last.AxialN(), 1e-9) << depth_mm;
  }
}

// HU rise by 1.25 per mm: at the tip f_cut is that of its place, and the shaft's friction is the
// integral of R, each node for the millimetres in front of it.
TEST(HuSprings, CutAndShaftFollowARampOfHu) {
  const SpringModel model = ByHu([](const Vector3d& p) { return 1.25 * p.z(); });
  ModelInsertion<SpringModel> insertion{model};
  insertion.MoveToDepth(60.0);
  const SpringState& state = insertion.state;
  const PathNode& tip = state.node[state.num_nodes - 1];
  const double tip_mm = tip.rest_in_ct_mm.z();
  EXPECT_NEAR(insertion.last.cutting_n, 0.2 + 0.0125 * tip_mm, 1e-3);
  EXPECT_NEAR(tip_mm, 60.0 - insertion.last.cutting_n / 2.0, 1e-3);
  const double integral_n = 0.01 * tip_mm + 0.5 * 0.02 / 80.0 * tip_mm * tip_mm;
  EXPECT_NEAR(insertion.last.friction_n, integral_n, 0.5 * 2.0 * (0.02 / 80.0) * tip_mm);
}

TEST(HuSprings, MembranesAndBoneAreTheTissues) {
  const SpringModel model = ByHu([](const Vector3d& p) { return p.z() < 30.0 ? 20.0 : 900.0; },
                                 {{{0, "fat"}, {30, "bone"}}});
  ModelInsertion<SpringModel> insertion{model};
  insertion.MoveToDepth(32.0);
  EXPECT_EQ(insertion.Count(forces::NeedleEvent::kBoneContact), 1);
  EXPECT_GT(insertion.last.bone_n, 5.0);
}

/// Noise of a CT, a value per voxel of 0.7 mm.
double NoiseHu(const Vector3d& p) {
  RandomStream random(static_cast<std::uint64_t>(std::llround(p.z() / 0.7) + 1000), "voxel");
  return 50.0 + 40.0 * random.Normal();
}

TEST(HuSprings, StrokesInANoisyCtGiveNoWork) {
  const SpringModel model = ByHu(NoiseHu);
  ModelInsertion<SpringModel> insertion{model};
  insertion.MoveToDepth(40.0);
  insertion.MoveToDepth(30.0);
  for (const double stroke_mm : {0.05, 0.5, 5.0, 0.5}) {
    const double work_mj = insertion.work_n_mm;
    for (int i = 0; i < 5; ++i) {
      insertion.MoveToDepth(30.0 - stroke_mm);
      insertion.MoveToDepth(30.0);
    }
    // What the shaft had stored, 1/2 R^2 / k over 30 mm, can come back once.
    EXPECT_GT(insertion.work_n_mm, work_mj - 0.05) << stroke_mm;
  }
  RandomStream random(3, "strokes");
  const double begin_mj = insertion.work_n_mm;
  double least_mj = 0.0;
  for (int i = 0; i < 400; ++i) {
    insertion.MoveToDepth(random.Uniform(5.0, 39.0), 40.0);
    least_mj = std::min(least_mj, insertion.work_n_mm - begin_mj);
  }
  EXPECT_GT(least_mj, -0.05);
  EXPECT_GT(insertion.work_n_mm - begin_mj, 10.0);
}

TEST(HuSprings, SayWhatIsWrongWithARow) {
  const auto message = [](const char* rows) -> std::string {
    try {
      forces::ForceTableFromJson(
          nlohmann::json::parse(
              Message(R"({"format": "acus-forces/1", "hu_springs": )", rows,
                      R"(, "tissues": [{"tissue": "soft_tissue", "source": "t"}]})")),
          "t.json");
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(
      message(
          R"([{"hu": 0, "a1_n_per_mm": 1, "cutting_n": 1, "shaft_n_per_mm2": 1, "friction_n_per_mm": 0},
                          {"hu": -5, "a1_n_per_mm": 1, "cutting_n": 1, "shaft_n_per_mm2": 1, "friction_n_per_mm": 0}])"),
      HasSubstr("t.json: /hu_springs/1/hu: is -5; it must be above the row before, 0"));
  EXPECT_THAT(
      message(R"([{"hu": 0, "cutting_n": 1, "shaft_n_per_mm2": 1, "friction_n_per_mm": 0}])"),
      HasSubstr("/hu_springs/0: a1_n_per_mm and a2_n_per_mm2 are both 0"));
  EXPECT_THAT(
      message(R"([{"hu": 0, "a1_n_per_mm": 1, "shaft_n_per_mm2": 1, "friction_n_per_mm": 0}])"),
      HasSubstr("/hu_springs/0"));
}

}  // namespace
}  // namespace acus::tissue
