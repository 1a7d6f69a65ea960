#include "acus/physics/tissue/local_compliance.h"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

namespace acus::tissue {
namespace {

constexpr mechanics::ElasticTissue kTissue{0.03, 0.45};

TEST(ShaftCompliance, IsKelvinsLineLoadBetweenTwoRadii) {
  // Around a line load per length q in an infinite solid, u(r) - u(R) = q / (2 pi G) ln(R / r)
  // along it. Between 0.5 mm and what elements of 10 mm resolve, for 2 mm of shaft:
  const double shear_mpa = 0.03 / 2.9;
  const LocalCompliance local = ShaftCompliance(kTissue, 10.0, 0.5, 2.0);
  EXPECT_NEAR(local.axial_mm_per_n,
              std::log(kAxialRadiusShare * 10.0 / 0.5) / (2.0 * std::numbers::pi * shear_mpa * 2.0),
              1e-12);
  // Across, (3 - 4 nu) / (8 pi G (1 - nu)), 0.5454 of it at nu = 0.45.
  EXPECT_NEAR(local.lateral_mm_per_n,
              1.2 * std::log(kLateralRadiusShare * 10.0 / 0.5) /
                  (8.0 * std::numbers::pi * shear_mpa * 0.55 * 2.0),
              1e-12);
}

TEST(ShaftCompliance, AddsUpToTheSameHoweverTheShaftIsCut) {
  // n points of 1/n of the length, each with 1/n of the force: the same displacement.
  const LocalCompliance whole = ShaftCompliance(kTissue, 10.0, 0.5, 6.0);
  const LocalCompliance third = ShaftCompliance(kTissue, 10.0, 0.5, 2.0);
  EXPECT_NEAR(third.axial_mm_per_n / 3.0, whole.axial_mm_per_n, 1e-12);
  EXPECT_NEAR(third.lateral_mm_per_n / 3.0, whole.lateral_mm_per_n, 1e-12);
}

TEST(ShaftCompliance, StaysPositiveInElementsAsFineAsTheNeedle) {
  for (const double element_mm : {0.01, 0.1, 1.0, 3.0}) {
    EXPECT_GT(ShaftCompliance(kTissue, element_mm, 0.6, 1.0).axial_mm_per_n, 0.0);
    EXPECT_GT(ShaftCompliance({0.03, 0.499}, element_mm, 0.6, 1.0).lateral_mm_per_n, 0.0);
    EXPECT_GT(NearFieldPerMm(KernelRadiusMm(element_mm, 2.0), 2.0), 0.0);
  }
}

TEST(LumpRadius, IsWhereTheLinearStrainIsOne) {
  // Shear stress F / (4 pi r^2) over G: 1 N in liver of 5.5 kPa, nu 0.49.
  const mechanics::ElasticTissue liver{0.0055, 0.49};
  const double radius_mm = LumpRadiusMm(liver, 1.0, false, 0.6);
  EXPECT_NEAR(1.0 / (4.0 * std::numbers::pi * radius_mm * radius_mm) / liver.ShearModulusMpa(), 1.0,
              1e-12);
  EXPECT_EQ(LumpRadiusMm(liver, 0.0, false, 0.6), 0.6);
  EXPECT_EQ(LumpRadiusMm(liver, 1e3, true, 0.6), kLargestLumpMm);
}

TEST(TipMobility, IsOfASphereInsideAndAPunchOnTheSurface) {
  // Rigid sphere in an infinite solid: F = 24 pi G a (1 - nu) u / (5 - 6 nu).
  const double shear_mpa = 0.03 / 2.9;
  EXPECT_NEAR(SphereMobilityMm2PerN(kTissue),
              (5.0 - 2.7) / (24.0 * std::numbers::pi * shear_mpa * 0.55), 1e-12);
  EXPECT_NEAR(PunchMobilityMm2PerN(kTissue), 0.55 / (4.0 * shear_mpa), 1e-12);
}

TEST(NearField, IsWhatTheKernelIsTooWideFor) {
  EXPECT_NEAR(NearFieldPerMm(7.4, 1.0), 1.0 - 1.0 / 4.0, 1e-12);
  EXPECT_NEAR(NearFieldPerMm(18.5, 10.0), 0.02 / 10.0, 1e-12);
  // One size for all meshes that can carry it.
  EXPECT_EQ(KernelRadiusMm(1.0, 0.6), kLeastKernelMm);
  EXPECT_EQ(KernelRadiusMm(4.0, 4.0), kLeastKernelMm);
  EXPECT_NEAR(KernelRadiusMm(6.0, 0.6), 11.1, 1e-12);
  EXPECT_NEAR(KernelRadiusMm(1.0, 10.0), 18.5, 1e-12);
}

}  // namespace
}  // namespace acus::tissue
