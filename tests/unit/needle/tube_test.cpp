#include "needle/tube.h"

#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <numbers>

#include "core/atomic_file.h"
#include "core/error.h"
#include "needle/stiffness_fit.h"
#include "support/temporary_folder.h"

namespace acus::needle {
namespace {

TEST(Tube, HasTheStiffnessOfARingAndOfAFullRound) {
  const Tube ring{2.0, 1.0, 200e3, 0.25};
  EXPECT_NEAR(ring.SecondMomentMm4(), std::numbers::pi / 64.0 * 15.0, 1e-12);
  EXPECT_NEAR(ring.BendingStiffnessNMm2(), 200e3 * std::numbers::pi / 64.0 * 15.0, 1e-6);
  // G J = E / (2 (1 + nu)) * 2 I.
  EXPECT_NEAR(ring.TwistStiffnessNMm2() / ring.BendingStiffnessNMm2(), 0.8, 1e-12);
  const Tube round{2.0, 0.0, 200e3, 0.25};
  EXPECT_NEAR(round.SecondMomentMm4(), std::numbers::pi / 4.0, 1e-12);
}

const std::filesystem::path kNeedles = std::filesystem::path(ACUS_SOURCE_DIR) / "configs/needles";

TEST(ReadRod, ThePresetOfTheMeasuredNeedleBendsAsItWasMeasured) {
  const RodProperties rod = ReadRod(kNeedles / "measured_16g.json");
  EXPECT_NEAR(TipDeflectionMm(0.5, rod.length_mm, rod.bending_n_mm2), 12.5, 0.4);
  EXPECT_NEAR(TipDeflectionMm(1.0, rod.length_mm, rod.bending_n_mm2), 26.0, 0.85);
  // The steel tube of the same gauge is 18 % stiffer.
  const RodProperties steel = ReadRod(kNeedles / "biopsy_16g.json");
  EXPECT_NEAR(steel.bending_n_mm2 / rod.bending_n_mm2, 193.0 / 163.5, 1e-9);
}

TEST(ReadRod, RefusesATubeWithoutAWall) {
  const testing_support::TemporaryFolder folder;
  const std::filesystem::path path = folder.path() / "needle.json";
  std::ofstream(path) << R"({"format": "acus-needle/1", "name": "x", "gauge": 16,
    "outer_diameter_mm": 1.2, "inner_diameter_mm": 1.2, "length_mm": 100})";
  EXPECT_THROW(ReadRod(path), InputError);
}

}  // namespace
}  // namespace acus::needle
