#include "acus/physics/needle/needle_preset.h"

#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <numbers>

#include "acus/base/core/error.h"
#include "references/stiffness_fit.h"
#include "support/temporary_folder.h"

namespace acus::needle {
namespace {

const std::filesystem::path kNeedles = std::filesystem::path(ACUS_SOURCE_DIR) / "configs/needles";

NeedleProperties NeedleOf(const std::string& keys) {
  const acus::testing_support::TemporaryFolder folder;
  const std::filesystem::path path = folder.path() / "needle.json";
  std::ofstream(path) << R"({"format": "acus-needle/1", "name": "x", "gauge": 16,
    "outer_diameter_mm": 1.2, "length_mm": 100)"
                      << keys << "}";
  return ReadNeedle(path);
}

TEST(ReadNeedle, ThePresetOfTheMeasuredNeedleBendsAsItWasMeasured) {
  const RodProperties rod = RodOf(ReadNeedle(kNeedles / "measured_16g.json"));
  EXPECT_NEAR(TipDeflectionMm(0.5, rod.length_mm, rod.bending_n_mm2), 12.5, 0.4);
  EXPECT_NEAR(TipDeflectionMm(1.0, rod.length_mm, rod.bending_n_mm2), 26.0, 0.85);
  // The steel tube of the same gauge is 18 % stiffer.
  const RodProperties steel = RodOf(ReadNeedle(kNeedles / "biopsy_16g.json"));
  EXPECT_NEAR(steel.bending_n_mm2 / rod.bending_n_mm2, 193.0 / 163.5, 1e-9);
}

TEST(ReadNeedle, ReadsTheBevel) {
  EXPECT_EQ(NeedleOf("").bevel.curvature_per_mm, 0.0);
  const NeedleProperties bent =
      NeedleOf(R"(, "bevel_curvature_per_mm": 0.004, "bevel_roll_deg": 90)");
  EXPECT_EQ(bent.bevel.curvature_per_mm, 0.004);
  EXPECT_NEAR(bent.bevel.roll_rad, 0.5 * std::numbers::pi, 1e-15);
  EXPECT_THROW(NeedleOf(R"(, "bevel_curvature_per_mm": -0.001)"), InputError);
  EXPECT_THROW(NeedleOf(R"(, "bevel_curvature_per_mm": 0.2)"), InputError);
  EXPECT_THROW(NeedleOf(R"(, "bevel_roll_deg": 361)"), InputError);
}

TEST(ReadNeedle, RefusesATubeWithoutAWall) {
  EXPECT_THROW(NeedleOf(R"(, "inner_diameter_mm": 1.2)"), InputError);
}

}  // namespace
}  // namespace acus::needle
