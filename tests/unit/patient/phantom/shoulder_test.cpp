#include "acus/patient/phantom/anatomy/shoulder.h"

#include <gtest/gtest.h>

#include "acus/data/volume/labels.h"

namespace acus::phantom {
namespace {

using Eigen::Vector3d;

BodySettings ShoulderBody() {
  BodySettings settings;
  settings.region = BodySettings::Region::kShoulder;
  settings.subcutaneous_fat_mm = 6.0;
  settings.lesion_centre_mm = Vector3d::Zero();
  return settings;
}

/// Labels met from the skin towards the centre of the head, 40 degrees off the vertical laterally,
/// and how long each is, mm.
std::vector<std::pair<std::string, double>> LayersOf(const Anatomy& anatomy) {
  const double angle = 40.0 * std::numbers::pi / 180.0;
  const Vector3d outwards(-std::sin(angle), 0.0, std::cos(angle));
  std::vector<std::pair<std::string, double>> layers;
  for (double radius = 90.0; radius > 20.0; radius -= 0.05) {
    const auto label = anatomy.LabelAt(radius * outwards);
    const std::string name(volume::StandardLabels()[label].name);
    if (layers.empty() || layers.back().first != name) layers.emplace_back(name, 0.0);
    layers.back().second += 0.05;
  }
  return layers;
}

std::vector<std::string> Names(const std::vector<std::pair<std::string, double>>& layers) {
  std::vector<std::string> names;
  for (const auto& [name, thickness] : layers) names.push_back(name);
  return names;
}

class ShoulderSeeds : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Shoulder, ShoulderSeeds, testing::Values(0, 1, 2, 17, 90210));

TEST_P(ShoulderSeeds, HasTheLayersOfThePaperFromTheSkinToBone) {
  const Anatomy anatomy(ShoulderBody(), GetParam());
  EXPECT_EQ(Names(LayersOf(anatomy)), (std::vector<std::string>{"outside", "skin", "fat", "muscle",
                                                                "fat", "bursa", "tendon", "bone"}));
  EXPECT_EQ(anatomy.LabelAt(anatomy.Landmark("bursa")), volume::LabelOf("bursa"));
  EXPECT_EQ(anatomy.LabelAt(anatomy.Landmark("tendon")), volume::LabelOf("tendon"));
  EXPECT_EQ(anatomy.LabelAt(anatomy.Landmark("joint") - Vector3d(1.2, 0.0, 0.0)),
            volume::LabelOf("cartilage"));
}

TEST_P(ShoulderSeeds, AnEffusionThickensTheBursaAndLiftsTheSkin) {
  BodySettings ill = ShoulderBody();
  ill.shoulder.bursa_mm = 6.0;
  const auto healthy = LayersOf(Anatomy(ShoulderBody(), GetParam()));
  const auto swollen = LayersOf(Anatomy(ill, GetParam()));
  ASSERT_EQ(Names(swollen), Names(healthy));
  EXPECT_NEAR(healthy[5].second / Anatomy(ill, GetParam()).scale(), 1.5, 0.2);
  EXPECT_NEAR(swollen[5].second / Anatomy(ill, GetParam()).scale(), 6.0, 0.2);
  EXPECT_GT(healthy[0].second, swollen[0].second + 1.0);
}

TEST_P(ShoulderSeeds, CalcificationAndTearReplaceTendonOnlyWhereTheyAre) {
  BodySettings ill = ShoulderBody();
  ill.shoulder.calcification_mm = 6.0;
  const Anatomy calcified(ill, GetParam());
  EXPECT_EQ(calcified.MaterialAt(calcified.Landmark("calcification")), Material::kCalcification);
  ill = ShoulderBody();
  ill.shoulder.tear_mm = 10.0;
  const Anatomy torn(ill, GetParam());
  EXPECT_EQ(torn.LabelAt(torn.Landmark("tear")), volume::LabelOf("bursa"));
  EXPECT_EQ(torn.LabelAt(torn.Landmark("tendon") + Vector3d(0.0, 9.0, 0.0)),
            volume::LabelOf("tendon"));
  const Anatomy healthy(ShoulderBody(), GetParam());
  EXPECT_EQ(healthy.LabelAt(healthy.Landmark("tear")), volume::LabelOf("tendon"));
  EXPECT_EQ(healthy.LabelAt(healthy.Landmark("calcification")), volume::LabelOf("tendon"));
}

TEST(BileDucts, AreThereOnlyIfTheyAreDilated) {
  BodySettings settings;
  settings.lesion_centre_mm = Vector3d(-82, -20, 134);
  const Vector3d duct(-72, -54, 147);
  EXPECT_EQ(Anatomy(settings, 1).LabelAt(duct), volume::LabelOf("liver"));
  settings.bile_duct_mm = 7.0;
  const Anatomy dilated(settings, 1);
  EXPECT_EQ(dilated.LabelAt(dilated.Landmark("bile_duct")), volume::LabelOf("gallbladder"));
}

TEST(LiverCyst, TakesThePlaceOfTheLesion) {
  BodySettings settings;
  settings.lesion_centre_mm = Vector3d(-82, -20, 134);
  EXPECT_EQ(Anatomy(settings, 1).LabelAt(Anatomy(settings, 1).Landmark("lesion")),
            volume::LabelOf("lesion"));
  settings.liver_cyst_mm = 40.0;
  const Anatomy ill(settings, 1);
  const Vector3d centre = ill.Landmark("cyst");
  EXPECT_EQ(ill.MaterialAt(centre + ill.scale() * Vector3d(0, 0, 19.5)), Material::kCyst);
  EXPECT_EQ(ill.LabelAt(centre + ill.scale() * Vector3d(0, 0, 20.5)), volume::LabelOf("liver"));
}

TEST(RenalPelvis, IsWithinTheRightKidneyIfItIsDilated) {
  BodySettings settings;
  for (const std::uint64_t seed : {0, 1, 2, 3}) {
    settings.renal_pelvis_mm = 20.0;
    const Anatomy dilated(settings, seed);
    const Vector3d calyx = dilated.Landmark("lower_calyx");
    EXPECT_EQ(dilated.MaterialAt(calyx), Material::kUrine) << seed;
    settings.renal_pelvis_mm = 0.0;
    EXPECT_EQ(Anatomy(settings, seed).LabelAt(calyx), volume::LabelOf("kidney")) << seed;
  }
}

}  // namespace
}  // namespace acus::phantom
