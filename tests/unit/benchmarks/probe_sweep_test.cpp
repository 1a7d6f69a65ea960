#include "benchmarks/probe_sweep.h"

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <gtest/gtest.h>
#include <map>

#include "benchmarks/pressed_tool.h"

namespace acus::benchmarks {
namespace {

using Kind = PressedTool::Kind;
constexpr forces::MultiProxySettings::Repulsion kLaw{
    .a1_n_per_mm = 0.3, .a2_n_per_mm2 = 0.02, .friction = 0.0};

TEST(PressedTool, AFlatFaceFeelsThePolynomial) {
  const PressedTool tool{Kind::kFlat};
  const auto load = tool.Exact(kLaw, tool.BodyFromTool(10.0, 3.0));
  EXPECT_NEAR((load.force_n - Eigen::Vector3d(0.0, 0.0, 5.0)).norm(), 0.0, 1e-9);
  EXPECT_NEAR(load.torque_n_mm.norm(), 0.0, 1e-9);
  EXPECT_EQ(tool.Exact(kLaw, tool.BodyFromTool(-1.0, 0.0)).force_n.norm(), 0.0);
}

// Depth is d + x sin(tilt): the mean over the face has a closed form.
TEST(PressedTool, ATiltedFaceFeelsItsIntegral) {
  const PressedTool tool{Kind::kTilted};
  const auto load = tool.Exact(kLaw, tool.BodyFromTool(10.0, 0.0));
  const double slope = std::sin(PressedTool::kTiltRad);
  const double spread = PressedTool::kFaceMm * PressedTool::kFaceMm / 12.0;
  EXPECT_NEAR(load.force_n.z(), 0.3 * 10.0 + 0.02 * (100.0 + slope * slope * spread), 1e-3);
  const double torque =
      std::cos(PressedTool::kTiltRad) * spread * (0.3 * slope + 2.0 * 0.02 * 10.0 * slope);
  EXPECT_NEAR(std::abs(load.torque_n_mm.y()), torque, 1e-3 * torque);
}

// Whole hemisphere in: depth is d - r (1 - u), u even from 0 to 1.
TEST(PressedTool, AFingertipFeelsItsIntegral) {
  const PressedTool tool{Kind::kFingertip};
  const auto load = tool.Exact(kLaw, tool.BodyFromTool(10.0, 0.0));
  const double mean = 10.0 - 0.5 * PressedTool::kFingertipMm;
  const double square = mean * mean + PressedTool::kFingertipMm * PressedTool::kFingertipMm / 12.0;
  EXPECT_NEAR(load.force_n.z(), 0.3 * mean + 0.02 * square, 1e-4);
}

TEST(PressedTool, OnRoundSkinOnlyWhatTouchesIsFelt) {
  const PressedTool tool{Kind::kRound};
  const double depth_mm = 1.0;
  const double edge_mm = std::sqrt(PressedTool::kRoundMm * PressedTool::kRoundMm -
                                   std::pow(PressedTool::kRoundMm - depth_mm, 2.0));
  EXPECT_LT(edge_mm, 0.5 * PressedTool::kFaceMm);
  // A parabola's mean depth, 2/3 of the middle's over the part that touches.
  const auto load = tool.Exact({.a1_n_per_mm = 1.0, .a2_n_per_mm2 = 0.0, .friction = 0.0},
                               tool.BodyFromTool(depth_mm, 0.0));
  EXPECT_NEAR(load.force_n.z(), 2.0 / 3.0 * depth_mm * 2.0 * edge_mm / PressedTool::kFaceMm, 0.01);
  EXPECT_NEAR(load.force_n.x(), 0.0, 1e-9);
}

TEST(ProbeSweep, ErrorsFallWithTheNumberOfProxies) {
  setenv("ACUS_CONFIGS", (std::filesystem::path(ACUS_SOURCE_DIR) / "configs").c_str(), 1);
  std::map<std::string, std::map<int, double>> force_n;
  int defaults = 0;
  for (const Row& row : ProbeSweep().run(true, RunContext())) {
    EXPECT_EQ(row.unusable, "");
    EXPECT_GT(row.step_us_median, 0.0);
    defaults += row.is_default;
    if (row.error_unit == "N") force_n[row.knob][std::stoi(row.value)] = row.error;
  }
  EXPECT_EQ(defaults, 8);
  ASSERT_EQ(force_n.size(), 4u);
  for (const auto& [knob, by_number] : force_n) {
    if (knob.find("square") != knob.npos) {
      for (const auto& [number, error] : by_number) EXPECT_LT(error, 1e-4) << number;
      continue;
    }
    EXPECT_LT(by_number.at(16), 0.5 * by_number.at(1)) << knob;
    EXPECT_LT(by_number.at(64), 0.5 * by_number.at(16)) << knob;
    EXPECT_LT(by_number.at(64), 0.02) << knob;
  }
}

}  // namespace
}  // namespace acus::benchmarks
