#include "acus/patient/segmentation/spine/spine.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

#include "acus/data/volume/labels.h"
#include "lumbar_back.h"

namespace acus::segmentation {
namespace {

using volume::LabelMap;

/// The back of a synthetic patient with exact labels, and what is found in its CT.
struct SpineCase {
  LabelMap truth;
  LabelMap found;
};

SpineCase SegmentedBack(std::uint64_t seed) {
  LumbarBack back = MakeLumbarBack(seed);
  return {std::move(back.scan.labels), std::move(back.found)};
}

/// 2 |A and B| / (|A| + |B|) of a label in the slices from `first` to `last`.
double DiceOf(const SpineCase& back, const char* name, int first, int last) {
  const volume::Label label = volume::LabelOf(name);
  const volume::Geometry& g = back.truth.geometry;
  std::size_t both = 0;
  std::size_t sum = 0;
  for (std::size_t i = g.Index(0, 0, first); i < g.Index(0, 0, last + 1); ++i) {
    const bool ours = back.found.voxels[i] == label;
    const bool theirs = back.truth.voxels[i] == label;
    both += ours && theirs ? 1U : 0U;
    sum += (ours ? 1U : 0U) + (theirs ? 1U : 0U);
  }
  return sum == 0 ? 1.0 : 2.0 * static_cast<double>(both) / static_cast<double>(sum);
}

double VolumeOf(const LabelMap& labels, const char* name) {
  const auto count = std::ranges::count(labels.voxels, volume::LabelOf(name));
  return static_cast<double>(count) * labels.geometry.voxel_volume_mm3() / 1000.0;
}

/// Row of the first ligament behind the canal in a column, at most `reach` behind it; -1 if none,
/// or if bone comes first or at once behind it.
int FlavumRow(const LabelMap& labels, int i, int k, int reach) {
  int back = -1;
  for (int j = 0; j < labels.geometry.size[1]; ++j) {
    if (labels.At(i, j, k) == volume::LabelOf("spinal_canal")) back = j;
  }
  for (int j = back + 1; back >= 0 && j <= back + reach; ++j) {
    if (labels.At(i, j, k) == volume::LabelOf("bone")) return -1;
    if (labels.At(i, j, k) == volume::LabelOf("ligament"))
      return labels.At(i, j + 1, k) == volume::LabelOf("bone") ? -1 : j;
  }
  return -1;
}

class SpineOfSeed : public testing::TestWithParam<int> {};
// The method was developed on seeds 1 and 2 only.
INSTANTIATE_TEST_SUITE_P(Phantom, SpineOfSeed, testing::Range(1, 21));

TEST_P(SpineOfSeed, HasAnOpenCanalAndItsLigaments) {
  const SpineCase back = SegmentedBack(static_cast<std::uint64_t>(GetParam()));
  const volume::Geometry& g = back.truth.geometry;
  const auto slice_of = [&](double z_mm) {
    return static_cast<int>(std::lround((z_mm - g.origin_mm.z()) / g.spacing_mm[2]));
  };
  const double whole = DiceOf(back, "spinal_canal", 0, g.size[2] - 1);
  const double lumbar = DiceOf(back, "spinal_canal", slice_of(-70), slice_of(105));
  double least = 1.0;
  for (int k = slice_of(-70); k <= slice_of(105); ++k) {
    least = std::min(least, DiceOf(back, "spinal_canal", k, k));
  }
  int windows = 0;
  int near = 0;
  const int midline = static_cast<int>(std::lround(-g.origin_mm.x() / g.spacing_mm[0]));
  for (int k = slice_of(-70); k <= slice_of(105); ++k) {
    const int theirs = FlavumRow(back.truth, midline, k, 5);
    if (theirs < 0) continue;
    ++windows;
    const int ours = FlavumRow(back.found, midline, k, 9);
    near += ours >= 0 && std::abs(ours - theirs) * g.spacing_mm[1] <= 1.0 ? 1 : 0;
  }
  const double bone = VolumeOf(back.found, "bone") / VolumeOf(back.truth, "bone");
  const double discs = DiceOf(back, "disc", 0, g.size[2] - 1);
  std::cout << "seed " << GetParam() << ": canal Dice " << whole << ", L1 to L5 " << lumbar
            << ", least slice " << least << "; flavum within 1 mm in " << near << " of " << windows
            << " slices; bone volume ratio " << bone << "; disc Dice " << discs << '\n';
  // In one of the twenty the canal of the sacrum is lost, and with it the last disc.
  EXPECT_GE(whole, 0.88);
  EXPECT_GE(lumbar, 0.95);
  EXPECT_GE(least, 0.8) << "the canal is nearly closed in a slice";
  ASSERT_GE(windows, 20);
  EXPECT_GE(near, 0.8 * windows);
  EXPECT_NEAR(bone, 1.0, 0.05);
  EXPECT_GE(discs, 0.79);
}

TEST(Spine, IsNotMadeUpWhereThereIsNone) {
  volume::Geometry g;
  g.size = {60, 60, 40};
  g.spacing_mm = {2.0, 2.0, 2.0};
  volume::CtVolume ct(g, 50);
  const Mask body(g, 1);
  const auto settings =
      ReadSegmentationConfig(ACUS_SOURCE_DIR "/configs/segmentation/default.json");
  // A tube of bone without a vertebral body in front.
  for (int k = 0; k < g.size[2]; ++k) {
    for (int j = 0; j < g.size[1]; ++j) {
      for (int i = 0; i < g.size[0]; ++i) {
        const double r = std::hypot(2.0 * (i - 30), 2.0 * (j - 30));
        if (r > 9.0 && r < 14.0) ct.At(i, j, k) = 900;
      }
    }
  }
  const BoneFound bone = FindDenseBone(ct, body, settings.tissues, 1);
  EXPECT_GT(Count(bone.dense), 0U);
  EXPECT_FALSE(FindSpine(ct, body, bone, settings.tissues, 1));
  EXPECT_NE(SpineSentence(LabelMap(g)).find("No spine found"), std::string::npos);
}

TEST(Spine, IsTheSameInWhateverOrderTheAxesAreStored) {
  auto config = phantom::ReadPhantomConfig(ACUS_SOURCE_DIR "/configs/phantoms/lumbar.json");
  config.grid.origin_mm = Eigen::Vector3d(-60, -50, -40);
  config.grid.spacing_mm = {1.5, 1.5, 2.0};
  config.grid.size = {81, 81, 50};
  const RunContext context;
  const phantom::Anatomy anatomy(config.body, 1);
  auto settings = config.scanner;
  settings.noise_sd_hu = 0.0;  // Noise belongs to voxels, and these are numbered otherwise.
  settings.psf_sigma_mm = 0.0;
  settings.supersampling = 1;
  volume::Geometry other = config.grid;
  // Stored from the back to the front, head first.
  other.size = {81, 81, 50};
  other.direction.col(1) *= -1.0;
  other.direction.col(2) *= -1.0;
  other.origin_mm = config.grid.ct_from_index() * Eigen::Vector3d(0, 80, 49);
  const auto tissues =
      ReadSegmentationConfig(ACUS_SOURCE_DIR "/configs/segmentation/default.json").tissues;
  const LabelMap a =
      FindTissues(phantom::RenderScan(anatomy, config.grid, settings, context).ct, tissues, context)
          .labels;
  const LabelMap b =
      FindTissues(phantom::RenderScan(anatomy, other, settings, context).ct, tissues, context)
          .labels;
  EXPECT_GT(VolumeOf(a, "spinal_canal"), 10.0);
  std::size_t differing = 0;
  for (int k = 0; k < 50; ++k) {
    for (int j = 0; j < 81; ++j) {
      for (int i = 0; i < 81; ++i) differing += a.At(i, j, k) != b.At(i, 80 - j, 49 - k) ? 1U : 0U;
    }
  }
  EXPECT_EQ(differing, 0U);
}

}  // namespace
}  // namespace acus::segmentation
