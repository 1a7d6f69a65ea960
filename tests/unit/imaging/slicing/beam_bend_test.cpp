#include "acus/imaging/slicing/beam_bend.h"

#include <cmath>
#include <functional>
#include <gtest/gtest.h>

#include "acus/imaging/slicing/ct_sampler.h"
#include "acus/imaging/slicing/ct_slice.h"
#include "acus/imaging/ultrasound/columns/bmode.h"
#include "support/synthetic_ct.h"

namespace acus::slicing {
namespace {

class Moved : public RestMap {
 public:
  Moved(std::function<Eigen::Vector3d(const Eigen::Vector3d&)> rest, double spacing_mm)
      : rest_(std::move(rest)), spacing_mm_(spacing_mm) {}
  Eigen::Vector3d RestInCtMm(const Eigen::Vector3d& x,
                             const Eigen::Vector3d&) const noexcept override {
    return rest_(x);
  }
  double SpacingMm() const noexcept override { return spacing_mm_; }

 private:
  std::function<Eigen::Vector3d(const Eigen::Vector3d&)> rest_;
  double spacing_mm_;
};

volume::Geometry ObliqueGeometry() {
  volume::Geometry g;
  g.size = {60, 50, 40};
  g.spacing_mm = {0.7, 0.9, 1.6};
  g.origin_mm = {-12.0, 30.0, 5.0};
  g.direction = Eigen::AngleAxisd(0.4, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  return g;
}

/// Trilinear interpolation gives this back exactly: HU tells where a sample was taken.
volume::CtVolume RampVolume(const volume::Geometry& g) {
  volume::CtVolume ct(g);
  for (int k = 0; k < g.size[2]; ++k) {
    for (int j = 0; j < g.size[1]; ++j) {
      for (int i = 0; i < g.size[0]; ++i) {
        ct.At(i, j, k) = static_cast<std::int16_t>(10 * i - 7 * j + 3 * k);
      }
    }
  }
  return ct;
}

struct Sampled {
  BeamImage hu;
  bool bent = false;
};

Sampled SampleWith(const volume::CtVolume& ct, const acoustics::ScanGrid& grid,
                   const RestMap* rest) {
  const CtSampler sampler(ct);
  const Eigen::Isometry3d pose(
      Eigen::Translation3d(ct.geometry.ct_from_index() * Eigen::Vector3d(30, 25, 20)));
  BeamLines lines;
  BeamBend bend;
  sampler.PlaceLines(grid, pose, lines);
  bend.Set(grid, pose, sampler.index_from_ct(), rest);
  Sampled out;
  out.bent = bend.active();
  out.hu.Resize(grid.lines(), grid.samples);
  sampler.Sample(lines, bend, out.hu, 1);
  return out;
}

acoustics::ScanGrid Grid() {
  return acoustics::ScanGridOf(image::ImageGeometry{
      .width_px = 37, .height_px = 41, .lateral_mm_per_px = 0.2, .axial_mm_per_px = 0.17});
}

TEST(BeamBend, SamplesAnAffineMotionExactlyAtAnySpacing) {
  const volume::CtVolume ct = RampVolume(ObliqueGeometry());
  Eigen::Matrix3d stretch;
  stretch << 0.05, -0.03, 0.01, 0.02, -0.04, 0.03, 0.01, 0.02, 0.03;
  const CtSampler sampler(ct);
  for (const double spacing_mm : {0.2, 1.0, 2.5, 50.0}) {
    const Moved rest(
        [&](const Eigen::Vector3d& x) -> Eigen::Vector3d {
          return x + stretch * x + Eigen::Vector3d(0.3, -0.2, 0.4);
        },
        spacing_mm);
    const acoustics::ScanGrid grid = Grid();
    const Sampled sampled = SampleWith(ct, grid, &rest);
    ASSERT_TRUE(sampled.bent);
    const Eigen::Vector3d origin = ct.geometry.ct_from_index() * Eigen::Vector3d(30, 25, 20);
    for (int k = 0; k < grid.samples; ++k) {
      for (int l = 0; l < grid.lines(); ++l) {
        const auto n = static_cast<std::size_t>(l);
        const Eigen::Vector2d p = grid.start_mm[n] + k * grid.step_mm * grid.direction[n];
        const Eigen::Vector3d x = rest.RestInCtMm(origin + Eigen::Vector3d(p[0], p[1], 0), origin);
        // Positions are floats: some 1e-5 of a voxel, times the ramp's 10 HU.
        ASSERT_NEAR(sampled.hu.row(k)[l], sampler.At(x), 2e-3)
            << l << ' ' << k << ' ' << spacing_mm;
      }
    }
  }
}

TEST(BeamBend, ErrorBetweenKnotsFallsWithTheSquareOfTheirSpacing) {
  const volume::CtVolume ct = RampVolume(ObliqueGeometry());
  const auto bump = [](const Eigen::Vector3d& x) -> Eigen::Vector3d {
    return x + Eigen::Vector3d(0.5 * std::sin(0.4 * x[0]), 0.5 * std::cos(0.3 * x[1]), 0.0);
  };
  const Moved fine(bump, 0.17);
  const Sampled truth = SampleWith(ct, Grid(), &fine);
  double previous = 0.0;
  for (const double spacing_mm : {3.2, 1.6, 0.8}) {
    const Moved coarse(bump, spacing_mm);
    const Sampled sampled = SampleWith(ct, Grid(), &coarse);
    double error = 0.0;
    for (int k = 0; k < 41; ++k) {
      for (int l = 0; l < 37; ++l) {
        error = std::max(error, std::abs(double{sampled.hu.row(k)[l]} - truth.hu.row(k)[l]));
      }
    }
    if (previous > 0.0) {
      EXPECT_LT(error, 0.4 * previous) << spacing_mm;
    }
    EXPECT_GT(error, 0.0);
    previous = error;
  }
}

TEST(BeamBend, WithoutMotionLinesStayStraightBitForBit) {
  const volume::CtVolume ct = RampVolume(ObliqueGeometry());
  const Moved still([](const Eigen::Vector3d& x) { return x; }, 1.0);
  const Sampled with = SampleWith(ct, Grid(), &still);
  const Sampled without = SampleWith(ct, Grid(), nullptr);
  EXPECT_FALSE(with.bent);
  for (int k = 0; k < 41; ++k) {
    for (int l = 0; l < 37; ++l) ASSERT_EQ(with.hu.row(k)[l], without.hu.row(k)[l]);
  }
}

acoustics::Probe SmallProbe(acoustics::ProbeKind kind) {
  return {.name = "test",
          .kind = kind,
          .frequency_mhz = 5,
          .scan_lines = 100,
          .width_mm = 40,
          .radius_mm = 40,
          .field_of_view_rad = 0.9,
          .depth_mm = 40,
          .image_width_px = 300,
          .image_height_px = 200,
          .slice_thickness_mm = 3,
          .pulse_length_mm = 0.8,
          .beam_width_mm = 1.2,
          .dynamic_range_db = 60,
          .gain_db = 20};
}

/// Tissue that moved by whole millimetres looks like what the probe would see elsewhere: echoes,
/// shadows and speckle alike.
TEST(BeamBend, MovedTissueLooksAsTheMovedProbeWouldSeeIt) {
  const auto ct = testing_support::SyntheticCt({80, 80, 60}, 1.0, [](double x, double y, double z) {
    return y < 4 ? -1000.0 : std::hypot(x - 40, y - 30, z - 30) < 6 ? 700.0 : 40.0 + 0.2 * x;
  });
  ultrasound::BModeOptions options = ultrasound::DefaultBModeOptions();
  options.texture = options.attenuation = true;
  options.angle_exponent = 2;
  const Eigen::Vector3d shift(2, 3, -4);
  const Moved rest([&](const Eigen::Vector3d& x) -> Eigen::Vector3d { return x + shift; }, 2.0);
  const Eigen::Isometry3d pose(Eigen::Translation3d(40, 8, 30));
  const Eigen::Isometry3d moved_pose = Eigen::Translation3d(shift) * pose;
  for (const acoustics::ProbeKind kind :
       {acoustics::ProbeKind::kLinear, acoustics::ProbeKind::kCurvilinear}) {
    ultrasound::BModeRenderer renderer(ct, SmallProbe(kind), options);
    image::GrayImage bent, moved, still;
    renderer.Render(pose, std::nullopt, bent, 1, &rest);
    renderer.Render(moved_pose, std::nullopt, moved);
    renderer.Render(pose, std::nullopt, still);
    ASSERT_EQ(bent.pixels.size(), moved.pixels.size());
    EXPECT_NE(bent.pixels, still.pixels);
    int differing = 0;  // Rounding of positions may move a speckle grain's border.
    for (std::size_t i = 0; i < bent.pixels.size(); ++i) {
      differing += std::abs(int{bent.pixels[i]} - int{moved.pixels[i]}) > 1;
    }
    EXPECT_LT(differing, static_cast<int>(bent.pixels.size() / 200));
  }
}

TEST(BeamBend, TheSameBitsWithAnyNumberOfThreads) {
  const volume::CtVolume ct = RampVolume(ObliqueGeometry());
  const Moved rest(
      [](const Eigen::Vector3d& x) -> Eigen::Vector3d {
        return x + Eigen::Vector3d(std::sin(x[1]), 0.1 * x[0], 0.0);
      },
      1.0);
  CtSliceRenderer renderer(ct, image::ImageGeometry{.width_px = 300, .height_px = 200}, 2.0);
  const Eigen::Isometry3d pose(Eigen::Translation3d(0, 40, 20));
  image::GrayImage one, many;
  renderer.Render(pose, std::nullopt, one, 1, &rest);
  for (const int threads : {2, 5}) {
    renderer.Render(pose, std::nullopt, many, threads, &rest);
    EXPECT_EQ(one.pixels, many.pixels) << threads;
  }
}

}  // namespace
}  // namespace acus::slicing
