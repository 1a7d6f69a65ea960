#include "acus/patient/segmentation/voxels/scan_quality.h"

#include <gmock/gmock.h>

#include "acus/data/volume/labels.h"
#include "acus/patient/segmentation/patient_segmentation.h"
#include "synthetic_body.h"

namespace acus::segmentation {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::ThrowsMessage;

SegmentationConfig DefaultConfig() {
  return ReadSegmentationConfig(ACUS_SOURCE_DIR "/configs/segmentation/default.json");
}

std::vector<std::string> WarningsFor(const volume::CtVolume& ct) {
  return WarningsOf(ct, FindTissues(ct, DefaultConfig().tissues, {}));
}

TEST(ScanQuality, AUsualBodyHasNoWarnings) {
  EXPECT_THAT(WarningsFor(MakeSyntheticBody({}).ct), IsEmpty());
}

TEST(ScanQuality, ParametersOfTheScanAreFound) {
  const SyntheticBody plain = MakeSyntheticBody({.noise_hu = 20.0});
  const ScanParameters scan = FindTissues(plain.ct, DefaultConfig().tissues, {}).scan;
  EXPECT_NEAR(scan.noise_hu, 20.0, 2.0);
  EXPECT_NEAR(scan.soft_tissue_hu, 50.0, 6.0);
  EXPECT_FALSE(scan.enhanced);
  const SyntheticBody enhanced = MakeSyntheticBody({.blood_hu = 300.0});
  // 30 slices of a circle of 11 mm radius, 2 mm apart.
  EXPECT_NEAR(FindTissues(enhanced.ct, DefaultConfig().tissues, {}).scan.contrast_ml, 22.8, 3.0);
}

TEST(ScanQuality, AMaskIsNoCt) {
  volume::CtVolume mask(MakeSyntheticBody({}).ct.geometry, 0);
  for (std::size_t i = mask.voxels.size() / 3; i < mask.voxels.size() / 2; ++i) mask.voxels[i] = 1;
  EXPECT_THAT([&] { SegmentPatient(mask, DefaultConfig(), {}); },
              ThrowsMessage<InputError>(AllOf(HasSubstr("from 0 to 1"), HasSubstr("--import"))));
}

TEST(ScanQuality, ALostInterceptIsRefused) {
  volume::CtVolume ct = MakeSyntheticBody({}).ct;
  for (auto& hu : ct.voxels) hu = static_cast<std::int16_t>(hu + 1024);
  EXPECT_THAT(
      [&] { WarningsFor(ct); },
      ThrowsMessage<NoAnswerError>(AllOf(HasSubstr("as dense as bone"), HasSubstr("intercept"))));
}

TEST(ScanQuality, ABodyWithoutBoneIsSaidToHaveNone) {
  volume::CtVolume ct = MakeSyntheticBody({}).ct;
  for (auto& hu : ct.voxels) hu = std::min<std::int16_t>(hu, 70);
  EXPECT_THAT(WarningsFor(ct), Contains(HasSubstr("no bone was found")));
}

TEST(ScanQuality, ThickSlicesAndNoiseAreSaid) {
  volume::CtVolume ct = MakeSyntheticBody({.noise_hu = 70.0}).ct;
  ct.geometry.spacing_mm[2] = 8.0;
  const auto warnings = WarningsFor(ct);
  EXPECT_THAT(warnings, Contains(HasSubstr("noise")));
  EXPECT_THAT(warnings, Contains(HasSubstr("8.0 mm apart")));
}

TEST(ScanQuality, CertaintyFallsWhereTheValuesAreNearAThreshold) {
  const SegmentationConfig config = DefaultConfig();
  const auto certainty_of = [&](const volume::CtVolume& ct) {
    return FindCertainty(ct, config.tissues, SegmentPatient(ct, config, {}).labels, {});
  };
  const auto dice_of = [](const Certainty& certainty, const char* name) {
    for (const auto& tissue : certainty.tissues) {
      if (tissue.name == name) return tissue.dice;
    }
    return -1.0;
  };
  SyntheticBody clear = MakeSyntheticBody({.noise_hu = 2.0});
  // Fat of -30 HU, at the threshold, in place of -100 HU.
  SyntheticBody unclear = clear;
  for (auto& hu : unclear.ct.voxels) {
    if (hu < -80 && hu > -120) hu = static_cast<std::int16_t>(hu + 70);
  }
  const Certainty good = certainty_of(clear.ct);
  const Certainty bad = certainty_of(unclear.ct);
  EXPECT_GT(dice_of(good, "fat"), 0.95);
  EXPECT_LT(dice_of(bad, "fat"), 0.6);
  EXPECT_GT(dice_of(bad, "lung"), 0.95);
  EXPECT_GT(bad.unsure_ml, 3.0 * good.unsure_ml);
  // Where: in the layer of fat, not in the lung.
  const volume::Geometry& g = clear.ct.geometry;
  const auto unsure_at = [&](double x, double y) {
    const Eigen::Array3i v =
        (g.index_from_ct() * Eigen::Vector3d(x, y, 30)).array().round().cast<int>();
    return bad.unsure.At(v[0], v[1], v[2]);
  };
  EXPECT_GT(unsure_at(-85, 0), 0);
  EXPECT_EQ(unsure_at(-45, -15), 0);
}

}  // namespace
}  // namespace acus::segmentation
