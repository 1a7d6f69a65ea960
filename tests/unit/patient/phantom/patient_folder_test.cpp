#include "acus/patient/phantom/patient_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "acus/base/config/json_file.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/csv.h"
#include "acus/data/session/session_io.h"
#include "acus/data/volume/volume_io.h"
#include "support/temporary_folder.h"
#include "unit/patient/phantom/presets.h"

namespace acus::phantom {
namespace {

namespace fs = std::filesystem;

/// A preset with coarse voxels and few curves: small files, same anatomy and session.
PhantomConfig Coarse(const std::string& preset) {
  PhantomConfig config = Preset(preset);
  config.grid.spacing_mm *= 4.0;
  config.grid.size = (config.grid.size.cast<double>() / 4.0).ceil().cast<int>();
  for (ForceCurveSettings& curve : config.force_curves) {
    curve.count = 1;
    curve.drive.rate_hz = 100.0;
  }
  return config;
}

RunContext Context(std::uint64_t seed, int threads = 1) {
  RunContext context;
  context.seed = seed;
  context.num_threads = threads;
  return context;
}

TEST(WritePatient, WritesEverythingThatOtherProgramsRead) {
  const testing_support::TemporaryFolder folder;
  WritePatient(folder / "p", Coarse("lumbar"), Context(1));
  const auto ct = volume::ReadCt(folder / "p/ct.nrrd", "", {});
  const auto labels = volume::ReadLabelMap(folder / "p/labels.seg.nrrd");
  EXPECT_TRUE(ct.geometry.Matches(labels.geometry));
  EXPECT_EQ(labels.names.at(volume::LabelOf("spinal_canal")), "spinal_canal");
  const auto truth = config::ReadJson(folder / "p/truth.json");
  const CsvTable target(folder / "p/target_ct.csv");
  for (int axis = 0; axis < 3; ++axis) {
    const char* column[] = {"x_mm", "y_mm", "z_mm"};
    EXPECT_EQ(target.Numbers(column[axis])[0], truth.at("insertion").at("target_ct_mm").at(axis));
  }
  EXPECT_EQ(CsvTable(folder / "p/markers_mannequin.csv").num_rows(), 8U);
  const auto session = session::ReadSession(folder / "p/sessions/lumbar_puncture", {});
  EXPECT_GT(session.needle.size(), 25'000U);
  const auto curve = forces::ReadForceCurve(folder / "p/force_curves/ligamentum_flavum_1.csv");
  EXPECT_GT(curve.size(), 1000U);
  EXPECT_TRUE(fs::exists(folder / "p/provenance.json"));
}

TEST(WritePatient, StatesTheVolumesOfItsLabels) {
  const testing_support::TemporaryFolder folder;
  WritePatient(folder / "p", Coarse("liver"), Context(1));
  const auto labels = volume::ReadLabelMap(folder / "p/labels.seg.nrrd");
  const auto truth = config::ReadJson(folder / "p/truth.json");
  const auto liver = std::ranges::count(labels.voxels, volume::LabelOf("liver"));
  EXPECT_NEAR(truth.at("volumes_ml").at("liver").get<double>(),
              1e-3 * static_cast<double>(liver) * labels.geometry.voxel_volume_mm3(), 1e-6);
  EXPECT_GT(truth.at("volumes_ml").at("liver").get<double>(), 900.0);   // A man's liver:
  EXPECT_LT(truth.at("volumes_ml").at("liver").get<double>(), 2000.0);  // about 1.5 l.
}

TEST(WritePatient, GivesTheSameBitsForOneAndTwoThreadsAndOthersForAnotherSeed) {
  const testing_support::TemporaryFolder folder;
  WritePatient(folder / "a", Coarse("liver"), Context(5, 1));
  WritePatient(folder / "b", Coarse("liver"), Context(5, 2));
  WritePatient(folder / "c", Coarse("liver"), Context(6, 2));
  for (const char* file : {"ct.nrrd", "labels.seg.nrrd", "truth.json", "markers_mannequin.csv",
                           "target_ct.csv", "corridor_ct.csv", "sessions/liver_biopsy/needle.csv",
                           "sessions/liver_biopsy/probe.csv", "force_curves/liver_capsule_1.csv"}) {
    EXPECT_EQ(ReadTextFile(folder / "a" / file), ReadTextFile(folder / "b" / file)) << file;
    EXPECT_NE(ReadTextFile(folder / "a" / file), ReadTextFile(folder / "c" / file)) << file;
  }
}

TEST(WritePatient, LeavesNothingBehindWhenThereIsNoPath) {
  const testing_support::TemporaryFolder folder;
  PhantomConfig config = Coarse("lumbar");
  config.insertion.approach = -Eigen::Vector3d::UnitY();  // Through the belly.
  EXPECT_THROW(WritePatient(folder / "p", config, Context(1)), NoAnswerError);
  config = Coarse("lumbar");
  config.insertion.target = "canal_C1C2";
  EXPECT_THROW(WritePatient(folder / "p", config, Context(1)), InputError);
  EXPECT_TRUE(fs::is_empty(folder / "."));
}

TEST(WriteScene, PutsAnInsertionOnAnyLabelMap) {
  const testing_support::TemporaryFolder folder;
  const volume::LabelMap labels = SyntheticBody();
  WriteScene(folder / "s", labels, Preset("scene"), Context(3));
  const LabelMapField field(labels);
  const auto truth = config::ReadJson(folder / "s/truth.json");
  const auto session = session::ReadSession(folder / "s/sessions/insertion", {});
  const Eigen::Isometry3d ct_from_reference = Preset("scene").markers.reference_from_ct.inverse();
  for (std::size_t i = 2000; i < session.probe.size(); i += 50) {
    const Eigen::Vector3d face =
        ct_from_reference * session.probe[i].reference_from_tool.translation();
    ASSERT_NEAR(field.SkinDistanceMm(face), 0.5, 0.5) << "at " << i << " ms";
  }
  std::vector<std::string> kinds;
  for (const auto& event : truth.at("sessions").at("insertion").at("events"))
    kinds.push_back(event.at("kind"));
  EXPECT_EQ(kinds.front(), "contact");
  EXPECT_EQ(kinds.back(), "withdrawn");
  EXPECT_TRUE(fs::exists(folder / "s/provenance.json"));
}

TEST(WriteScene, EntersAtTheBorderIfTheVolumeShowsNoSkin) {
  const testing_support::TemporaryFolder folder;
  volume::Geometry g;
  g.size = {70, 70, 60};
  g.spacing_mm = Eigen::Array3d::Constant(2.0);
  const volume::LabelMap inside(g, volume::LabelOf("soft_tissue"));
  WriteScene(folder / "s", inside, Preset("scene"), Context(3));
  const auto entry = config::ReadJson(folder / "s/truth.json").at("insertion").at("entry_ct_mm");
  double to_border_mm = 1e9;
  for (int axis = 0; axis < 3; ++axis) {
    const double at = entry.at(static_cast<std::size_t>(axis));
    to_border_mm = std::min({to_border_mm, std::abs(at), std::abs(at - 2.0 * (g.size[axis] - 1))});
  }
  EXPECT_LT(to_border_mm, 2.0);
  // Too small for any insertion: nothing is left behind.
  g.size = {8, 8, 8};
  const volume::LabelMap crumb(g, volume::LabelOf("soft_tissue"));
  EXPECT_THROW(WriteScene(folder / "t", crumb, Preset("scene"), Context(3)), NoAnswerError);
  EXPECT_FALSE(fs::exists(folder / "t"));
}

}  // namespace
}  // namespace acus::phantom
