#include "benchmarks/registration_sweep.h"

#include <cmath>
#include <gtest/gtest.h>
#include <map>

#include "benchmarks/breathing_body.h"

namespace acus::benchmarks {
namespace {

// A voxel at rest and where breath has taken it hold the same tissue.
TEST(BreathingBodyCt, TissueKeepsItsLook) {
  const auto rest = BreathingBodyCt(4.0, false, 0.0, 0);
  const auto moved = BreathingBodyCt(4.0, true, 0.0, 0);
  const auto breath = BreathingBody::BreathAt(0.5);
  const Eigen::Affine3d ct_from_index = rest.geometry.ct_from_index();
  const Eigen::Affine3d index_from_ct = ct_from_index.inverse();
  double sum = 0.0, still = 0.0;
  int count = 0;
  for (int k = 8; k < 30; ++k) {
    for (int i = 4; i < 16; ++i) {
      const Eigen::Vector3d place = ct_from_index * Eigen::Vector3d(i, 20, k);
      const Eigen::Vector3d to =
          index_from_ct * (place + BreathingBody::DisplacementMm(breath, place));
      const Eigen::Array3i cell = to.array().floor().cast<int>();
      double hu = 0.0;  // Trilinear.
      for (int n = 0; n < 8; ++n) {
        const Eigen::Array3i at = cell + Eigen::Array3i(n & 1, n >> 1 & 1, n >> 2);
        const Eigen::Array3d share = 1.0 - (to.array() - at.cast<double>()).abs();
        hu += share.prod() * moved.At(at[0], at[1], at[2]);
      }
      sum += std::abs(hu - rest.At(i, 20, k));
      still += std::abs(moved.At(i, 20, k) - rest.At(i, 20, k));
      ++count;
    }
  }
  EXPECT_LT(sum / count, 10.0);
  EXPECT_GT(still / count, 30.0);
}

TEST(RegistrationSweep, FindsTheMotionAndSaysWhatTheWallIsWorth) {
  std::map<std::string, std::map<std::string, double>> away_mm, near_mm;
  for (const Row& row : RegistrationSweep().run(true, {})) {
    EXPECT_EQ(row.unusable, "");
    EXPECT_GT(row.preparation_s, 0.0);
    (row.error_unit.starts_with("mm, more") ? away_mm : near_mm)[row.knob][row.value] = row.error;
  }
  // Voxels of 6 mm; what moves by 20 mm is found to a fraction of one.
  EXPECT_LT(away_mm.at("spacing_mm").at("6"), 1.5);
  EXPECT_LT(away_mm.at("spacing_mm").at("6"), away_mm.at("spacing_mm").at("12"));
  EXPECT_LT(away_mm.at("iterations").at("6"), away_mm.at("iterations").at("1"));
  EXPECT_LT(away_mm.at("smoothness").at("1"), away_mm.at("smoothness").at("100"));
  EXPECT_LT(near_mm.at("wall").at("slides"), 0.7 * near_mm.at("wall").at("nothing slides"));
}

}  // namespace
}  // namespace acus::benchmarks
