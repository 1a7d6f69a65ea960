#include "benchmarks/views_sweep.h"

#include <cmath>
#include <gtest/gtest.h>
#include <map>

#include "benchmarks/trunk_body.h"

namespace acus::benchmarks {
namespace {

using Eigen::Vector3d;

// Against sums over many small steps, along rays in any direction.
TEST(TrunkBody, RaySumsAreThoseOfTheCt) {
  const auto ct = TrunkBody::Ct(128);
  const Eigen::Affine3d index_from_ct = ct->geometry.ct_from_index().inverse();
  int through_bone = 0;
  for (int n = 0; n < 40; ++n) {
    const double turn = 0.4 * n;
    const Vector3d from(400.0 * std::cos(turn), 400.0 * std::sin(turn), 60.0 * std::sin(0.7 * n));
    const Vector3d to(-380.0 * std::cos(turn + 0.1), -380.0 * std::sin(turn + 0.1), 30.0);
    constexpr int kSteps = 4000;
    double sum_mm = 0.0;
    for (int step = 0; step < kSteps; ++step) {
      const Eigen::Array3i index = (index_from_ct * (from + (to - from) * ((step + 0.5) / kSteps)))
                                       .array()
                                       .round()
                                       .cast<int>();
      if ((index < 0).any() || (index >= ct->geometry.size).any()) continue;
      const int hu = ct->At(index[0], index[1], index[2]);
      through_bone += hu > 600;
      sum_mm += (1.0 + hu / 1000.0) * (to - from).norm() / kSteps;
    }
    const double exact_mm = TrunkBody::WaterMm(from, to);
    EXPECT_NEAR(sum_mm, exact_mm, 0.02 * exact_mm + 1.0) << n;
  }
  EXPECT_GT(through_bone, 1000);
}

TEST(TrunkBody, IsAirOutside) {
  EXPECT_EQ(TrunkBody::WaterMm({-300.0, 130.0, 0.0}, {300.0, 130.0, 0.0}), 0.0);
  EXPECT_EQ(TrunkBody::Ct(32)->At(0, 0, 0), -1000);
}

TEST(ViewsSweep, ErrorsFallTowardsTheMostExpensive) {
  std::map<std::string, std::map<std::string, Row>> rows;
  for (const Row& row : ViewsSweep().run(true, RunContext())) {
    EXPECT_TRUE(std::isfinite(row.error) && row.error >= 0.0) << row.knob << " " << row.value;
    EXPECT_GT(row.step_us_median, 0.0);
    rows[row.knob][row.value] = row;
  }
  const auto error = [&](const char* knob, const char* value) {
    return rows.at(knob).at(value).error;
  };
  // Rays of real attenuation within a percent or two also of voxels of 4 mm.
  EXPECT_LT(error("fluoroscopy: detail", "1"), 2.0);
  EXPECT_LT(error("fluoroscopy: detail", "1"), error("fluoroscopy: detail", "4"));
  EXPECT_LT(error("volume rendering: ray step_mm, skin", "1"),
            error("volume rendering: ray step_mm, skin", "4"));
  EXPECT_LT(error("volume rendering: ray step_mm, bone", "1"),
            error("volume rendering: ray step_mm, bone", "4"));
  EXPECT_LT(error("volume rendering: image_px", "256"), error("volume rendering: image_px", "128"));
  EXPECT_LT(error("volume rendering: supersampling", "2"),
            error("volume rendering: supersampling", "1"));
  EXPECT_LT(error("volume rendering: warp_tolerance_mm", "0.002"),
            error("volume rendering: warp_tolerance_mm", "0.15"));
  EXPECT_LT(error("volume rendering: warp_iterations", "5"),
            error("volume rendering: warp_iterations", "1"));
  EXPECT_GT(error("volume rendering: breath, skin", "at rest"), 1.0);
  EXPECT_EQ(error("volume rendering: breath, skin", "breathing"), 0.0);
  EXPECT_TRUE(rows.at("fluoroscopy: detail").at("2").is_default);
}

}  // namespace
}  // namespace acus::benchmarks
