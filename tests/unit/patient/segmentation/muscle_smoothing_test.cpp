#include "acus/patient/segmentation/muscle_smoothing.h"

#include <gmock/gmock.h>

#include "acus/base/core/random.h"
#include "acus/data/volume/labels.h"

namespace acus::segmentation {
namespace {

constexpr double kFatUpperHu = -30.0;

/// 40 x 40 x 40 voxels of 1 mm: 8 of subcutaneous fat, then muscle of which a share is fat.
struct FattyMuscle {
  explicit FattyMuscle(double fat_share) {
    volume::Geometry g;
    g.size = {40, 40, 40};
    ct = volume::CtVolume(g, -100);
    labels = volume::LabelMap(g, volume::LabelOf("fat"));
    RandomStream random(7, "fat in muscle");
    for (int k = 0; k < 40; ++k) {
      for (int j = 8; j < 40; ++j) {
        for (int i = 0; i < 40; ++i) {
          if (random.Uniform() < fat_share) continue;
          ct.At(i, j, k) = 50;
          labels.At(i, j, k) = volume::LabelOf("muscle");
        }
      }
    }
  }
  /// How often a straight path from the skin comes from fat into muscle.
  int NumFascias(int i, int k) const {
    int fascias = 0;
    for (int j = 1; j < 40; ++j) {
      fascias += labels.At(i, j, k) == volume::LabelOf("muscle") &&
                         labels.At(i, j - 1, k) == volume::LabelOf("fat")
                     ? 1
                     : 0;
    }
    return fascias;
  }
  volume::CtVolume ct;
  volume::LabelMap labels;
};

TEST(MuscleSmoothing, ANeedleMeetsOneFasciaInAFattyMuscle) {
  FattyMuscle body(0.2);
  EXPECT_GE(body.NumFascias(20, 20), 3);
  SmoothMuscles(body.ct, kFatUpperHu, body.labels);
  for (const int at : {10, 15, 20, 25, 30}) EXPECT_EQ(body.NumFascias(at, 20), 1) << at;
  EXPECT_EQ(body.labels.At(20, 3, 20), volume::LabelOf("fat"));
}

TEST(MuscleSmoothing, SpecksOfMuscleInFatGo) {
  FattyMuscle body(1.0);
  for (const int at : {10, 20, 30}) {
    for (int k = 10; k < 30; ++k) {
      body.labels.At(at, at, k) = volume::LabelOf("muscle");
      body.ct.At(at, at, k) = 40;
    }
  }
  SmoothMuscles(body.ct, kFatUpperHu, body.labels);
  EXPECT_THAT(body.labels.voxels, testing::Not(testing::Contains(volume::LabelOf("muscle"))));
  EXPECT_EQ(body.labels.At(20, 20, 20), volume::LabelOf("soft_tissue"));
}

TEST(MuscleSmoothing, LayersOfFatBetweenMusclesStay) {
  FattyMuscle body(0.0);
  for (int k = 0; k < 40; ++k) {
    for (int i = 0; i < 40; ++i) {
      for (int j = 20; j < 22; ++j) body.labels.At(i, j, k) = volume::LabelOf("fat");
    }
  }
  const auto before = body.labels.voxels;
  SmoothMuscles(body.ct, kFatUpperHu, body.labels);
  EXPECT_EQ(body.labels.voxels, before);
}

}  // namespace
}  // namespace acus::segmentation
