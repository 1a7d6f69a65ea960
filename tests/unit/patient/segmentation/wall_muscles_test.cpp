#include "acus/patient/segmentation/segmenters/wall_muscles.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <gtest/gtest.h>

#include "acus/data/volume/labels.h"
#include "acus/patient/phantom/anatomy/imaging.h"
#include "acus/patient/phantom/anatomy/phantom_config.h"
#include "acus/patient/segmentation/patient_segmentation.h"
#include "synthetic_body.h"

namespace acus::segmentation {
namespace {

using Eigen::Vector3d;
using volume::Label;
using volume::LabelMap;

/// The trunk of a synthetic patient, and what is found in its CT; the organs are the exact ones, as
/// imported labels are.
struct Flank {
  LabelMap exact, found;
  std::size_t muscle_in_organs = 0;  ///< Voxels of exact organs that were taken for muscle.
};

struct FlankOptions {
  std::uint64_t seed = 1;
  Eigen::Array3d spacing_mm = {2.0, 2.0, 3.0};
  double noise_hu = 0.0;  ///< Beside that of the preset.
};

bool IsOrgan(Label label) {
  static const std::array kOrganLabels = {volume::LabelOf("liver"), volume::LabelOf("kidney"),
                                          volume::LabelOf("spleen"), volume::LabelOf("lesion")};
  return std::ranges::find(kOrganLabels, label) != kOrganLabels.end();
}

Flank MakeFlank(const FlankOptions& options) {
  auto config = phantom::ReadPhantomConfig(ACUS_SOURCE_DIR "/configs/phantoms/liver.json");
  config.grid.size = (config.grid.size.cast<double>() * config.grid.spacing_mm / options.spacing_mm)
                         .floor()
                         .cast<int>();
  config.grid.spacing_mm = options.spacing_mm;
  RunContext context;
  context.seed = options.seed;
  context.num_threads = 2;
  const phantom::Anatomy anatomy(config.body, options.seed);
  phantom::Scan scan = phantom::RenderScan(anatomy, config.grid, config.scanner, context);
  RandomStream random(options.seed, "more noise", 0);
  for (std::int16_t& hu : scan.ct.voxels) {
    if (options.noise_hu > 0.0 && hu > -1000) {
      hu = static_cast<std::int16_t>(std::lround(hu + options.noise_hu * random.Normal()));
    }
  }
  const auto settings =
      ReadSegmentationConfig(ACUS_SOURCE_DIR "/configs/segmentation/default.json");
  Flank flank{.exact = scan.labels, .found = SegmentPatient(scan.ct, settings, context).labels};
  const Label muscle = volume::LabelOf("muscle");
  for (std::size_t n = 0; n < flank.found.voxels.size(); ++n) {
    if (!IsOrgan(flank.exact.voxels[n])) continue;
    flank.muscle_in_organs += flank.found.voxels[n] == muscle ? 1U : 0U;
    flank.found.voxels[n] = flank.exact.voxels[n];
  }
  return flank;
}

/// Whether a path of 120 mm meets the liver, but neither bone nor lung before it.
bool IsFree(const LabelMap& labels, const Vector3d& from_mm, const Vector3d& along) {
  const Label liver = volume::LabelOf("liver"), bone = volume::LabelOf("bone"),
              lung = volume::LabelOf("lung");
  for (double depth_mm = 0.0; depth_mm < 120.0; depth_mm += 0.5) {
    const Vector3d index = labels.geometry.index_from_ct() * (from_mm + depth_mm * along);
    const Eigen::Array3i v = index.array().round().cast<int>();
    if (!labels.geometry.Contains(v[0], v[1], v[2])) continue;
    const Label here = labels.At(v[0], v[1], v[2]);
    if (here == bone || here == lung) return false;
    if (here == liver) return true;
  }
  return false;
}

/// Tissues beneath the skin that a needle enters with a membrane (configs/forces/default.json), up
/// to the liver. @pre the path meets it.
std::string MembranesTo(const LabelMap& labels, const Vector3d& from_mm, const Vector3d& along) {
  const Label fat = volume::LabelOf("fat"), skin = volume::LabelOf("skin"),
              muscle = volume::LabelOf("muscle"), liver = volume::LabelOf("liver");
  std::string met;
  Label before = 0;
  for (double depth_mm = 0.0; depth_mm < 120.0; depth_mm += 0.5) {
    const Vector3d index = labels.geometry.index_from_ct() * (from_mm + depth_mm * along);
    const Eigen::Array3i v = index.array().round().cast<int>();
    if (!labels.geometry.Contains(v[0], v[1], v[2])) continue;
    const Label here = labels.At(v[0], v[1], v[2]);
    if (here == muscle && (before == fat || before == skin)) met += "muscle ";
    if (here == liver) return met + "liver";
    before = here;
  }
  return met;
}

/// Paths to the liver whose membranes are those of the exact labels, and all of them.
struct PathCount {
  int same = 0, all = 0;
};

PathCount ComparePaths(const Flank& flank) {
  PathCount count;
  for (double z_mm = 90.0; z_mm <= 200.0; z_mm += 5.0) {
    for (double y_mm = -80.0; y_mm <= 20.0; y_mm += 5.0) {
      for (const double lean : {-0.3, 0.0, 0.3}) {
        const Vector3d along = Vector3d(1.0, lean, 0.1).normalized();
        const Vector3d from_mm = Vector3d(-60.0, y_mm, z_mm) - 120.0 * along;
        if (!IsFree(flank.exact, from_mm, along)) continue;
        const std::string exact = MembranesTo(flank.exact, from_mm, along);
        ++count.all;
        count.same += MembranesTo(flank.found, from_mm, along) == exact ? 1 : 0;
      }
    }
  }
  return count;
}

double DiceOfMuscle(const Flank& flank) {
  const Label muscle = volume::LabelOf("muscle");
  double both = 0.0, sum = 0.0;
  for (std::size_t n = 0; n < flank.found.voxels.size(); ++n) {
    const bool ours = flank.found.voxels[n] == muscle, theirs = flank.exact.voxels[n] == muscle;
    both += ours && theirs;
    sum += ours + theirs;
  }
  return 2.0 * both / sum;
}

void ExpectTheWallOf(const FlankOptions& options, double least_dice, double least_same) {
  const Flank flank = MakeFlank(options);
  const double dice = DiceOfMuscle(flank);
  const PathCount paths = ComparePaths(flank);
  std::cout << "seed " << options.seed << ": Dice " << dice << ", same membranes on " << paths.same
            << " of " << paths.all << " paths, muscle in " << flank.muscle_in_organs
            << " voxels of organs\n";
  EXPECT_GT(dice, least_dice);
  EXPECT_GT(paths.all, 100);
  EXPECT_GT(paths.same, least_same * paths.all);
}

TEST(WallMuscles, OfSyntheticPatientsAreMetAsTheExactOnes) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    ExpectTheWallOf({.seed = seed}, 0.85, 0.95);
  }
}

TEST(WallMuscles, AreMetInNoiseAndThickSlices) {
  ExpectTheWallOf({.seed = 4, .noise_hu = 25.0}, 0.80, 0.85);
  ExpectTheWallOf({.seed = 5, .spacing_mm = {1.6, 1.6, 5.0}}, 0.80, 0.90);
}

TEST(WallMuscles, NeedASpine) {
  LabelMap labels(MakeSyntheticBody({}).truth.geometry, volume::LabelOf("soft_tissue"));
  const auto before = labels.voxels;
  AddWallMuscles(labels, 1);
  EXPECT_EQ(labels.voxels, before);
}

TEST(WallMuscles, HaveTheSameBitsForAnyNumberOfThreads) {
  LabelMap one = MakeSyntheticBody({}).truth, three = one;
  const auto before = one.voxels;
  AddWallMuscles(one, 1);
  AddWallMuscles(three, 3);
  EXPECT_EQ(one.voxels, three.voxels);
  EXPECT_NE(one.voxels, before);
}

}  // namespace
}  // namespace acus::segmentation
