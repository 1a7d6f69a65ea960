#include "acus/patient/segmentation/segmenters/tissues.h"

#include <functional>
#include <gmock/gmock.h>

#include "acus/patient/segmentation/patient_segmentation.h"
#include "acus/patient/segmentation/segmenters/organs.h"
#include "acus/patient/segmentation/voxels/metrics.h"
#include "synthetic_body.h"

namespace acus::segmentation {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

TissueOptions Defaults() {
  return ReadSegmentationConfig(ACUS_SOURCE_DIR "/configs/segmentation/default.json").tissues;
}

RunContext TwoThreads() {
  RunContext context;
  context.num_threads = 2;
  return context;
}

Mask Of(const volume::LabelMap& labels, const char* name) {
  Mask mask(labels.geometry);
  for (std::size_t i = 0; i < mask.voxels.size(); ++i) {
    mask.voxels[i] = labels.voxels[i] == volume::LabelOf(name) ? 1 : 0;
  }
  return mask;
}

Mask BodyOf(const volume::LabelMap& labels) {
  Mask mask = Of(labels, "outside");
  for (auto& voxel : mask.voxels) voxel ^= 1U;
  return mask;
}

void ExpectTruth(const SyntheticBody& body, const volume::LabelMap& found) {
  EXPECT_GT(Dice(BodyOf(found), BodyOf(body.truth)), 0.99);
  EXPECT_GT(Dice(Of(found, "bone"), Of(body.truth, "bone")), 0.93);
  EXPECT_GT(Dice(Of(found, "lung"), Of(body.truth, "lung")), 0.97);
  EXPECT_GT(Dice(Of(found, "gas"), Of(body.truth, "gas")), 0.95);
}

TEST(FindTissues, RecoversAPlainBodyWithoutItsTable) {
  const SyntheticBody body = MakeSyntheticBody({});
  ExpectTruth(body, FindTissues(body.ct, Defaults(), TwoThreads()).labels);
}

void AddTo(volume::CtVolume& ct, const std::function<bool(const Eigen::Vector3d&)>& inside,
           std::int16_t hu) {
  const volume::Geometry& g = ct.geometry;
  for (int k = 0; k < g.size[2]; ++k) {
    for (int j = 0; j < g.size[1]; ++j) {
      for (int i = 0; i < g.size[0]; ++i) {
        if (inside(g.ct_from_index() * Eigen::Vector3d(i, j, k))) ct.At(i, j, k) = hu;
      }
    }
  }
}

volume::Label LabelAtMm(const volume::LabelMap& labels, double x, double y) {
  const Eigen::Array3i v =
      (labels.geometry.index_from_ct() * Eigen::Vector3d(x, y, 30)).array().round().cast<int>();
  return labels.At(v[0], v[1], v[2]);
}

TEST(FindTissues, AnArmIsKeptAndAPadIsNot) {
  SyntheticBody body = MakeSyntheticBody({.has_table = false});
  AddTo(
      body.ct, [](const auto& p) { return p.y() > 68.0 && p.y() < 84.0; }, 10);  // Gel, 16 mm.
  AddTo(
      body.ct, [](const auto& p) { return std::hypot(p.x() - 80.0, p.y() + 60.0) < 18.0; }, 45);
  AddTo(
      body.ct, [](const auto& p) { return std::hypot(p.x() - 80.0, p.y() + 60.0) < 6.0; }, 700);
  TissueOptions options = Defaults();
  options.body_min_part_ml = 20.0;  // The volume is a short one.
  const auto found = FindTissues(body.ct, options, TwoThreads()).labels;
  EXPECT_EQ(LabelAtMm(found, 0, 76), volume::LabelOf("outside"));
  EXPECT_EQ(LabelAtMm(found, 80, -50), volume::LabelOf("soft_tissue"));
}

/// The body found over the true one, on a board as dense as plastic that is 30 mm thick, 10 mm
/// behind the skin; `rails` of 6 mm hold it at the body.
double BodyOverTruthOnABoard(bool rails) {
  SyntheticBody body = MakeSyntheticBody({.has_table = false, .depth_mm = 210.0});
  AddTo(
      body.ct,
      [](const auto& p) { return p.y() > 74.0 && p.y() < 104.0 && std::abs(p.x()) < 85.0; }, 60);
  if (rails) {
    AddTo(
        body.ct,
        [](const auto& p) {
          return p.y() > 55.0 && p.y() < 75.0 && std::abs(std::abs(p.x()) - 20.0) < 3.0;
        },
        60);
  }
  const auto found = FindTissues(body.ct, Defaults(), TwoThreads()).labels;
  EXPECT_EQ(LabelAtMm(found, 0, 90.0), volume::LabelOf("outside"));
  EXPECT_EQ(LabelAtMm(found, 60, 90.0), volume::LabelOf("outside"));
  const auto voxels = [](const volume::LabelMap& labels) {
    return static_cast<double>(std::ranges::count(BodyOf(labels).voxels, 1));
  };
  return voxels(found) / voxels(body.truth);
}

TEST(FindTissues, ABoardIsNoTissueAlsoIfItTouchesTheBodyHereAndThere) {
  EXPECT_NEAR(BodyOverTruthOnABoard(false), 1.0, 0.01);
  EXPECT_NEAR(BodyOverTruthOnABoard(true), 1.0, 0.01);
}

TEST(FindTissues, ContrastAgentInAVesselDoesNotBecomeBone) {
  const SyntheticBody body = MakeSyntheticBody({.blood_hu = 300.0});
  const auto found = FindTissues(body.ct, Defaults(), TwoThreads()).labels;
  ExpectTruth(body, found);
  const Eigen::Array3i vessel =
      (found.geometry.index_from_ct() * Eigen::Vector3d(28, 12, 30)).array().round().cast<int>();
  EXPECT_EQ(found.At(vessel[0], vessel[1], vessel[2]), volume::LabelOf("soft_tissue"));
}

TEST(FindTissues, HoldsOnACoarseAndOnANoisyScan) {
  const SyntheticBody coarse = MakeSyntheticBody({.spacing_mm = 2.5});
  EXPECT_GT(Dice(Of(FindTissues(coarse.ct, Defaults(), TwoThreads()).labels, "bone"),
                 Of(coarse.truth, "bone")),
            0.9);
  const SyntheticBody noisy = MakeSyntheticBody({.noise_hu = 35.0});
  EXPECT_GT(
      Dice(BodyOf(FindTissues(noisy.ct, Defaults(), TwoThreads()).labels), BodyOf(noisy.truth)),
      0.98);
}

TEST(FindTissues, TheCanalIsNotBoneAndMarrowIs) {
  const SyntheticBody body = MakeSyntheticBody({});
  const auto found = FindTissues(body.ct, Defaults(), TwoThreads()).labels;
  const auto at = [&](double x, double y) {
    const Eigen::Array3i v =
        (found.geometry.index_from_ct() * Eigen::Vector3d(x, y, 30)).array().round().cast<int>();
    return found.At(v[0], v[1], v[2]);
  };
  EXPECT_EQ(at(0, 42), volume::LabelOf("spinal_canal"));
  EXPECT_EQ(at(0, 18), volume::LabelOf("bone"));    // Red marrow.
  EXPECT_EQ(at(68, -15), volume::LabelOf("bone"));  // Fatty marrow.
  EXPECT_EQ(at(0, -63), volume::LabelOf("skin"));
  EXPECT_EQ(at(0, -58), volume::LabelOf("fat"));
}

// Tubes along the three axes, open at their ends: a ring of bone is seen along one axis only.
TEST(FindTissues, FattyMarrowIsBoneAlongWhicheverAxisABoneLies) {
  volume::Geometry g;
  g.size = {72, 72, 72};
  g.origin_mm = {-35.5, -35.5, -35.5};
  volume::CtVolume ct(g, -1000);
  const Eigen::Vector3d middle_mm[3] = {{0, -12, -12}, {12, 0, 12}, {-12, 12, 0}};
  RandomStream random(4, "noise", 0);
  for (int k = 0; k < 72; ++k) {
    for (int j = 0; j < 72; ++j) {
      for (int i = 0; i < 72; ++i) {
        const Eigen::Vector3d p = g.ct_from_index() * Eigen::Vector3d(i, j, k);
        if (p.norm() > 34.0) continue;
        double hu = 40.0;
        for (int axis = 0; axis < 3; ++axis) {
          Eigen::Vector3d d = p - middle_mm[axis];
          if (std::abs(d[axis]) > 14.0) continue;
          d[axis] = 0.0;
          if (d.norm() < 7.0) hu = d.norm() < 4.2 ? -60.0 : 800.0;
        }
        ct.At(i, j, k) = static_cast<std::int16_t>(hu + 10.0 * random.Normal());
      }
    }
  }
  const auto found = FindTissues(ct, Defaults(), TwoThreads()).labels;
  for (const Eigen::Vector3d& at_mm : middle_mm) {
    const Eigen::Array3i at = (g.index_from_ct() * at_mm).array().round().cast<int>();
    EXPECT_EQ(found.At(at[0], at[1], at[2]), volume::LabelOf("bone")) << at_mm.transpose();
  }
}

TEST(FindTissues, AnEvenSkullIsBoneAndNoBladder) {
  volume::Geometry g;
  g.size = {90, 90, 80};
  g.spacing_mm = {2.0, 2.0, 2.0};
  g.origin_mm = {-89.0, -89.0, -79.0};
  volume::CtVolume ct(g, -1000);
  volume::LabelMap truth(g);
  RandomStream random(4, "noise", 0);
  for (std::size_t n = 0; n < ct.voxels.size(); ++n) {
    const auto row = static_cast<std::size_t>(g.size[0]);
    const auto slice = g.Index(0, 0, 1);
    const Eigen::Vector3d index(static_cast<double>(n % row), static_cast<double>(n % slice / row),
                                static_cast<double>(n / slice));
    const double r = (g.ct_from_index() * index).norm();
    if (r > 74.0) continue;
    const bool bone = r > 62.0 && r < 70.0;
    ct.voxels[n] = static_cast<std::int16_t>((bone ? 1100.0 : 35.0) + 12.0 * random.Normal());
    truth.voxels[n] = volume::LabelOf(bone ? "bone" : "soft_tissue");
  }
  const auto found = FindTissues(ct, Defaults(), TwoThreads()).labels;
  EXPECT_GT(Dice(Of(found, "bone"), Of(truth, "bone")), 0.95);
}

TEST(FindTissues, SkinIsNotWhereTheBorderCutsTheBody) {
  const SyntheticBody body = MakeSyntheticBody({});
  const auto found = FindTissues(body.ct, Defaults(), TwoThreads()).labels;
  const Eigen::Array3i middle =
      (found.geometry.index_from_ct() * Eigen::Vector3d(40, 20, 0)).array().round().cast<int>();
  EXPECT_EQ(found.At(middle[0], middle[1], 0), volume::LabelOf("soft_tissue"));
}

TEST(FindTissues, TheSameBitsOnOneAndThreeThreads) {
  const SyntheticBody body = MakeSyntheticBody({.blood_hu = 300.0});
  RunContext three;
  three.num_threads = 3;
  EXPECT_EQ(FindTissues(body.ct, Defaults(), RunContext{}).labels.voxels,
            FindTissues(body.ct, Defaults(), three).labels.voxels);
}

TEST(FindTissues, RefusesACtOfAir) {
  volume::Geometry g;
  g.size = {20, 20, 20};
  EXPECT_THAT([&] { FindTissues(volume::CtVolume(g, -1000), Defaults(), RunContext{}); },
              ThrowsMessage<InputError>(HasSubstr("no body")));
}

OrganSeed VesselSeed() {
  OrganSeed organ;
  organ.tissue = "vessel";
  organ.points_mm = {{28, 12, 30}};
  organ.lower_hu = 150;
  organ.upper_hu = 400;
  organ.radius_mm = 60;
  organ.smoothing_mm = 2;
  organ.iterations = 400;
  return organ;
}

TEST(FindOrgan, RegionGrowingAndLevelSetFindTheVessel) {
  const SyntheticBody body = MakeSyntheticBody({.blood_hu = 250.0});
  Mask truth(body.ct.geometry);
  for (int k = 0; k < truth.geometry.size[2]; ++k) {
    for (int j = 0; j < truth.geometry.size[1]; ++j) {
      for (int i = 0; i < truth.geometry.size[0]; ++i) {
        const Eigen::Vector3d p = truth.geometry.ct_from_index() * Eigen::Vector3d(i, j, k);
        truth.At(i, j, k) = (p.head<2>() - Eigen::Vector2d(28, 12)).norm() <= 11.0 ? 1 : 0;
      }
    }
  }
  OrganSeed organ = VesselSeed();
  EXPECT_GT(Dice(FindOrgan(body.ct, organ, RunContext{}), truth), 0.9);
  organ.method = OrganSeed::Method::kLevelSet;
  EXPECT_GT(Dice(FindOrgan(body.ct, organ, RunContext{}), truth), 0.85);
}

TEST(FindOrgan, RefusesSeedsThatCannotBe) {
  const SyntheticBody body = MakeSyntheticBody({.blood_hu = 250.0});
  OrganSeed organ = VesselSeed();
  organ.points_mm = {{28, 12, 300}};
  EXPECT_THAT([&] { FindOrgan(body.ct, organ, RunContext{}); },
              ThrowsMessage<InputError>(HasSubstr("outside the CT")));
  organ.points_mm = {{0, 42, 30}};
  EXPECT_THAT([&] { FindOrgan(body.ct, organ, RunContext{}); },
              ThrowsMessage<InputError>(HasSubstr("outside the range")));
  organ.points_mm.clear();
  EXPECT_THROW(FindOrgan(body.ct, organ, RunContext{}), InputError);
}

}  // namespace
}  // namespace acus::segmentation
