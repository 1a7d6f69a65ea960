#include "acus/patient/meshing/condense_mesh.h"

#include <gmock/gmock.h>

#include "acus/base/config/json_file.h"
#include "acus/base/core/atomic_file.h"
#include "acus/data/mesh/surface_io.h"
#include "acus/patient/meshing/mesh_folder.h"
#include "acus/physics/mechanics/condensation/compliance_file.h"
#include "support/box_mesh.h"
#include "support/temporary_folder.h"

namespace acus::meshing {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;
using testing_support::TemporaryFolder;

/// A box of 40 mm of soft tissue that stands on a fixed floor.
mesh::TetraMesh Box() {
  mesh::TetraMesh mesh = testing_support::BoxMesh({8, 8, 8}, {0, 0, 0}, {40, 40, 40}, 0.15);
  testing_support::Fix(mesh, [](const Eigen::Vector3d& x) { return x.z() == 0.0; });
  return mesh;
}

json Document(const json& condensation) {
  return config::CheckedConfig({{"format", "acus-mesh/1"},
                                {"corridor", {{"from_mm", {20, 20, 45}}, {"to_mm", {20, 20, 15}}}},
                                {"condensation", condensation}},
                               "acus-mesh", "test");
}

MeshConfig Config(const json& condensation, const std::string& probe_at = "") {
  const json document = Document(condensation);
  MeshConfig config = MeshConfigFromJson(document);
  RequestCondensation(config, document, ".", probe_at);
  return config;
}

class CondenseMesh : public ::testing::Test {
 protected:
  CondenseMesh() { mesh::WriteTetraMesh(mesh_path_, box_); }
  json Run(const MeshConfig& config) {
    RunContext context;
    context.overwrite = true;
    CondenseMeshToFolder(mesh_path_, config, out_, context);
    return config::ReadJson(out_ / "condensation.json");
  }

  TemporaryFolder folder_;
  std::filesystem::path mesh_path_ = folder_ / "input.vtu";
  std::filesystem::path out_ = folder_ / "out";
  mesh::TetraMesh box_ = Box();
};

TEST_F(CondenseMesh, WritesAFileThatOpensWithTheMeshBesideIt) {
  const MeshConfig config = Config({{"corridor_radius_mm", 4}, {"image_radius_mm", 12}});
  const json report = Run(config);
  const mesh::TetraMesh mesh = mesh::ReadTetraMesh(out_ / "mesh.vtu");
  const auto tissue =
      mechanics::OpenCompliance(out_ / "compliance.acc", mesh, config.condense->elasticity,
                                config.condense->element, mechanics::ComplianceCheck::kEverything);
  EXPECT_EQ(report.at("nodes"), 729);
  EXPECT_EQ(report.at("reachable_nodes"), tissue.compliance.num_nodes());
  EXPECT_EQ(report.at("visible_nodes"), tissue.image.num_nodes());
  EXPECT_GT(tissue.image.num_nodes(), tissue.compliance.num_nodes());
  EXPECT_EQ(tissue.compliance.storage(), mechanics::Storage::kDouble);
  EXPECT_GT(report.at("peak_memory_mib"), 1.0);
  // The mesh that was read first has the same content: file names do not count.
  EXPECT_NO_THROW(mechanics::OpenCompliance(out_ / "compliance.acc", box_,
                                            config.condense->elasticity, config.condense->element));
}

TEST_F(CondenseMesh, ReachesTheSkinUnderTheProbe) {
  const json settings = {{"corridor_radius_mm", 0}, {"image_radius_mm", 0}, {"storage", "float"}};
  const json without = Run(Config(settings));
  json with_probe = settings;
  with_probe["probe"] = {{"place_mm", {5, 5, 40}}, {"radius_mm", 9}};
  const json with = Run(Config(with_probe));
  EXPECT_GT(with.at("reachable_nodes"), without.at("reachable_nodes"));
  EXPECT_EQ(with.at("visible_nodes"), 0);
  // The place can be given apart; the radius is then the schema's.
  const json moved = Run(Config(settings, "5,5,40"));
  EXPECT_GT(moved.at("reachable_nodes"), with.at("reachable_nodes"));
}

TEST_F(CondenseMesh, NeedsACorridor) {
  const json document = config::CheckedConfig({{"format", "acus-mesh/1"}}, "acus-mesh", "test");
  MeshConfig config = MeshConfigFromJson(document);
  EXPECT_THAT([&] { RequestCondensation(config, document, ".", ""); },
              ThrowsMessage<InputError>(
                  HasSubstr("give --corridor, or --corridor-from and --corridor-to")));
}

TEST_F(CondenseMesh, NamesWhatIsNotKnown) {
  EXPECT_THAT(
      [] {
        Config({{"element", "cubic"}});
      },
      ThrowsMessage<InputError>(HasSubstr("no element \"cubic\"; known: linear")));
  EXPECT_THAT(
      [] {
        Config({{"elasticity", "elasticity/none.json"}});
      },
      ThrowsMessage<InputError>(HasSubstr("elasticity/none.json")));
  EXPECT_THAT([] { Config(json::object(), "1,2"); },
              ThrowsMessage<InputError>(HasSubstr("--probe-at: '1,2' is not a point")));
}

TEST_F(CondenseMesh, WithoutFixedNodesSaysWhatToDo) {
  std::ranges::fill(box_.fixed_nodes, 0);
  mesh::WriteTetraMesh(mesh_path_, box_);
  EXPECT_THAT([&] { Run(Config(json::object())); },
              ThrowsMessage<InputError>(HasSubstr("no node of the mesh is fixed")));
  EXPECT_FALSE(std::filesystem::exists(out_));
}

TEST_F(CondenseMesh, WithATissueThatTheTableLacksSaysWhatToDo) {
  box_.tissue[1000] = 5;  // Bone, but not held.
  mesh::WriteTetraMesh(mesh_path_, box_);
  EXPECT_THAT(
      [&] { Run(Config(json::object())); },
      ThrowsMessage<InputError>(::testing::AllOf(HasSubstr("'bone'"), HasSubstr("add a row"))));
}

TEST_F(CondenseMesh, WithoutTissueIdsSaysWhatToDo) {
  std::string text = ReadTextFile(mesh_path_);
  text.replace(text.find("Name=\"tissue\""), 13, "Name=\"colour\"");
  WriteTextFile(mesh_path_, text);
  EXPECT_THAT([&] { Run(Config(json::object())); },
              ThrowsMessage<InputError>(HasSubstr("has no tissue ids")));
  EXPECT_FALSE(std::filesystem::exists(out_));
}

}  // namespace
}  // namespace acus::meshing
