#include "simulation/image_level.h"

#include <gtest/gtest.h>
#include <set>

#include "support/layered_scene.h"

namespace acus::simulation {
namespace {

using scenario::UltrasoundEffect;
using scenario::UltrasoundModel;

/// Every level with the preset that it takes by default.
const std::pair<UltrasoundModel, const char*> kLevels[] = {
    {UltrasoundModel::kVidal2008, "acoustics/vidal_2008.json"},
    {UltrasoundModel::kAlamilla2021, "acoustics/alamilla_2021.json"},
    {UltrasoundModel::kColumns2010, "acoustics/hu_textured.json"},
};

/// Straight down on the layers of layered_scene.h.
Eigen::Isometry3d OnTheSkin() {
  Eigen::Isometry3d ct_from_probe = Eigen::Isometry3d::Identity();
  ct_from_probe.linear() << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  ct_from_probe.translation() << 0.0, 0.0, -0.5;
  return ct_from_probe;
}

TEST(ImageLevel, EveryLevelReadsItsPresetAndShowsTheScene) {
  const Scene scene =
      testing_support::LayeredScene(testing_support::PlanOf(false, true, false, false), false);
  std::set<std::vector<std::uint8_t>> pictures;
  for (const auto& [model, preset] : kLevels) {
    UltrasoundEffect effect;
    effect.model = model;
    effect.acoustics = std::filesystem::path(ACUS_SOURCE_DIR) / "configs" / preset;
    ImageLevel level({scene.ct.get(), scene.labels.get()}, *scene.probe, ReadImageSettings(effect));
    ultrasound::GrayImage image;
    level.Render(OnTheSkin(), std::nullopt, image, 2);
    EXPECT_EQ(image.width, level.picture().width_px);
    int bright = 0;
    for (const std::uint8_t pixel : image.pixels) bright += pixel > 30 ? 1 : 0;
    EXPECT_GT(bright, 1000) << preset;
    pictures.insert(image.pixels);
  }
  EXPECT_EQ(pictures.size(), std::size(kLevels)) << "two levels gave the same picture";
}

}  // namespace
}  // namespace acus::simulation
