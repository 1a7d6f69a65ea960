#include "acus/scene/simulation/ultrasound_model.h"

#include <algorithm>
#include <filesystem>
#include <gtest/gtest.h>
#include <set>

#include "acus/base/config/json_file.h"
#include "acus/scene/simulation/beam_settings.h"
#include "support/layered_scene.h"
#include "support/temporary_folder.h"

namespace acus::simulation {
namespace {

/// A model as a scenario that says no more than its name has it.
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

TEST(UltrasoundModel, EveryModelReadsItsPresetAndShowsTheScene) {
  const Scene scene =
      testing_support::LayeredScene(testing_support::PlanOf(false, true, false, false), false);
  std::set<std::vector<std::uint8_t>> images;
  const std::vector<std::string> models = {"vidal_2008", "alamilla_2021", "columns_2010", "beams",
                                           "aperture"};
  for (const std::string& name : models) {
    const scenario::UltrasoundEffect effect = EffectOf(name);
    UltrasoundModel model({scene.ct.get(), scene.labels.get()}, *scene.probe,
                          ReadImageSettings(effect, *scene.probe, scene.labels.get()));
    image::GrayImage image;
    model.Render(OnTheSkin(), std::nullopt, image, 2);
    EXPECT_EQ(image.width, model.image().width_px);
    int bright = 0;
    for (const std::uint8_t pixel : image.pixels) bright += pixel > 30 ? 1 : 0;
    EXPECT_GT(bright, 1000) << name;
    images.insert(image.pixels);
  }
  EXPECT_EQ(images.size(), models.size()) << "two models gave the same image";
}

TEST(BeamSettings, FibresThatShowAtAllHaveADirection) {
  // A bar along x.
  volume::Geometry geometry;
  geometry.size = {40, 12, 12};
  volume::LabelMap labels(geometry, volume::Label{0});
  labels.names[1] = "tendon";
  for (int k = 4; k < 8; ++k) {
    for (int j = 4; j < 8; ++j) {
      for (int i = 0; i < 40; ++i) labels.At(i, j, k) = 1;
    }
  }
  const testing_support::TemporaryFolder folder;
  scenario::UltrasoundEffect effect = EffectOf("beams");
  nlohmann::json table = config::ReadJson(effect.acoustics);
  effect.acoustics = folder / "tissues.json";
  for (const double ratio : {1.0, 1.05}) {
    auto& tendon = table.at("tissues").at("tendon");
    tendon["fibre_ratio"] = ratio;
    tendon.erase("attenuation_along_fibres_db_per_cm_mhz");
    tendon.at("sources").erase("attenuation_along_fibres_db_per_cm_mhz");
    config::WriteJson(effect.acoustics, table);
    const auto fibres = ReadBeamSettings(effect, &labels).fibres_in_ct;
    ASSERT_EQ(fibres.contains("tendon"), ratio > 1.0);
    if (ratio > 1.0) {
      EXPECT_NEAR(std::abs(fibres.at("tendon").x()), 1.0, 1e-3);
    }
  }
}

// The gain of a probe for beam space, with its TGC, would leave nothing but white.
TEST(UltrasoundModel, ColumnsAreNotWhiteUnderAProbeForBeamSpace) {
  const Scene scene =
      testing_support::LayeredScene(testing_support::PlanOf(false, true, false, false), false);
  const acoustics::Probe probe = acoustics::ReadProbe(std::filesystem::path(ACUS_SOURCE_DIR) /
                                                      "configs/probes/curvilinear_c5_2.json");
  const ImageSettings settings =
      ReadImageSettings(EffectOf("columns_2010"), probe, scene.labels.get());
  image::GrayImage image;
  UltrasoundModel({scene.ct.get(), scene.labels.get()}, probe, settings)
      .Render(OnTheSkin(), std::nullopt, image);
  const auto share = [&](int least) {
    const auto count = std::count_if(image.pixels.begin(), image.pixels.end(),
                                     [&](std::uint8_t grey) { return grey >= least; });
    return static_cast<double>(count) / static_cast<double>(image.pixels.size());
  };
  EXPECT_LT(share(250), 0.05);
  EXPECT_GT(share(20), 0.05);
}

TEST(UltrasoundModel, GainActsInEveryModel) {
  const Scene scene =
      testing_support::LayeredScene(testing_support::PlanOf(false, true, false, false), false);
  for (const std::string name :
       {"vidal_2008", "alamilla_2021", "columns_2010", "beams", "aperture"}) {
    const scenario::UltrasoundEffect effect = EffectOf(name);
    const ImageSettings settings = ReadImageSettings(effect, *scene.probe, scene.labels.get());
    std::vector<image::GrayImage> images(2);
    for (int louder = 0; louder < 2; ++louder) {
      acoustics::Probe probe = *scene.probe;
      probe.gain_db += 6.0 * louder;
      UltrasoundModel({scene.ct.get(), scene.labels.get()}, probe, settings)
          .Render(OnTheSkin(), std::nullopt, images[static_cast<std::size_t>(louder)]);
    }
    // Well within what can be shown, each pixel is brighter by the gain's share of the range.
    double rise = 0.0;
    int count = 0;
    for (std::size_t n = 0; n < images[0].pixels.size(); ++n) {
      if (images[0].pixels[n] < 60 || images[0].pixels[n] > 180) continue;
      rise += images[1].pixels[n] - images[0].pixels[n];
      ++count;
    }
    ASSERT_GT(count, 100) << name;
    EXPECT_NEAR(rise / count, 255.0 * 6.0 / scene.probe->dynamic_range_db, 1.0) << name;
  }
}

}  // namespace
}  // namespace acus::simulation
