// Rays bent by the speed of sound against closed forms: range, Snell's law, cylinders, edge
// shadows.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <memory>
#include <numbers>

#include "acus/imaging/acoustics/beam_width.h"
#include "acus/imaging/ultrasound/aperture/aperture_renderer.h"
#include "acus/imaging/ultrasound/beams/beam_march.h"
#include "acus/imaging/ultrasound/beams/refraction.h"
#include "support/beam_targets.h"

namespace acus::ultrasound {
namespace {

using testing_support::Clear;
using testing_support::FaceAt;
using testing_support::LabelledBlock;
using testing_support::TableOf;
using testing_support::TargetProbe;

constexpr double kScanner = acoustics::kScannerSpeedMPerS;
/// The face lies at (32, 10, 16) mm and looks along y.
constexpr double kFaceX = 32.0;
constexpr double kFaceY = 10.0;

struct RefractedBlock {
  RefractedBlock(double near_m_per_s, double far_m_per_s,
                 const std::function<bool(double, double)>& is_far)
      : labels(LabelledBlock({160, 160, 20}, 0.4, {{1, "near"}, {2, "far"}},
                             [&](double x, double y, double) {
                               return static_cast<volume::Label>(is_far(x, y) ? 2 : 1);
                             })),
        table(TableOf({{"near", Clear(near_m_per_s)}, {"far", Clear(far_m_per_s)}})) {}
  BeamTissue tissue() const { return {.labels = &labels, .acoustics = &table}; }

  volume::LabelMap labels;
  acoustics::TissueAcousticsTable table;
};

/// Everything that a traced image needs.
struct TracedRays {
  TracedRays(const RefractedBlock& block, const acoustics::Probe& with_probe, int directions)
      : probe(with_probe),
        rows(acoustics::BeamGridOf(probe)),
        rays(probe, rows, directions),
        refraction(
            SpeedVolume(block.tissue(), BeamMaterials(block.tissue(), BeamOptions(), probe, 1.0)),
            block.labels.geometry, probe, rows, rays) {
    refraction.Trace(FaceAt(kFaceX, kFaceY, 4.0), nullptr, 2);
  }
  int LineAt(double x_mm) const {
    return static_cast<int>(
        std::lround(x_mm / rows.LateralSpacingMm(0) + 0.5 * (rows.lines() - 1)));
  }
  int RowAt(double depth_mm) const {
    return static_cast<int>(std::lround(depth_mm / rows.step_mm));
  }
  Eigen::Vector2d Seen(double x_mm, double depth_mm) const {
    const int line = LineAt(x_mm);
    const int row = RowAt(depth_mm);
    const Eigen::Vector2d shift = refraction.ShiftMm(line, row);
    return rows.start_mm[static_cast<std::size_t>(line)] +
           Eigen::Vector2d(0.0, row * rows.step_mm) + shift;
  }
  float Gain(double x_mm, double depth_mm) const {
    std::vector<float> gain(static_cast<std::size_t>(rows.lines()));
    refraction.GainRow(RowAt(depth_mm), gain.data());
    return gain[static_cast<std::size_t>(LineAt(x_mm))];
  }

