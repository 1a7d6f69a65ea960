#include <fstream>
#include <gmock/gmock.h>
#include <sstream>
#include <unistd.h>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/csv.h"
#include "acus/base/core/error.h"
#include "acus/data/mesh/surface_io.h"
#include "acus/data/session/session_io.h"
#include "acus/data/volume/volume_io.h"
#include "acus/physics/mechanics/condensation/compliance_file.h"
#include "acus/physics/mechanics/condensation/reachable.h"
#include "acus/run/replay/replay.h"
#include "support/box_mesh.h"
#include "support/layered_scene.h"

namespace acus::replay {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr const char* kLevels[] = {"displacement_functions", "springs", "fe_2d", "fe_3d"};

/// The layers of the layered scene as tetrahedra, held at the bottom.
mesh::TetraMesh LayeredMesh() {
  mesh::TetraMesh mesh =
      testing_support::BoxMesh({10, 10, 18}, {-29.9, -29.9, 0}, {29.9, 29.9, 90});
  for (Eigen::Index t = 0; t < mesh.tetrahedra.cols(); ++t) {
    double z_mm = 0.0;
    for (int corner = 0; corner < 4; ++corner) {
      z_mm += 0.25 * mesh.nodes_mm(2, mesh.tetrahedra(corner, t));
    }
    for (const auto& layer : testing_support::kLayers) {
      if (z_mm >= layer.from_z_mm) {
        mesh.tissue[static_cast<std::size_t>(t)] = volume::LabelOf(layer.tissue);
      }
    }
  }
  for (Eigen::Index n = 0; n < mesh.nodes_mm.cols(); ++n) {
    mesh.fixed_nodes[static_cast<std::size_t>(n)] = mesh.nodes_mm(2, n) > 89.0;
  }
  return mesh;
}

/// A needle that goes in along z at (0, -10) and out again, under a probe beside it.
session::Session InAndOut() {
  session::Session session;
  session.name = "in and out";
  for (int ms = 0; ms < 4000; ++ms) {
    const double z_mm = ms < 2000 ? -5.0 + 0.025 * ms : 45.0 - 0.025 * (ms - 2000);
    session::PoseSample needle{.time_ns = ms * std::int64_t{1'000'000}};
    needle.reference_from_tool = Eigen::Isometry3d(Eigen::Translation3d(0.0, -10.0, z_mm));
    session.needle.push_back(needle);
    if (ms % 20 != 0) continue;
    Eigen::Isometry3d probe = Eigen::Isometry3d::Identity();
    probe.linear() << 1, 0, 0, 0, 0, -1, 0, 1, 0;
    probe.translation() << 5.0, -10.0, -0.5;
    session.probe.push_back({needle.time_ns, probe, true});
  }
  return session;
}

std::string BytesOf(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

/// A layered patient with a condensed mesh, on disk once for all tests.
class TissueReplay : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    // One for each process: CTest runs every test in a process of its own, side by side.
    folder_ = fs::path(testing::TempDir()) / Message("tissue_replay_", getpid());
    const fs::path& folder = folder_;
    fs::create_directories(folder);
    setenv("ACUS_CONFIGS", (fs::path(ACUS_SOURCE_DIR) / "configs").c_str(), 1);
    const auto scene =
        testing_support::LayeredScene(testing_support::PlanOf(true, true, true, true), true);
    volume::WriteCt(folder / "ct.nrrd", *scene.ct);
    volume::WriteLabelMap(folder / "labels.seg.nrrd", *scene.labels);
    session::WriteSession(folder / "session", InAndOut(), RunContext());
    WriteTextFile(folder / "corridor.csv", "name,x_mm,y_mm,z_mm\nentry,0,-10,0\ntarget,0,-10,50\n");
    WriteTextFile(folder / "scene.json", R"({"format": "acus-scenario/1",
      "patient": {"ct": "ct.nrrd", "labels": "labels.seg.nrrd", "corridor": "corridor.csv",
        "ct_from_reference": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]},
      "probe": "probes/linear_l14.json",
      "effects": {"needle_force": {}, "ultrasound": {}, "ct_slice": {}}, "image_rate_hz": 5})");
    Condense(folder / "mesh");
  }
  static void TearDownTestSuite() { fs::remove_all(folder_); }

  static void Condense(const fs::path& folder) {
    fs::create_directories(folder);
    const mesh::TetraMesh mesh = LayeredMesh();
    mesh::WriteTetraMesh(folder / "mesh.vtu", mesh);
    const mesh::TetraMesh read = mesh::ReadTetraMesh(folder / "mesh.vtu");
    const auto elasticity = mechanics::ReadElasticityTable(fs::path(ACUS_SOURCE_DIR) /
                                                           "configs/elasticity/default.json");
    constexpr auto kElement = mechanics::ElementKind::kAveragedDilatation;
    const mechanics::FreeNodes free = mechanics::FindFreeNodes(read);
    const mechanics::Capsule corridor{{0, -10, 0}, {0, -10, 50}, 4.0};
    mechanics::Condensation condensation(read, free, elasticity, kElement,
                                         mechanics::CorridorNodes(read, free, corridor),
                                         mechanics::kDefaultMemoryMib, RunContext());
    const auto visible =
        mechanics::NodesInside(read, free, {corridor.from_mm, corridor.to_mm, 25.0});
    mechanics::WriteCompliance(folder / "compliance.acc", condensation,
                               mechanics::KeyOf(read, elasticity, kElement), read.nodes_mm.cols(),
                               visible, mechanics::Storage::kDouble, RunContext());
  }

  /// @param model  Empty: tissue does not deform.
  static ReplayResult Run(const std::string& run, const std::string& model, int num_threads,
                          std::vector<scenario::Override> overrides = {}) {
    if (!model.empty()) {
      overrides.push_back({"/effects/tissue/model", model});
      if (model != "displacement_functions") {
        overrides.push_back({"/effects/needle_force/model", "tissue"});
      }
      overrides.push_back({"/patient/mesh", (Folder() / "mesh").string()});
    }
    RunContext context;
    context.num_threads = num_threads;
    ReplayOptions options;
    options.run_folder = Folder() / run;
    options.film = false;
    options.png = PngChoice::kNone;
    return ReplaySession(scenario::ReadScenario(Folder() / "scene.json", overrides),
                         Folder() / "session", options, context);
  }

  static const fs::path& Folder() { return folder_; }

 private:
  static fs::path folder_;
};
fs::path TissueReplay::folder_;

