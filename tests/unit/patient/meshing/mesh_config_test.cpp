#include "acus/patient/meshing/mesh_config.h"

#include <filesystem>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "acus/base/config/json_file.h"
#include "acus/base/core/error.h"

namespace acus::meshing {
namespace {

using nlohmann::json;
using testing::HasSubstr;
using testing::ThrowsMessage;

MeshConfig Read(json document) {
  document["format"] = "acus-mesh/1";
  return MeshConfigFromJson(config::CheckedConfig(document, "acus-mesh", "test"));
}

TEST(MeshConfig, HasTheSchemasDefaults) {
  const MeshConfig config = Read(json::object());
  EXPECT_EQ(config.labels.sizes.interface_mm, 6.0);
  EXPECT_EQ(config.labels.min_dihedral_deg, 8.0);
  EXPECT_EQ(config.labels.volume_tolerance, 0.03);
  EXPECT_FALSE(config.labels.sizes.corridor);
  EXPECT_EQ(config.surface.min_dihedral_deg, 8.0);
}

TEST(MeshConfig, RefusesValuesBeyondBothEnds) {
  for (const char* text :
       {R"({"smoothing_mm": -0.1})", R"({"smoothing_mm": 20.1})", R"({"min_dihedral_deg": -1})",
        R"({"min_dihedral_deg": 21})", R"({"element_size_mm": {"skin": 0.1}})",
        R"({"element_size_mm": {"skin": 501}})", R"({"corridor": {"from_mm": [0, 0, 0]}})",
        R"({"corridor": {"from_mm": [0, 0], "to_mm": [0, 0, 1]}})", R"({"volume_tolerance": 0})",
        R"({"surface": {"time_limit_s": 0}})"}) {
    EXPECT_THROW(Read(json::parse(text)), InputError) << text;
  }
}

TEST(MeshConfig, TakesTheCorridorFromTheCommandLine) {
  MeshConfig config = Read(json::object());
  SetCorridor(config, "-10,20.5,3e1", "0,0,0");
  ASSERT_TRUE(config.labels.sizes.corridor);
  EXPECT_EQ(config.labels.sizes.corridor->from_mm, Eigen::Vector3d(-10, 20.5, 30));
  EXPECT_EQ(config.labels.sizes.corridor->element_size_mm, 4.0);
  for (const char* text :
       {"", "1,2", "1,2,3,4", "1;2;3", "1,2,x", "1,2,nan", "1,2,inf", " 1,2,3"}) {
    EXPECT_THAT([&] { SetCorridor(config, text, "0,0,0"); },
                ThrowsMessage<InputError>(HasSubstr("--corridor-from")))
        << text;
  }
}

TEST(MeshPresets, FitTheSchema) {
  int count = 0;
  for (const auto& file : std::filesystem::directory_iterator(
           std::filesystem::path(ACUS_SOURCE_DIR) / "configs" / "meshes")) {
    EXPECT_NO_THROW(MeshConfigFromJson(config::ReadConfig(file.path(), "acus-mesh")))
        << file.path();
    ++count;
  }
  EXPECT_GE(count, 3);
}

}  // namespace
}  // namespace acus::meshing