  acoustics::Probe probe;
  acoustics::ScanGrid rows;
  ApertureRays rays;
  Refraction refraction;
};

// One byte of speed is good for 0.05 %.
TEST(UltrasoundRefraction, RangeFollowsTheSpeed) {
  for (const double speed : {1450.0, 1540.0, 1620.0}) {
    const RefractedBlock block(speed, speed, [](double, double) { return false; });
    const TracedRays traced(block, TargetProbe(), 13);
    for (const double depth_mm : {10.0, 25.0, 40.0}) {
      for (const double x_mm : {-8.0, 0.0, 8.0}) {
        const Eigen::Vector2d seen = traced.Seen(x_mm, depth_mm);
        const double row_mm = traced.RowAt(depth_mm) * traced.rows.step_mm;
        EXPECT_NEAR(seen.y(), row_mm * speed / kScanner, 2e-3 * row_mm) << speed;
        // Where the aperture ends at the face's end, its middle lies beside the line.
        if (x_mm == 0.0) {
          EXPECT_NEAR(seen.x(), 0.0, 1e-3);
        }
      }
    }
  }
}

// A plane at 20 mm, turned by an angle: Snell's law, and the speeds along both parts.
TEST(UltrasoundRefraction, AnObliquePlaneBendsLinesBySnellsLaw) {
  for (const auto& [near, far] : {std::pair{1450.0, 1580.0}, std::pair{1580.0, 1450.0}}) {
    for (const double degrees : {10.0, 25.0, 40.0}) {
      const double turn = degrees * std::numbers::pi / 180.0;
      const Eigen::Vector2d normal(std::sin(turn), std::cos(turn));
      const Eigen::Vector2d on_plane(0.0, 20.0);
      const RefractedBlock block(near, far, [&](double x, double y) {
        return (Eigen::Vector2d(x - kFaceX, y - kFaceY) - on_plane).dot(normal) > 0.0;
      });
      const TracedRays traced(block, TargetProbe(), 1);
      for (const double x_mm : {-4.0, 0.0, 4.0}) {
        const double line_x =
            traced.rows.start_mm[static_cast<std::size_t>(traced.LineAt(x_mm))].x();
        const Eigen::Vector2d start(line_x, 0.0);
        const Eigen::Vector2d along(0.0, 1.0);
        const double before_mm = (on_plane - start).dot(normal) / along.dot(normal);
        const Eigen::Vector3d bent =
            Refracted({0.0, 1.0, 0.0}, {normal.x(), normal.y(), 0.0}, far / near);
        const double depth_mm = traced.RowAt(39.0) * traced.rows.step_mm;
        const double after_mm = (depth_mm - before_mm * kScanner / near) * far / kScanner;
        const Eigen::Vector2d expected = start + before_mm * along + after_mm * bent.head<2>();
        const Eigen::Vector2d seen = traced.Seen(x_mm, depth_mm);
        // Bent by up to 1.6 mm. The voxels' stairs turn the smoothed plane by less than half a
        // degree: 0.1 mm.
        EXPECT_NEAR((seen - expected).norm(), 0.0, 0.12) << near << " " << degrees << " " << x_mm;
      }
    }
  }
}

// A ray that passes the axis of a cylinder at b turns by 2 (i - r) towards it, sin i = b / R and
// sin r = c2 b / (c1 R).
TEST(UltrasoundRefraction, ACylinderIsALens) {
  constexpr double kRadius = 6.0;
  constexpr double kAxisDepth = 16.0;
  for (const double speed : {1450.0, 1620.0}) {
    const RefractedBlock block(kScanner, speed, [&](double x, double y) {
      return std::hypot(x - kFaceX, y - kFaceY - kAxisDepth) < kRadius;
    });
    const TracedRays traced(block, TargetProbe(), 1);
    for (const double x_mm : {-3.6, -2.4, -1.2, 1.2, 2.4, 3.6}) {
      const double b = traced.rows.start_mm[static_cast<std::size_t>(traced.LineAt(x_mm))].x();
      const double incidence = std::asin(b / kRadius);
      const double refracted = std::asin(b / kRadius * speed / kScanner);
      const double turn = 2.0 * (incidence - refracted);
      // Leaves the cylinder at the angle 2 r - i behind the axis, as seen from it.
      const double leaves = 2.0 * refracted - incidence;
      const double x = kRadius * std::sin(leaves);
      const double y = kAxisDepth + kRadius * std::cos(leaves);
      const double before = (kAxisDepth - kRadius * std::cos(incidence)) +
                            2.0 * kRadius * std::cos(refracted) * kScanner / speed;
      const double depth_mm = traced.RowAt(38.0) * traced.rows.step_mm;
      const double beyond = depth_mm - before;
      const Eigen::Vector2d expected(x - beyond * std::sin(turn), y + beyond * std::cos(turn));
      // A tenth of the displacement: the smoothed rim of 1 mm bends less sharply than a sharp one.
      const double displaced = std::abs(expected.x() - b);
      EXPECT_GT(displaced, 0.3);
      EXPECT_NEAR(traced.Seen(x_mm, depth_mm).x(), expected.x(), 0.1 + 0.1 * displaced)
          << speed << " " << b;
      EXPECT_NEAR(traced.Seen(x_mm, depth_mm).y(), expected.y(), 0.15) << speed << " " << b;
    }
  }
}

// Behind the rim of a cyst the rays of the aperture part, and behind its middle and beside it they
// do not: a shadow lies where the straight lines touch the rim, and it is gone without contrast.
TEST(UltrasoundRefraction, EdgesOfACystThrowShadows) {
  for (const double speed : {1480.0, 1600.0}) {
    const RefractedBlock block(kScanner, speed, [&](double x, double y) {
      return std::hypot(x - kFaceX, y - kFaceY - 12.0) < 5.0;
    });
    const TracedRays traced(block, TargetProbe(), 13);
    const auto lowest_at = [&](double depth_mm, double sign) {
      double best = 0.0;
      for (double x = 0.0; x < 11.0; x += 0.2) {
        if (traced.Gain(sign * x, depth_mm) < traced.Gain(sign * best, depth_mm)) best = x;
      }
      return best;
    };
    for (const double sign : {-1.0, 1.0}) {
      const double at = lowest_at(22.0, sign);
      // The rays that touch the rim turn by up to acos of the ratio of speeds, 16 degrees: by
      // 1.4 mm over the 5 mm behind the cyst's middle half.
      EXPECT_NEAR(at, 5.0, 1.4) << speed << " " << traced.Gain(sign * at, 22.0) << " "
                                << traced.Gain(0.0, 22.0) << " " << traced.Gain(sign * 9.5, 22.0);
      EXPECT_LT(traced.Gain(sign * at, 22.0), 0.85) << speed;
      EXPECT_GT(traced.Gain(0.0, 22.0), 0.93) << speed;
      EXPECT_GT(traced.Gain(sign * 9.5, 22.0), 0.97) << speed;
    }
  }
  const RefractedBlock even(kScanner, kScanner, [](double x, double y) { return x * y > 900.0; });
  const TracedRays traced(even, TargetProbe(), 13);
  for (double x = -12.0; x <= 12.0; x += 1.0) EXPECT_NEAR(traced.Gain(x, 30.0), 1.0, 1e-5);
}

TEST(UltrasoundRefraction, ImagesShowRangeAtTheScannersSpeed) {
  acoustics::TissueAcousticsTable table =
      TableOf({{"near", Clear(1450.0, 1.5)}, {"far", Clear(1450.0, 1.7)}});
  const volume::LabelMap labels = LabelledBlock(
      {128, 128, 40}, 0.5, {{1, "near"}, {2, "far"}},
      [](double, double y, double) { return static_cast<volume::Label>(y > 40.0 ? 2 : 1); });
  ApertureOptions options;
  options.speckle = options.texture = options.clutter = options.noise = options.ring_down = false;
  options.rough_layer_mm = 0.0;
  for (const bool refraction : {false, true}) {
    options.refraction = refraction;
    ApertureRenderer renderer({.labels = &labels, .acoustics = &table}, TargetProbe(), options);
    image::GrayImage image;
    image::GrayImage again;
    renderer.Render(FaceAt(32.0, 10.0, 10.0), {}, image, 1);
    renderer.Render(FaceAt(32.0, 10.0, 10.0), {}, again, 4);
    EXPECT_EQ(image.pixels, again.pixels);
    const slicing::BeamImage& envelope = renderer.envelope();
    int best = 0;
    for (int k = 0; k < renderer.grid().samples; ++k) {
      if (envelope.row(k)[64] > envelope.row(best)[64]) best = k;
    }
    EXPECT_NEAR(best * 0.1, refraction ? 30.0 * kScanner / 1450.0 : 30.0, 0.15);
  }
}

}  // namespace
}  // namespace acus::ultrasound
