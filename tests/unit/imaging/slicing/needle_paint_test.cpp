#include "acus/imaging/slicing/needle_paint.h"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>

#include "acus/base/core/error.h"

namespace acus::slicing {
namespace {

constexpr double kPx = 0.1;
constexpr int kSize = 401;

/// A black image of 40 mm x 40 mm; the probe's frame is the CT's.
struct Canvas {
  acoustics::ScanGrid grid = acoustics::ScanGridOf(image::ImageGeometry{
      .width_px = kSize, .height_px = kSize, .lateral_mm_per_px = kPx, .axial_mm_per_px = kPx});
  BeamImage hu;

  Canvas() {
    hu.Resize(kSize, kSize);
    for (int k = 0; k < kSize; ++k) std::fill_n(hu.row(k), kSize, 0.0F);
  }
  void Paint(const image::NeedleInImage& needle, double thickness_mm) {
    PaintNeedle(needle, Eigen::Isometry3d::Identity(), thickness_mm, grid, hu);
  }
  /// Area in mm^2, centroid and extent of what was painted.
  struct Blob {
    double area_mm2 = 0.0;
    Eigen::Vector2d centre_mm = Eigen::Vector2d::Zero();
    Eigen::Vector2d low_mm = Eigen::Vector2d::Constant(1e9);
    Eigen::Vector2d high_mm = Eigen::Vector2d::Constant(-1e9);
  };
  Blob Painted() const {
    Blob blob;
    int n = 0;
    for (int k = 0; k < kSize; ++k) {
      for (int l = 0; l < kSize; ++l) {
        if (hu.row(k)[l] != kNeedleHu) continue;
        const Eigen::Vector2d at(grid.start_mm[l].x(), k * kPx);
        blob.centre_mm += at;
        blob.low_mm = blob.low_mm.cwiseMin(at);
        blob.high_mm = blob.high_mm.cwiseMax(at);
        ++n;
      }
    }
    blob.area_mm2 = n * kPx * kPx;
    if (n > 0) blob.centre_mm /= n;
    return blob;
  }
};

image::NeedleInImage Needle(const Eigen::Vector3d& tip, const Eigen::Vector3d& axis, double length,
                            double radius) {
  return {.tip_in_ct_mm = tip,
          .axis_in_ct = axis.normalized(),
          .length_mm = length,
          .radius_mm = radius};
}

TEST(PaintNeedle, InThePlaneItIsAsLongAndWideAsItIs) {
  Canvas canvas;
  canvas.Paint(Needle({5, 20, 0}, {1, 0, 0}, 15, 0.65), 2.0);
  const auto blob = canvas.Painted();
  EXPECT_NEAR(blob.high_mm.x(), 5.0, kPx);
  EXPECT_NEAR(blob.low_mm.x(), 5.0 - 15.0 - 0.65, kPx);
  EXPECT_NEAR(blob.high_mm.y() - blob.low_mm.y(), 1.2, 1e-9);  // Centres within +-0.65 mm.
  EXPECT_NEAR(blob.centre_mm.y(), 20.0, 1e-9);
}

TEST(PaintNeedle, TheTipIsAPoint) {
  Canvas canvas;
  canvas.Paint(Needle({5, 20, 0}, {1, 0, 0}, 15, 0.6), 2.0);
  const auto width_at = [&](double x_mm) {
    int n = 0;
    for (int k = 0; k < kSize; ++k)
      n += canvas.hu.row(k)[200 + static_cast<int>(std::lround(x_mm / kPx))] == kNeedleHu;
    return n * kPx;
  };
  EXPECT_NEAR(width_at(5.0), kPx, 1e-9);
  EXPECT_NEAR(width_at(5.0 - 0.9), 0.6, 2 * kPx);  // Half of the taper of three radii.
  EXPECT_NEAR(width_at(5.0 - 3.0), 1.2, kPx);
  EXPECT_EQ(width_at(5.2), 0.0);
}

TEST(PaintNeedle, PerpendicularToThePlaneItIsOneDisc) {
  Canvas canvas;
  canvas.Paint(Needle({3, 12, 30}, {0, 0, 1}, 60, 0.8), 2.0);
  const auto blob = canvas.Painted();
  EXPECT_NEAR(blob.area_mm2, M_PI * 0.64, 0.1);
  EXPECT_NEAR((blob.centre_mm - Eigen::Vector2d(3, 12)).norm(), 0.0, 0.02);
}

TEST(PaintNeedle, OnlyThePartWithinTheSliceIsSeen) {
  // At 45 degrees through the plane at x = 0: within +-(1 + 0.3) mm of it, that is 2.6 mm of x.
  Canvas canvas;
  canvas.Paint(Needle({10, 20, 10}, {1, 0, 1}, 40, 0.3), 2.0);
  const auto blob = canvas.Painted();
  EXPECT_NEAR(blob.low_mm.x(), -1.3 - 0.3, kPx);
  EXPECT_NEAR(blob.high_mm.x(), 1.3 + 0.3, kPx);
}

TEST(PaintNeedle, ParallelToThePlaneItVanishesWhereItsSurfaceLeavesTheSlice) {
  for (const auto& [z_mm, seen] :
       {std::pair{1.29, true}, {1.31, false}, {-1.29, true}, {-1.31, false}}) {
    Canvas canvas;
    canvas.Paint(Needle({5, 20, z_mm}, {1, 0, 0}, 15, 0.3), 2.0);
    EXPECT_EQ(canvas.Painted().area_mm2 > 0.0, seen) << z_mm;
  }
}

TEST(PaintNeedle, AThinNeedleIsNotBrokenUp) {
  Canvas canvas;
  canvas.Paint(Needle({15, 35, 0}, {0.8, 0.6, 0}, 30, 0.01), 1.0);
  int columns = 0;
  for (int l = 0; l < kSize; ++l) {
    int n = 0;
    for (int k = 0; k < kSize; ++k) n += canvas.hu.row(k)[l] == kNeedleHu;
    columns += n > 0;
  }
  EXPECT_NEAR(columns * kPx, 24.0, 2 * kPx);
}

TEST(PaintNeedle, OutsideTheImageNothingIsDrawn) {
  for (const Eigen::Vector3d& tip :
       {Eigen::Vector3d(0, -1, 0), Eigen::Vector3d(-25, 20, 0), Eigen::Vector3d(1e12, 0, 0)}) {
    Canvas canvas;
    canvas.Paint(Needle(tip, {1, 0, 0}, 10, 0.5), 2.0);
    EXPECT_EQ(canvas.Painted().area_mm2, 0.0) << tip.transpose();
  }
}

TEST(PaintNeedle, ANeedleOfNoLengthIsAPoint) {
  Canvas canvas;
  canvas.Paint(Needle({0, 20, 0}, {0, 1, 0}, 0, 0.5), 2.0);
  EXPECT_LE(canvas.Painted().area_mm2, 5 * kPx * kPx);
}

/// A circular arc in the plane from the tip at (0, 35) towards the hub, turning to +x.
image::NeedleInImage Arc(double radius_of_bend_mm, double length_mm, int pieces) {
  image::NeedleInImage needle{.radius_mm = 0.5};
  for (int i = 0; i <= pieces; ++i) {
    const double angle = length_mm / radius_of_bend_mm * i / pieces;
    needle.shape.Add({radius_of_bend_mm * (1.0 - std::cos(angle)),
                      35.0 - radius_of_bend_mm * std::sin(angle), 0.0});
  }
  return needle;
}

TEST(PaintNeedle, ABentNeedleIsWhereItsShapeIs) {
  Canvas canvas;
  canvas.Paint(Arc(40.0, 30.0, 24), 1.0);
  const auto blob = canvas.Painted();
  // As much area as the straight needle: the length of the arc times its width, less the point.
  EXPECT_NEAR(blob.area_mm2, 30.0 * 1.0 - 0.5 * 1.5, 0.06 * 30.0);
  const double end = 30.0 / 40.0;
  EXPECT_NEAR(blob.low_mm.y(), 35.0 - 40.0 * std::sin(end), 0.6);
  EXPECT_NEAR(blob.high_mm.y(), 35.0, 2 * kPx);
  EXPECT_NEAR(blob.high_mm.x(), 40.0 * (1.0 - std::cos(end)), 0.6);
  // Every painted sample is within the shaft of the true arc, whose centre is (40, 35).
  for (int k = 0; k < kSize; ++k) {
    for (int l = 0; l < kSize; ++l) {
      if (canvas.hu.row(k)[l] != kNeedleHu) continue;
      const Eigen::Vector2d at(canvas.grid.start_mm[l].x(), k * kPx);
      EXPECT_NEAR((at - Eigen::Vector2d(40.0, 35.0)).norm(), 40.0, 0.5 + 0.01);
    }
  }
}

TEST(PaintNeedle, AStraightShapeIsTheStraightNeedle) {
  Canvas straight, in_pieces;
  straight.Paint(Needle({3, 30, 0}, {0.2, 1, 0}, 20, 0.6), 1.0);
  image::NeedleInImage needle = Needle({3, 30, 0}, {0.2, 1, 0}, 20, 0.6);
  for (int i = 0; i <= 10; ++i) {
    needle.shape.Add(needle.tip_in_ct_mm - 2.0 * i * needle.axis_in_ct);
  }
  in_pieces.Paint(needle, 1.0);
  EXPECT_NEAR(straight.Painted().area_mm2, in_pieces.Painted().area_mm2, 0.1);
  EXPECT_NEAR((straight.Painted().centre_mm - in_pieces.Painted().centre_mm).norm(), 0.0, 0.02);
}

TEST(PaintNeedle, OnlyTheBentPartInTheSliceIsSeen) {
  // Bends out of the plane: seen from the tip to where it is half a slice and a radius off.
  image::NeedleInImage needle{.radius_mm = 0.5};
  const double bend_mm = 50.0;
  for (int i = 0; i <= 60; ++i) {
    const double angle = 0.5 * i / bend_mm;
    needle.shape.Add({0.0, 35.0 - bend_mm * std::sin(angle), bend_mm * (1.0 - std::cos(angle))});
  }
  Canvas canvas;
  canvas.Paint(needle, 2.0);
  const double seen = std::acos(1.0 - 1.5 / bend_mm);  // Rises by 1 + 0.5 mm.
  EXPECT_NEAR(canvas.Painted().low_mm.y(), 35.0 - bend_mm * std::sin(seen) - 0.5, 0.4);
}

TEST(PaintNeedle, RefusesANeedleThatIsNone) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Canvas canvas;
  image::NeedleInImage needle = Needle({0, 20, 0}, {0, 1, 0}, 10, 0.5);
  image::NeedleInImage bent = Arc(40.0, 30.0, 8);
  bent.shape.point_mm[3].x() = std::nan("");
  EXPECT_THROW(Canvas().Paint(bent, 1.0), InputError);
  needle.tip_in_ct_mm.x() = nan;
  EXPECT_THROW(canvas.Paint(needle, 2.0), InputError);
  needle = Needle({0, 20, 0}, {0, 1, 0}, 10, 0.5);
  needle.axis_in_ct.setZero();
  EXPECT_THROW(canvas.Paint(needle, 2.0), InputError);
  EXPECT_THROW(canvas.Paint(Needle({0, 20, 0}, {0, 1, 0}, -1, 0.5), 2.0), InputError);
  EXPECT_THROW(canvas.Paint(Needle({0, 20, 0}, {0, 1, 0}, 1, -0.5), 2.0), InputError);
  EXPECT_THROW(canvas.Paint(Needle({0, 20, 0}, {0, 1, 0}, 1, nan), 2.0), InputError);
}

}  // namespace
}  // namespace acus::slicing
