// Label maps as bad as they come: none fails, and every mesh can be computed with.
#include <cstdio>
#include <cstdlib>
#include <gtest/gtest.h>

#include "acus/base/core/cpu_time.h"
#include "acus/data/mesh/quality.h"
#include "acus/patient/meshing/label_mesher.h"
#include "support/damaged_label_maps.h"

namespace acus::meshing {
namespace {

constexpr double kLeastAngleDeg = 12.0;
constexpr double kMostCpuS = 60.0;

int FromEnvironment(const char* name, int otherwise) {
  const char* text = std::getenv(name);
  return text != nullptr ? std::atoi(text) : otherwise;
}

LabelMeshSettings SettingsOf(unsigned seed) {
  LabelMeshSettings settings;
  // As the presets default.json, organs.json and tissue.json have them.
  if (seed % 3 == 1) settings.conforming_tissues = {"bone", "liver", "kidney"};
  if (seed % 3 == 2) {
    settings.conforming_tissues = {"all"};
    settings.sizes.interface_mm = 10.0;
    settings.sizes.finest_mm = 2.5;
    settings.smoothing_mm = 0.6;
    settings.volume_tolerance = 0.02;
  }
  settings.min_dihedral_deg = kLeastAngleDeg;
  return settings;
}

TEST(DamagedLabelMaps, AllAreMeshedWithGoodAngles) {
  int failed = 0;
  double least_deg = 180.0, most_s = 0.0;
  // As many, and from that seed on, as ACUS_DAMAGED_MAPS and ACUS_FIRST_DAMAGED_MAP state.
  const int first = FromEnvironment("ACUS_FIRST_DAMAGED_MAP", 0);
  const int count = FromEnvironment("ACUS_DAMAGED_MAPS", 24);
  for (int n = 0; n < count; ++n) {
    const auto seed = static_cast<unsigned>(first + n);
    const testing_support::DamagedMap map = testing_support::DamagedMapMaker(seed).Make();
    SCOPED_TRACE(testing::Message() << "seed " << seed << ": " << map.story);
    const double begin_s = ProcessCpuSeconds();
    try {
      const LabelMesh mesh = MeshLabelMap(map.labels, SettingsOf(seed), {});
      const mesh::QualityReport quality = mesh::MeasureQuality(mesh.mesh);
      EXPECT_GE(quality.min_dihedral_deg, kLeastAngleDeg);
      EXPECT_EQ(quality.num_inverted, 0);
      EXPECT_NEAR(mesh.body_mesh_ml, mesh.body_target_ml, 0.03 * mesh.body_target_ml);
      least_deg = std::min(least_deg, quality.min_dihedral_deg);
    } catch (const std::exception& error) {
      ++failed;
      ADD_FAILURE() << error.what();
    }
    const double cpu_s = ProcessCpuSeconds() - begin_s;
    EXPECT_LT(cpu_s, kMostCpuS);
    most_s = std::max(most_s, cpu_s);
  }
  std::printf("  %d maps, %d failed, smallest angle %.1f degrees, longest %.1f s\n", count, failed,
              least_deg, most_s);
}

}  // namespace
}  // namespace acus::meshing
