#include "acus/scene/simulation/image_level.h"

#include <gtest/gtest.h>
#include <set>

#include "acus/base/config/json_file.h"
#include "support/layered_scene.h"

namespace acus::simulation {
namespace {

/// A level as a scenario that says no more than its name has it.
scenario::UltrasoundEffect EffectOf(const std::string& model) {
  nlohmann::json document = {{"format", "acus-scenario/1"},
                             {"patient", nlohmann::json::object()},
                             {"effects", {{"ultrasound", {{"model", model}}}}}};
  document = config::CheckedConfig(std::move(document), "acus-scenario", "test");
  return scenario::ReadUltrasoundEffect(document.at("effects").at("ultrasound"),
                                        std::filesystem::path(ACUS_SOURCE_DIR) / "configs");
}

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
  const std::vector<std::string> levels = {"vidal_2008", "alamilla_2021", "columns_2010", "beams",
                                           "aperture"};
  for (const std::string& name : levels) {
    const scenario::UltrasoundEffect effect = EffectOf(name);
    ImageLevel level({scene.ct.get(), scene.labels.get()}, *scene.probe,
                     ReadImageSettings(effect, scene.labels.get()));
    image::GrayImage image;
    level.Render(OnTheSkin(), std::nullopt, image, 2);
    EXPECT_EQ(image.width, level.picture().width_px);
    int bright = 0;
    for (const std::uint8_t pixel : image.pixels) bright += pixel > 30 ? 1 : 0;
    EXPECT_GT(bright, 1000) << name;
    pictures.insert(image.pixels);
  }
  EXPECT_EQ(pictures.size(), levels.size()) << "two levels gave the same picture";
}

}  // namespace
}  // namespace acus::simulation
