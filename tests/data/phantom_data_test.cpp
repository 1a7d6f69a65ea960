// Scenes on a real patient's label map: 3D-IRCADb-01, patient 1.
#include <gtest/gtest.h>
#include <map>

#include "acus/base/config/json_file.h"
#include "acus/data/session/session_io.h"
#include "acus/data/volume/labels.h"
#include "acus/data/volume/volume_io.h"
#include "acus/patient/phantom/patient_folder.h"
#include "support/shared_data.h"
#include "support/temporary_folder.h"

namespace acus::phantom {
namespace {

using Eigen::Vector3d;

volume::LabelMap Ircadb(const std::filesystem::path& path) {
  const std::map<int, const char*> names = {
      {1, "soft_tissue"}, {65, "bone"},    {129, "kidney"}, {193, "kidney"}, {385, "spleen"},
      {449, "liver"},     {451, "lesion"}, {513, "vessel"}, {17, "vessel"},  {33, "vessel"}};
  const auto values = volume::ReadIntegerVolume(path);
  volume::LabelMap labels(values.geometry);
  for (std::size_t n = 0; n < values.voxels.size(); ++n) {
    if (values.voxels[n] == 0) continue;
    const auto name = names.find(values.voxels[n]);
    labels.voxels[n] = volume::LabelOf(name == names.end() ? "soft_tissue" : name->second);
  }
  return labels;
}

TEST(SceneOnIrcadb, GoesIntoTheLiverBetweenTheRibs) {
  const auto path = testing_support::SharedData("ct/ircadb01_labels.vti");
  if (!path) GTEST_SKIP() << "test data ct/ircadb01_labels.vti is not here";
  const volume::LabelMap labels = Ircadb(*path);
  const LabelMapField field(labels);
  const PhantomConfig config =
      ReadPhantomConfig(std::filesystem::path(ACUS_SOURCE_DIR) / "configs/phantoms/scene.json");
  const testing_support::TemporaryFolder folder;
  WriteScene(folder / "s", labels, config, {});
  const auto insertion = config::ReadJson(folder / "s/truth.json").at("insertion");
  const auto vector = [&](const char* key) {
    const auto& v = insertion.at(key);
    return Vector3d(v.at(0), v.at(1), v.at(2));
  };
  const volume::Label target = field.LabelAt(vector("target_ct_mm"));
  EXPECT_TRUE(target == volume::LabelOf("liver") || target == volume::LabelOf("lesion"));
  for (double depth = 0.0; depth < insertion.at("length_mm"); depth += 0.2) {
    EXPECT_NE(field.LabelAt(vector("entry_ct_mm") + depth * vector("direction")),
              volume::LabelOf("bone"));
  }
  const auto session = session::ReadSession(folder / "s/sessions/insertion", {});
  const Eigen::Isometry3d ct_from_reference = config.markers.reference_from_ct.inverse();
  for (std::size_t i = 2000; i < session.probe.size(); i += 100) {
    const Vector3d face = ct_from_reference * session.probe[i].reference_from_tool.translation();
    EXPECT_NEAR(field.SkinDistanceMm(face), 0.5, 0.5) << "at " << i << " ms";
  }
}

/// What holds for every window: a free path to the structure, and the probe on skin that is there.
void ExpectWindowOn(const volume::LabelMap& labels, const char* window, const char* structure) {
  SCOPED_TRACE(window);
  const LabelMapField field(labels);
  const PhantomConfig config = ReadPhantomConfig(std::filesystem::path(ACUS_SOURCE_DIR) /
                                                 "configs/phantoms/scene_target.json");
  const testing_support::TemporaryFolder folder;
  WriteScene(folder / "s", labels, config, {}, {.target = structure, .window = window});
  const auto insertion = config::ReadJson(folder / "s/truth.json").at("insertion");
  EXPECT_TRUE(insertion.at("window").get<std::string>().starts_with(window));
  EXPECT_EQ(insertion.at("passes_through").back().at("tissue"), structure);
  for (const auto& part : insertion.at("passes_through")) {
    for (const char* avoided : {"bone", "lung", "gas"}) EXPECT_NE(part.at("tissue"), avoided);
  }
  const auto session = session::ReadSession(folder / "s/sessions/insertion", {});
  const Eigen::Isometry3d ct_from_reference = config.markers.reference_from_ct.inverse();
  for (std::size_t i = 2000; i < session.probe.size(); i += 200) {
    const Vector3d face = ct_from_reference * session.probe[i].reference_from_tool.translation();
    ASSERT_NEAR(field.SkinDistanceMm(face), 0.5, 0.5) << "at " << i << " ms";
    ASSERT_TRUE(field.bounds_ct_mm().contains(face)) << "on the border of the volume";
    ASSERT_FALSE(field.IsCut(face)) << "on the cut of the field of view";
  }
}

TEST(WindowsOnIrcadb, LeadToTheLiver) {
  const auto path = testing_support::SharedData("ct/ircadb01_labels.vti");
  if (!path) GTEST_SKIP() << "test data ct/ircadb01_labels.vti is not here";
  const volume::LabelMap labels = Ircadb(*path);
  ExpectWindowOn(labels, "intercostal", "liver");
  ExpectWindowOn(labels, "subcostal", "liver");
}

}  // namespace
}  // namespace acus::phantom