TEST_F(TissueReplay, EveryModelActsOnForceAndImageWithTheSameBytesOnMoreThreads) {
  Run("rigid", "", 2);
  const std::string rigid = BytesOf(Folder() / "rigid/images.igs.mha");
  for (const std::string model : kLevels) {
    SCOPED_TRACE(model);
    Run(model + "_1", model, 1);
    Run(model + "_2", model, 2);
    for (const char* file : {"forces.csv", "images.igs.mha", "metrics.json"}) {
      EXPECT_EQ(BytesOf(Folder() / (model + "_1") / file),
                BytesOf(Folder() / (model + "_2") / file))
          << file;
    }
    EXPECT_NE(BytesOf(Folder() / (model + "_1/images.igs.mha")), rigid);
    const CsvTable forces(Folder() / (model + "_1/forces.csv"));
    const auto axial_n = forces.Numbers("force_axial_n");
    EXPECT_GT(*std::ranges::max_element(axial_n), 0.5);
    EXPECT_LT(*std::ranges::max_element(axial_n), 20.0);
    EXPECT_LT(*std::ranges::min_element(axial_n), -0.01);  // Friction, on the way out.
    EXPECT_EQ(axial_n.front(), 0.0);
    EXPECT_EQ(axial_n.back(), 0.0);
    EXPECT_THAT(forces.Texts("tissue"), testing::Contains("muscle"));
    EXPECT_THAT(forces.Texts("event"), testing::Contains("puncture"));
  }
}

TEST_F(TissueReplay, LayeredForcesStayTheSameWhenOnlyTheImagesShowTissue) {
  Run("felt_alone", "", 1);
  Run("felt_beside", "", 1,
      {{"/effects/tissue/model", "fe_3d"}, {"/patient/mesh", (Folder() / "mesh").string()}});
  EXPECT_EQ(BytesOf(Folder() / "felt_alone/forces.csv"),
            BytesOf(Folder() / "felt_beside/forces.csv"));
  EXPECT_NE(BytesOf(Folder() / "felt_alone/images.igs.mha"),
            BytesOf(Folder() / "felt_beside/images.igs.mha"));
}

TEST_F(TissueReplay, SceneWithoutTissueDoesNotOpenItsFiles) {
  WriteTextFile(Folder() / "garbage.vtu", "not a mesh");
  EXPECT_NO_THROW(Run("unread", "", 1, {{"/patient/mesh", (Folder() / "garbage.vtu").string()}}));
}

TEST_F(TissueReplay, MissingAndStaleComplianceNameTheRemedy) {
  const std::vector<scenario::Override> fem = {{"/effects/tissue/model", "fe_3d"}};
  const auto with_mesh = [&](const fs::path& mesh) {
    auto overrides = fem;
    overrides.push_back({"/patient/mesh", mesh.string()});
    return overrides;
  };
  fs::create_directories(Folder() / "bare");
  fs::copy_file(Folder() / "mesh/mesh.vtu", Folder() / "bare/mesh.vtu",
                fs::copy_options::overwrite_existing);
  EXPECT_THAT(
      [&] { Run("x", "", 1, with_mesh(Folder() / "bare")); },
      ThrowsMessage<InputError>(AllOf(HasSubstr("compliance.acc"), HasSubstr("--condense"))));
  EXPECT_FALSE(fs::exists(Folder() / "x"));

  auto softer = with_mesh(Folder() / "mesh");
  std::string table = BytesOf(fs::path(ACUS_SOURCE_DIR) / "configs/elasticity/default.json");
  const std::string muscle = "\"youngs_modulus_kpa\": 12,";
  ASSERT_NE(table.find(muscle), std::string::npos);
  table.replace(table.find(muscle), muscle.size(), "\"youngs_modulus_kpa\": 11,");
  WriteTextFile(Folder() / "softer.json", table);
  softer.push_back({"/effects/tissue/elasticity", (Folder() / "softer.json").string()});
  EXPECT_THAT([&] { Run("x", "", 1, softer); },
              ThrowsMessage<InputError>(AllOf(HasSubstr("elastic"), HasSubstr("--condense"))));

  auto other_element = with_mesh(Folder() / "mesh");
  other_element.push_back({"/effects/tissue/fe_3d/element", "linear"});
  EXPECT_THAT([&] { Run("x", "", 1, other_element); },
              ThrowsMessage<InputError>(HasSubstr("element")));
}

}  // namespace
}  // namespace acus::replay
