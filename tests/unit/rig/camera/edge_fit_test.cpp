#include "acus/rig/camera/edge_fit.h"

#include <cmath>
#include <gtest/gtest.h>
#include <vector>

#include "acus/base/core/random.h"

namespace acus::camera {
namespace {

struct Truth {
  double offset_px = 0.3;
  double slope = 0.05;
  double blur_px = 0.8;
  double noise = 2.0;
};

std::vector<EdgePixel> Edge(const Truth& truth, std::uint64_t index) {
  RandomStream random(9, "edge", index);
  std::vector<EdgePixel> pixels;
  for (int along = -20; along <= 20; ++along) {
    for (int across = -4; across <= 4; ++across) {
      const double d = across - truth.offset_px - truth.slope * along;
      const double level = 110.0 + 70.0 * std::erf(d / (std::sqrt(2.0) * truth.blur_px)) +
                           truth.noise * random.Normal();
      pixels.push_back({static_cast<double>(along), static_cast<double>(across), level});
    }
  }
  return pixels;
}

TEST(EdgeFit, FindsTheEdgeAndItsSpread) {
  const Truth truth;
  double sum = 0.0;
  double expected = 0.0;
  constexpr int kRuns = 60;
  for (std::uint64_t i = 0; i < kRuns; ++i) {
    const auto fit = FitEdge(Edge(truth, i), 4.0);
    ASSERT_TRUE(fit);
    EXPECT_NEAR(fit->offset_px, truth.offset_px, 0.03);
    EXPECT_NEAR(fit->slope, truth.slope, 0.003);
    EXPECT_NEAR(fit->blur_sigma_px, truth.blur_px, 0.1);
    EXPECT_NEAR(fit->contrast, 140.0, 3.0);
    sum += std::pow(fit->offset_px - truth.offset_px, 2) / kRuns;
    expected += fit->covariance(0, 0) / kRuns;
  }
  // Its variance is what it says, within the spread of 60 draws.
  EXPECT_GT(sum, 0.6 * expected);
  EXPECT_LT(sum, 1.6 * expected);
}

TEST(EdgeFit, LeavesOutWhatHidesAPartOfIt) {
  Truth truth;
  auto pixels = Edge(truth, 0);
  for (EdgePixel& pixel : pixels) {
    if (pixel.along_px > 16.0) pixel.level = 150.0;  // A finger over a tenth.
  }
  const auto fit = FitEdge(pixels, 4.0);
  ASSERT_TRUE(fit);
  EXPECT_NEAR(fit->offset_px, truth.offset_px, 0.05);
  EXPECT_NEAR(fit->slope, truth.slope, 0.005);
}

TEST(EdgeFit, ReportsThatThereIsNoEdge) {
  std::vector<EdgePixel> flat = Edge({}, 1);
  for (EdgePixel& pixel : flat) pixel.level = 100.0;
  EXPECT_FALSE(FitEdge(flat, 4.0));
  // White inside and black outside is another kind of edge.
  std::vector<EdgePixel> inverse = Edge({}, 2);
  for (EdgePixel& pixel : inverse) pixel.level = 220.0 - pixel.level;
  EXPECT_FALSE(FitEdge(inverse, 4.0));
  EXPECT_FALSE(FitEdge({}, 4.0));
  EXPECT_FALSE(FitEdge(std::vector<EdgePixel>(11, {0, 0, 100}), 4.0));
}

}  // namespace
}  // namespace acus::camera
