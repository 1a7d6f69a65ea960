#include "acus/physics/tissue/membrane_dimple.h"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <vector>

namespace acus::tissue {
namespace {

/// Least stretching energy of the dimple (1 - r^2)^2 in a sheet with E t = 1, over the radial
/// displacements of 4000 linear elements out to 60 radii.
double SheetEnergy(double nu) {
  constexpr int kHalf = 2000;
  std::vector<double> r;
  for (int i = 0; i <= kHalf; ++i) r.push_back(1.0 * i / kHalf);
  for (int i = 1; i <= kHalf; ++i) r.push_back(std::pow(60.0, 1.0 * i / kHalf));
  const std::size_t m = r.size();
  std::vector<double> diagonal(m, 0.0), beside(m, 0.0), load(m, 0.0);
  double constant = 0.0;
  for (std::size_t i = 0; i + 1 < m; ++i) {
    const double h = r[i + 1] - r[i], middle = 0.5 * (r[i] + r[i + 1]);
    const double slope = middle < 1.0 ? -4.0 * middle * (1.0 - middle * middle) : 0.0;
    const double bent = 0.5 * slope * slope, weight = middle * h;
    // Strains: e_r = (b - a) / h + bent, e_t = (a + b) / 2 middle.
    const double p = 1.0 / h, q = 0.5 / middle;
    diagonal[i] += weight * (p * p + q * q - 2.0 * nu * p * q);
    diagonal[i + 1] += weight * (p * p + q * q + 2.0 * nu * p * q);
    beside[i] += weight * (-p * p + q * q);
    load[i] -= weight * bent * (-p + nu * q);
    load[i + 1] -= weight * bent * (p + nu * q);
    constant += weight * bent * bent;
  }
  diagonal[0] = 1e12;  // The middle stays.
  std::vector<double> u = load;
  for (std::size_t i = 1; i < m; ++i) {
    const double share = beside[i - 1] / diagonal[i - 1];
    diagonal[i] -= share * beside[i - 1];
    u[i] -= share * u[i - 1];
  }
  u[m - 1] /= diagonal[m - 1];
  for (std::size_t i = m - 1; i-- > 0;) u[i] = (u[i] - beside[i] * u[i + 1]) / diagonal[i];
  double work = 0.0;
  for (std::size_t i = 0; i < m; ++i) work += load[i] * u[i];
  return std::numbers::pi * (constant - work) / (1.0 - nu * nu);
}

TEST(MembraneDimple, ItsForceIsThatOfTheStretchedSheet) {
  for (const double nu : {0.3, 0.49}) {
    const double energy = SheetEnergy(nu);  // For a depth of 1; a kernel moves by 0.6.
    const MembraneDimple dimple{1.0, 1.0};
    EXPECT_NEAR(dimple.ForceN(0.6), 4.0 * energy / 0.6, 0.002 * dimple.ForceN(0.6)) << nu;
  }
}

TEST(MembraneDimple, TheSlopeIsTheForcesDerivative) {
  const MembraneDimple dimple{0.26, 12.0};
  for (const double w : {0.5, 3.0, 9.0}) {
    EXPECT_NEAR(dimple.SlopeNPerMm(w), (dimple.ForceN(w + 1e-4) - dimple.ForceN(w - 1e-4)) / 2e-4,
                1e-6);
  }
  EXPECT_EQ(dimple.ForceN(-1.0), 0.0);
  EXPECT_EQ(dimple.SlopeNPerMm(-1.0), 0.0);
}

TEST(MembraneDimple, TheRadiusHasTheLeastEnergy) {
  const double stretching = 0.26, ground = 0.05, w = 5.0;
  const double best = DimpleRadiusMm(stretching, ground, w, 1.0);
  const auto energy = [&](double a) {
    return 0.25 * w * MembraneDimple{stretching, a}.ForceN(w) + 0.5 * ground * a * w * w;
  };
  EXPECT_LT(energy(best), energy(1.01 * best));
  EXPECT_LT(energy(best), energy(0.99 * best));
  EXPECT_EQ(DimpleRadiusMm(stretching, ground, 0.0, 7.4), 7.4);
  EXPECT_EQ(DimpleRadiusMm(stretching, ground, 1e6, 7.4), kWidestDimpleMm);
}

TEST(MembraneDimple, TheNearFieldIsBentFirstAndStretchedThen) {
  const MembraneDimple dimple{0.26, 15.0};
  EXPECT_NEAR(dimple.NearFieldMmPerN(5.0, 1e-9), 5.0, 1e-4);
  EXPECT_EQ(dimple.NearFieldMmPerN(5.0, 0.0), 5.0);
  // Far: Schwerin's depth less its mean over the kernel, 0.42 of it.
  const double force_n = 1e5;
  const double depth_mm = std::cbrt(3.0 * force_n * 225.0 / (std::numbers::pi * 0.26));
  EXPECT_NEAR(dimple.NearFieldMmPerN(5.0, force_n) * force_n / depth_mm, 1.0 - 0.4214, 0.002);
  EXPECT_EQ(MembraneDimple{}.NearFieldMmPerN(5.0, 3.0), 5.0);
}

}  // namespace
}  // namespace acus::tissue
