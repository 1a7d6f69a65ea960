#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

#include "acus/base/core/error.h"
#include "acus/imaging/ultrasound/columns/alamilla.h"
#include "support/icosphere.h"

namespace acus::ultrasound {
namespace {

constexpr volume::Label kFatBall = 2;
constexpr volume::Label kMuscleBall = 3;
constexpr volume::Label kBoneBall = 5;

/// 0.1 mm per pixel.
acoustics::Probe BallProbe() {
  return {.name = "fine",
          .kind = acoustics::ProbeKind::kLinear,
          .frequency_mhz = 10,
          .width_mm = 32,
          .depth_mm = 31.9,
          .image_width_px = 320,
          .image_height_px = 320,
          .slice_thickness_mm = 3,
          .dynamic_range_db = 60};
}

AlamillaOptions BallGreys() {
  AlamillaOptions options;
  options.tissues = {{.tissue = "fat", .grey = 0.3, .contrast = 0.8},
                     {.tissue = "muscle", .grey = 0.5, .contrast = 0.8},
                     {.tissue = "bone", .grey = 0.8, .reflection = 0.5, .blocks = true}};
  options.reflection = options.shadow = options.absorption = options.speckle = false;
  options.surface_mm = 1.0;
  options.coupling_gap_mm = 5.0;
  return options;
}

constexpr double kFatMm = 30.0, kMuscleMm = 20.0, kBoneMm = 8.0;
const Eigen::Vector3d kBoneMiddle(3.0, 4.0, 1.0);

volume::Label BallTissueAt(const Eigen::Vector3d& place) {
  if ((place - kBoneMiddle).norm() < kBoneMm) return kBoneBall;
  if (place.norm() < kMuscleMm) return kMuscleBall;
  return place.norm() < kFatMm ? kFatBall : 0;
}

volume::LabelMap VoxelsOfBalls(double spacing_mm) {
  volume::Geometry g;
  g.size.setConstant(static_cast<int>(64.0 / spacing_mm));
  g.spacing_mm.setConstant(spacing_mm);
  g.origin_mm.setConstant(-31.9);
  volume::LabelMap labels(g);
  for (int k = 0; k < g.size[2]; ++k) {
    for (int j = 0; j < g.size[1]; ++j) {
      for (int i = 0; i < g.size[0]; ++i) {
        labels.At(i, j, k) = BallTissueAt(g.ct_from_index() * Eigen::Vector3d(i, j, k));
      }
    }
  }
  labels.names = {{0, "outside"}, {kFatBall, "fat"}, {kMuscleBall, "muscle"}, {kBoneBall, "bone"}};
  return labels;
}

const tracing::SurfaceTracer& Balls() {
  using testing_support::Icosphere;
  static const tracing::SurfaceTracer tracer(
      {{Icosphere(kFatMm, 6), mesh::Winding::kOriented, kFatBall},
       {Icosphere(kMuscleMm, 6), mesh::Winding::kOriented, kMuscleBall},
       {Icosphere(kBoneMm, 5, kBoneMiddle), mesh::Winding::kOriented, kBoneBall}},
      1);
  return tracer;
}

/// The face at y = -28 mm, beams along +y.
const Eigen::Isometry3d kBallPose(Eigen::Translation3d(0, -28, 1));

image::GrayImage RenderedBalls(const volume::LabelMap& labels, const AlamillaOptions& options,
                               const tracing::SurfaceTracer* triangles,
                               const std::optional<image::NeedleInImage>& needle = std::nullopt,
                               const slicing::RestMap* rest = nullptr, int num_threads = 1) {
  AlamillaRenderer renderer(labels, BallProbe(), options, triangles);
  image::GrayImage image;
  renderer.Render(kBallPose, needle, image, num_threads, rest);
  return image;
}

/// Share of pixels whose grey is not that of the closed form, and the depth of the farthest
/// boundary from it, in pixels.
double WrongShare(const image::GrayImage& image) {
  const AlamillaOptions options = BallGreys();
  const acoustics::ScanGrid grid = acoustics::ScanGridOf(BallProbe());
  int wrong = 0;
  for (int x = 0; x < grid.lines(); ++x) {
    for (int y = 0; y < grid.samples; ++y) {
      const Eigen::Vector2d at = grid.start_mm[static_cast<std::size_t>(x)] +
                                 y * grid.step_mm * grid.direction[static_cast<std::size_t>(x)];
      const volume::Label label = BallTissueAt(kBallPose * Eigen::Vector3d(at[0], at[1], 0.0));
      const double grey = label == kFatBall      ? options.tissues[0].grey
                          : label == kMuscleBall ? options.tissues[1].grey
                          : label == kBoneBall   ? options.tissues[2].grey
                                                 : 0.0;
      wrong += std::abs(image.At(x, y) - 255.0 * grey) > 1.0 ? 1 : 0;
    }
  }
  return wrong / (1.0 * grid.lines() * grid.samples);
}

TEST(AlamillaTriangles, ShowsTheClosedFormWhateverTheVoxels) {
  ASSERT_EQ(acoustics::ScanGridOf(BallProbe()).lines(), 320);
  for (const double spacing_mm : {0.5, 2.0}) {
    const volume::LabelMap labels = VoxelsOfBalls(spacing_mm);
    const double by_voxels = WrongShare(RenderedBalls(labels, BallGreys(), nullptr));
    const double by_triangles = WrongShare(RenderedBalls(labels, BallGreys(), &Balls()));
    EXPECT_LT(by_triangles, 0.0005) << spacing_mm;  // Facets lie up to 0.002 mm inside.
    EXPECT_GT(by_voxels, 0.004 * spacing_mm) << spacing_mm;
  }
}

TEST(AlamillaTriangles, TheWholeImageIsCloseToThatOfFineVoxels) {
  AlamillaOptions options = BallGreys();
  options.reflection = options.shadow = options.absorption = options.speckle = true;
  options.angle_exponent = 1;
  options.tissues[1].absorption_per_cm = 0.3;
  const volume::LabelMap labels = VoxelsOfBalls(0.25);
  const image::NeedleInImage needle{{-4, 2, 1}, Eigen::Vector3d(0.4, 0.9, 0).normalized(), 80, 0.6};
  const image::GrayImage voxels = RenderedBalls(labels, options, nullptr, needle);
  const image::GrayImage triangles = RenderedBalls(labels, options, &Balls(), needle);
  std::size_t different = 0;
  for (std::size_t n = 0; n < voxels.pixels.size(); ++n) {
    different += std::abs(voxels.pixels[n] - triangles.pixels[n]) > 25 ? 1 : 0;
  }
  // At the boundaries only.
  EXPECT_LT(static_cast<double>(different), 0.03 * static_cast<double>(voxels.pixels.size()));
  EXPECT_NE(voxels.pixels, triangles.pixels);
}

class PushedBalls : public slicing::RestMap {
 public:
  Eigen::Vector3d RestInCtMm(const Eigen::Vector3d& x,
                             const Eigen::Vector3d&) const noexcept override {
    const double r = std::min(1.0, std::hypot(x[0], x[2]) / 12.0);
    return x - 4.0 * (1.0 - r * r) * (1.0 - r * r) * Eigen::Vector3d::UnitY();
  }
  double SpacingMm() const noexcept override { return 1.0; }
};

TEST(AlamillaTriangles, DeformedTissueIsFollowedAndThreadsChangeNoBit) {
  const volume::LabelMap labels = VoxelsOfBalls(0.5);
  const PushedBalls pushed;
  AlamillaOptions options = BallGreys();
  const image::GrayImage one = RenderedBalls(labels, options, &Balls(), std::nullopt, &pushed);
  const image::GrayImage three = RenderedBalls(labels, options, &Balls(), std::nullopt, &pushed, 3);
  EXPECT_EQ(one.pixels, three.pixels);
  // In the middle column, where everything lies 4 mm deeper: the muscle begins there.
  const auto first_muscle = [&](const image::GrayImage& image) {
    int y = 0;
    while (image.At(160, y) < 255 * 0.4) ++y;
    return 0.1 * y;
  };
  const image::GrayImage rest = RenderedBalls(labels, options, &Balls());
  EXPECT_NEAR(first_muscle(rest), 28.0 - std::sqrt(400.0 - 1.0), 0.11);
  EXPECT_NEAR(first_muscle(one) - first_muscle(rest), 4.0, 0.15);
}

TEST(AlamillaTriangles, TissueBetweenTheVoxelsNeedsARowToo) {
  volume::LabelMap labels = VoxelsOfBalls(2.0);
  std::ranges::replace(labels.voxels, kBoneBall, kMuscleBall);
  AlamillaOptions options = BallGreys();
  options.tissues.pop_back();
  EXPECT_NO_THROW(AlamillaRenderer(labels, BallProbe(), options));
  EXPECT_THROW(AlamillaRenderer(labels, BallProbe(), options, &Balls()), InputError);
}

}  // namespace
}  // namespace acus::ultrasound
