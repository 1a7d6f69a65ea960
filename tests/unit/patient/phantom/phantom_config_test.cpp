#include "acus/patient/phantom/anatomy/phantom_config.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "acus/base/config/json_file.h"
#include "acus/base/core/atomic_file.h"
#include "support/fuzz.h"
#include "support/temporary_folder.h"
#include "unit/patient/phantom/presets.h"

namespace acus::phantom {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

PhantomConfig Read(const nlohmann::json& changes) {
  const testing_support::TemporaryFolder folder;
  nlohmann::json document = {{"format", "acus-phantom/1"}};
  document.merge_patch(changes);
  config::WriteJson(folder / "c.json", document);
  return ReadPhantomConfig(folder / "c.json");
}

TEST(PhantomConfig, PresetsAreRead) {
  for (const char* name : {"lumbar", "liver", "scene"})
    EXPECT_FALSE(Preset(name).session.needle.empty());
  EXPECT_EQ(Preset("lumbar").force_curves.size(), 2U);
  EXPECT_EQ(Preset("liver").scanner.hu[static_cast<int>(Material::kLiver)], 105.0);
}

TEST(PhantomConfig, ConvertsUnitsOnce) {
  const PhantomConfig config =
      Read({{"insertion", {{"cone_deg", 45}}},
            {"session", {{"turn_deg_per_s", 90}}},
            {"markers", {{"reference_from_ct", {{"rotation_deg", {0, 0, 90}}}}}}});
  EXPECT_NEAR(config.insertion.cone_rad, std::numbers::pi / 4, 1e-12);
  EXPECT_NEAR(config.session.turn_rad_per_s, std::numbers::pi / 2, 1e-12);
  const Eigen::Vector3d turned = config.markers.reference_from_ct * Eigen::Vector3d::UnitX();
  EXPECT_NEAR((turned - Eigen::Vector3d::UnitY()).norm(), 0.0, 1e-12);
}

TEST(PhantomConfig, RefusesBothEndsOfEveryRangeThatMatters) {
  for (const auto& [pointer, low, high] : std::vector<std::tuple<const char*, double, double>>{
           {"/body/scale", 0.69, 1.31},
           {"/body/variation_percent", -0.1, 8.1},
           {"/body/interlaminar_gap_mm", 3.9, 18.1},
           {"/scanner/psf_sigma_mm", -0.1, 5.1},
           {"/scanner/noise_sd_hu", -1, 201},
           {"/scanner/hu/liver", -1025, 3072},
           {"/markers/count", 2, 41},
           {"/markers/fle_mm", -0.1, 10.1},
           {"/insertion/cone_deg", -1, 86},
           {"/session/probe/gap_mm", -0.1, 1.1},
           {"/session/tremor/needle_mm", -0.1, 3.1}}) {
    for (const double value : {low, high}) {
      nlohmann::json changes;
      changes[nlohmann::json::json_pointer(pointer)] = value;
      if (std::string(pointer) == "/markers/count") {
        changes[nlohmann::json::json_pointer(pointer)] = static_cast<int>(value);
      }
      EXPECT_THAT([&] { Read(changes); }, ThrowsMessage<InputError>(HasSubstr(pointer))) << value;
    }
  }
}

TEST(PhantomConfig, RefusesWhatNoSchemaCanSee) {
  EXPECT_THAT(
      [] {
        Read({{"grid", {{"size", {700, 700, 700}}}}});
      },
      ThrowsMessage<InputError>(HasSubstr("/grid/size")));
  EXPECT_THAT(
      [] {
        Read({{"insertion", {{"approach", {0, 0, 0}}}}});
      },
      ThrowsMessage<InputError>(HasSubstr("/insertion/approach")));
  EXPECT_THAT(
      [] {
        Read({{"insertion", {{"avoid", {"livver"}}}}});
      },
      ThrowsMessage<InputError>(HasSubstr("did you mean 'liver'")));
  EXPECT_THAT(
      [] {
        Read({{"insertion", {{"min_length_mm", 100}, {"max_length_mm", 50}}}});
      },
      ThrowsMessage<InputError>(HasSubstr("min_length_mm")));
  EXPECT_THAT(
      [] {
        Read({{"session", {{"tremor", {{"low_hz", 12}, {"high_hz", 8}}}}}});
      },
      ThrowsMessage<InputError>(HasSubstr("low_hz")));
  EXPECT_THAT(
      [] {
        Read({{"force_curves", nlohmann::json::array({nlohmann::json{{"name", "a"}},
                                                      nlohmann::json{{"name", "a"}}})}});
      },
      ThrowsMessage<InputError>(HasSubstr("two are named 'a'")));
}

TEST(PhantomConfig, SurvivesDamagedFiles) {
  const testing_support::TemporaryFolder folder;
  const std::string valid =
      ReadTextFile(std::filesystem::path(ACUS_SOURCE_DIR) / "configs/phantoms/lumbar.json");
  const int refused = testing_support::ReadDamagedCopies(
      valid, folder / "c.json", 300, [&] { ReadPhantomConfig(folder / "c.json"); });
  EXPECT_GT(refused, 150);
}

}  // namespace
}  // namespace acus::phantom
