#include "acus/imaging/fluoroscopy/fluoroscope.h"

#include <cmath>
#include <filesystem>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <numbers>
#include <utility>
#include <vector>

#include "acus/base/config/json_file.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "support/fuzz.h"
#include "support/instruction_sets.h"
#include "support/temporary_folder.h"

namespace acus::fluoroscopy {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

constexpr double kPi = std::numbers::pi;

/// A cube of voxels about the origin of CT space.
volume::CtVolume Cube(int voxels, double spacing_mm, std::int16_t fill = -1000) {
  volume::Geometry g;
  g.size = {voxels, voxels, voxels};
  g.spacing_mm = {spacing_mm, spacing_mm, spacing_mm};
  g.origin_mm = Eigen::Vector3d::Constant(-0.5 * (voxels - 1) * spacing_mm);
  return volume::CtVolume(g, fill);
}

/// A ball of water in air. Voxels on its surface hold the share of their volume inside.
volume::CtVolume Ball(int voxels, double spacing_mm, double radius_mm) {
  volume::CtVolume ct = Cube(voxels, spacing_mm);
  const auto& g = ct.geometry;
  constexpr int kSub = 4;
  for (int k = 0; k < voxels; ++k) {
    for (int j = 0; j < voxels; ++j) {
      for (int i = 0; i < voxels; ++i) {
        const Eigen::Vector3d middle = g.ct_from_index() * Eigen::Vector3d(i, j, k);
        if (std::abs(middle.norm() - radius_mm) > spacing_mm) {
          if (middle.norm() < radius_mm) ct.At(i, j, k) = 0;
          continue;
        }
        int inside = 0;
        for (int s = 0; s < kSub * kSub * kSub; ++s) {
          const Eigen::Array3d sub(s % kSub, s / kSub % kSub, s / (kSub * kSub));
          const Eigen::Vector3d p = middle.array() + ((sub + 0.5) / kSub - 0.5) * spacing_mm;
          inside += p.norm() < radius_mm;
        }
        ct.At(i, j, k) = static_cast<std::int16_t>(-1000 + 1000 * inside / (kSub * kSub * kSub));
      }
    }
  }
  return ct;
}

CArm SmallArm() {
  CArm c_arm;
  c_arm.width_px = 128;
  c_arm.height_px = 96;
  c_arm.detector_width_mm = 160;
  c_arm.detector_height_mm = 120;
  c_arm.detail = 1;
  c_arm.window_high = 5;
  return c_arm;
}

CArmPose Pose(double lao_deg, double cranial_deg) {
  return {Eigen::Vector3d::Zero(), lao_deg * kPi / 180, cranial_deg * kPi / 180};
}

/// Length of the ray to a pixel inside a box of half edges `half_mm` about the origin.
double InBoxMm(const CArmGeometry& g, int c, int r, double half_mm) {
  const Eigen::Vector3d d = (g.PixelInCtMm(c, r) - g.source_in_ct_mm()).normalized();
  double begin = 0;
  double end = 1e9;
  for (int a = 0; a < 3; ++a) {
    const double t0 = (-half_mm - g.source_in_ct_mm()[a]) / d[a];
    const double t1 = (half_mm - g.source_in_ct_mm()[a]) / d[a];
    begin = std::max(begin, std::min(t0, t1));
    end = std::min(end, std::max(t0, t1));
  }
  return std::max(0.0, end - begin);
}

TEST(Fluoroscope, ARayThroughABlockOfWaterSumsItsLength) {
  const volume::CtVolume ct = Cube(100, 1.0, 0);  // 100 mm of water.
  const CArm c_arm = SmallArm();
  for (const CArmPose& pose : {Pose(0, 0), Pose(30, 0), Pose(-40, 25), Pose(90, 0), Pose(44, 35)}) {
    Fluoroscope scope(ct, c_arm, pose);
    image::GrayImage image;
    scope.Render({}, image);
    int compared = 0;
    for (int r = 0; r < 96; r += 5) {
      for (int c = 0; c < 128; c += 7) {
        const double length_mm = InBoxMm(scope.geometry(), c, r, 50.0);
        if (length_mm < 80.0) continue;  // Grazing rays are short.
        EXPECT_NEAR(scope.Sum(c, r), 0.0206 * length_mm, 0.005 * 0.0206 * length_mm)
            << c << " " << r;
        ++compared;
      }
    }
    EXPECT_GT(compared, 100);
  }
}

TEST(Fluoroscope, ARayThroughABallSumsItsChordAtEveryDetail) {
  const volume::CtVolume ct = Ball(176, 0.5, 40.0);
  for (const int detail : {1, 2, 4}) {
    CArm c_arm = SmallArm();
    c_arm.detail = detail;
    // Voxels of 2 mm round off a ball of 80 mm.
    const double tolerance = detail == 4 ? 0.01 : 0.005;
    for (const CArmPose& pose : {Pose(0, 0), Pose(35, -30), Pose(-90, 0), Pose(10, 80)}) {
      Fluoroscope scope(ct, c_arm, pose);
      image::GrayImage image;
      scope.Render({}, image);
      for (int r = 0; r < 96; r += 3) {
        for (int c = 0; c < 128; c += 3) {
          const Eigen::Vector3d s = scope.geometry().source_in_ct_mm();
          const Eigen::Vector3d d = (scope.geometry().PixelInCtMm(c, r) - s).normalized();
          const double beside_mm = (s - s.dot(d) * d).norm();
          if (beside_mm > 25.0) continue;
          const double chord_mm = 2.0 * std::sqrt(1600.0 - beside_mm * beside_mm);
          EXPECT_NEAR(scope.Sum(c, r) / (0.0206 * chord_mm), 1.0, tolerance)
              << "detail " << detail << " at " << c << " " << r;
        }
      }
    }
  }
}

TEST(Fluoroscope, MagnifiesBySourceDetectorOverSourceObject) {
  const CArm c_arm = SmallArm();
  const CArmGeometry g(c_arm, Pose(25, 15));
  const Eigen::Vector3d across(std::cos(25 * kPi / 180), std::sin(25 * kPi / 180), 0);
  for (const double nearer_mm : {-100.0, 0.0, 150.0}) {
    const Eigen::Vector3d at = -nearer_mm * g.direction_in_ct();
    const double shown_mm =
        (g.Project(at + 10.0 * across) - g.Project(at - 10.0 * across)).norm() * g.mm_per_px();
    EXPECT_NEAR(shown_mm / 20.0, 1000.0 / (600.0 - nearer_mm), 1e-9);
  }
  // The isocentre is in the middle of the image.
  EXPECT_NEAR((g.Project({0, 0, 0}) - Eigen::Vector2d(63.5, 47.5)).norm(), 0.0, 1e-9);
  EXPECT_FALSE(g.Project(-700 * g.direction_in_ct()).allFinite());
}

TEST(Fluoroscope, AnglesAndSidesAreThoseOfTheClinic) {
  const CArm c_arm = SmallArm();
  // LPS: +x left, +y back, +z head. At 0, 0 the detector is in front of the patient.
  EXPECT_NEAR(
      (CArmGeometry(c_arm, Pose(0, 0)).direction_in_ct() - Eigen::Vector3d(0, -1, 0)).norm(), 0,
      1e-12);
  EXPECT_NEAR(
      (CArmGeometry(c_arm, Pose(90, 0)).direction_in_ct() - Eigen::Vector3d(1, 0, 0)).norm(), 0,
      1e-12);
  EXPECT_GT(CArmGeometry(c_arm, Pose(0, 30)).direction_in_ct().z(), 0.4);
  const CArmGeometry front(c_arm, Pose(0, 0));
  EXPECT_GT(front.Project({10, 0, 0}).x(), 63.5);  // The patient's left is on the right.
  EXPECT_LT(front.Project({0, 0, 10}).y(), 47.5);  // His head is up.
}

TEST(Fluoroscope, AnIsocentreBesideTheOriginMovesTheImage) {
  CArmPose pose = Pose(20, -10);
  pose.isocentre_in_ct_mm = {12, -7, 30};
  const CArmGeometry g(SmallArm(), pose);
  EXPECT_NEAR((g.Project({12, -7, 30}) - Eigen::Vector2d(63.5, 47.5)).norm(), 0.0, 1e-9);
  const Eigen::Vector2d px(17.25, 80.5);
  const Eigen::Vector3d on_detector = g.ct_from_image() * Eigen::Vector3d(px.x(), px.y(), 0);
  EXPECT_NEAR((g.Project(on_detector) - px).norm(), 0.0, 1e-9);
}

TEST(Fluoroscope, TheNeedleThrowsItsShadowWhereItIsProjected) {
  const volume::CtVolume ct = Cube(50, 2.0, 0);
  CArm c_arm = SmallArm();
  c_arm.width_px = c_arm.height_px = 256;
  for (const CArmPose& pose : {Pose(0, 0), Pose(-35, 20), Pose(90, 0)}) {
    Fluoroscope scope(ct, c_arm, pose);
    image::NeedleInImage needle;
    needle.tip_in_ct_mm = {5, 3, -8};
    needle.axis_in_ct = Eigen::Vector3d(0.3, -0.5, -0.8).normalized();
    needle.length_mm = 40;
    needle.radius_mm = 0.8;
    image::GrayImage without, with;
    scope.Render({}, without);
    std::vector<float> before;
    for (int p = 0; p < 256 * 256; ++p) before.push_back(scope.Sum(p % 256, p / 256));
    scope.Render(needle, with);
    const Eigen::Vector2d tip = scope.geometry().Project(needle.tip_in_ct_mm);
    const Eigen::Vector2d hub =
        scope.geometry().Project(needle.tip_in_ct_mm - 40 * needle.axis_in_ct);
    const Eigen::Vector2d along = (hub - tip).normalized();
    const double width_px = 2 * 0.8 * 1.7 / scope.geometry().mm_per_px();
    double mass = 0, beside = 0, first = 1e9;
    for (int p = 0; p < 256 * 256; ++p) {
      const double added = scope.Sum(p % 256, p / 256) - before[static_cast<std::size_t>(p)];
      const Eigen::Vector2d from_tip = Eigen::Vector2d(p % 256, p / 256) - tip;
      const double off = from_tip.x() * along.y() - from_tip.y() * along.x();
      if (added <= 0.3) continue;
      EXPECT_LT(std::abs(off), 0.5 * width_px + 1.5);
      mass += added;
      beside += added * off;
      first = std::min(first, from_tip.dot(along));
    }
    ASSERT_GT(mass, 10.0);
    EXPECT_LT(std::abs(beside / mass), 0.2);  // Pixels: the middle of the shadow is on the line.
    EXPECT_NEAR(first, 0.0, 1.0);             // And it ends at the tip.
  }
}

TEST(Fluoroscope, AcrossTheNeedleTheMetalIsAsThickAsTheNeedle) {
  const volume::CtVolume ct = Cube(20, 2.0);
  CArm c_arm = SmallArm();
  c_arm.detector_width_mm = c_arm.detector_height_mm = 6.4;
  c_arm.width_px = c_arm.height_px = 64;
  Fluoroscope scope(ct, c_arm, Pose(0, 0));
  image::NeedleInImage needle;
  needle.axis_in_ct = {0, 0, 1};
  needle.tip_in_ct_mm = {0, 0, 20};
  needle.length_mm = 40;
  needle.radius_mm = 1.0;
  image::GrayImage image;
  scope.Render(needle, image);
  // In the middle: 2 mm of metal and 40 mm of air.
  EXPECT_NEAR(scope.Sum(32, 32), 2.0 * 0.95, 0.01);
  // Half a radius beside it: sqrt(3) mm.
  const int half = static_cast<int>(std::lround(scope.geometry().Project({0.5, 0, 0}).x()));
  const double x_mm = (half - 31.5) * 0.1 * 600 / 1000;
  EXPECT_NEAR(scope.Sum(half, 32), 2.0 * std::sqrt(1 - x_mm * x_mm) * 0.95, 0.02);
}

TEST(Fluoroscope, ABentNeedleIsShownBent) {
  const volume::CtVolume ct = Cube(20, 2.0);
  Fluoroscope scope(ct, SmallArm(), Pose(0, 0));
  image::NeedleInImage needle;
  needle.radius_mm = 0.8;
  needle.length_mm = 1e3;  // Not read.
  for (int n = 0; n <= 20; ++n) needle.shape.Add({0.02 * n * n, 0, 2.0 * n - 20});
  image::GrayImage image;
  scope.Render(needle, image);
  const Eigen::Vector2d hub = scope.geometry().Project(needle.shape.At(20));
  const Eigen::Vector2d middle = scope.geometry().Project(needle.shape.At(10));
  const auto sum = [&](const Eigen::Vector2d& p) {
    return scope.Sum(static_cast<int>(std::lround(p.x())), static_cast<int>(std::lround(p.y())));
  };
  EXPECT_GT(sum(middle), 0.5);
  EXPECT_GT(sum(hub + Eigen::Vector2d(0, 2)), 0.5);
  EXPECT_EQ(sum(0.5 * (hub + scope.geometry().Project(needle.shape.At(0)))), 0.0F);  // The chord.
}

TEST(Fluoroscope, ChordsOfCylindersAreExact) {
  const Eigen::Vector3d from(0, 0, 0), to(0, 0, 10);
  EXPECT_DOUBLE_EQ(CylinderChordMm({-50, 0, 5}, {1, 0, 0}, from, to, 2.0), 4.0);
  EXPECT_NEAR(CylinderChordMm({-50, 1, 5}, {1, 0, 0}, from, to, 2.0), 2 * std::sqrt(3.0), 1e-12);
  EXPECT_EQ(CylinderChordMm({-50, 2.1, 5}, {1, 0, 0}, from, to, 2.0), 0.0);
  EXPECT_EQ(CylinderChordMm({-50, 0, 11}, {1, 0, 0}, from, to, 2.0), 0.0);
  EXPECT_DOUBLE_EQ(CylinderChordMm({0.5, 0, -50}, {0, 0, 1}, from, to, 2.0), 10.0);
  EXPECT_EQ(CylinderChordMm({3, 0, -50}, {0, 0, 1}, from, to, 2.0), 0.0);
  EXPECT_EQ(CylinderChordMm({50, 0, 5}, {1, 0, 0}, from, to, 2.0), 0.0);  // Behind the source.
  EXPECT_EQ(CylinderChordMm({-50, 0, 5}, {1, 0, 0}, from, from, 2.0), 0.0);
  // At 45 degrees through the side: 4 sqrt(2).
  const Eigen::Vector3d d = Eigen::Vector3d(1, 0, 1).normalized();
  EXPECT_NEAR(CylinderChordMm(Eigen::Vector3d(0, 0, 5) - 30 * d, d, from, to, 2.0),
              4 * std::sqrt(2.0), 1e-12);
}

class Shift : public slicing::RestMap {
 public:
  explicit Shift(Eigen::Vector3d by_mm, double until_z_mm = 1e9)
      : by_mm_(std::move(by_mm)), until_z_mm_(until_z_mm) {}
  Eigen::Vector3d RestInCtMm(const Eigen::Vector3d& place,
                             const Eigen::Vector3d&) const noexcept override {
    return place.z() < until_z_mm_ ? Eigen::Vector3d(place - by_mm_) : place;
  }
  double SpacingMm() const noexcept override { return 4.0; }

 private:
  Eigen::Vector3d by_mm_;
  double until_z_mm_;
};

TEST(Fluoroscope, TissueThatMovesIsSeenWhereItIsNow) {
  const volume::CtVolume ct = Ball(96, 1.0, 30.0);
  Fluoroscope scope(ct, SmallArm(), Pose(0, 0));
  image::GrayImage image;
  const auto middle_px = [&] {
    Eigen::Vector2d sum(0, 0);
    double mass = 0;
    for (int p = 0; p < 128 * 96; ++p) {
      sum += scope.Sum(p % 128, p / 128) * Eigen::Vector2d(p % 128, p / 128);
      mass += scope.Sum(p % 128, p / 128);
    }
    return std::pair<Eigen::Vector2d, double>(sum / mass, mass);
  };
  scope.Render({}, image);
  const auto [at_rest, mass_at_rest] = middle_px();
  const Shift shift({7, 0, -5});
  scope.Render({}, image, 1, &shift);
  const auto [moved, mass_moved] = middle_px();
  const Eigen::Vector2d expected =
      scope.geometry().Project({7, 0, -5}) - scope.geometry().Project({0, 0, 0});
  EXPECT_NEAR((moved - at_rest - expected).norm(), 0.0, 0.05);
  EXPECT_NEAR(mass_moved / mass_at_rest, 1.0, 0.002);
}

// Tiles of 16 x 8 rays: here one column and one row lie beyond the last whole tile.
TEST(Fluoroscope, TheLastColumnAndRowAreThere) {
  const volume::CtVolume ct = Cube(60, 1.0, 0);
  CArm c_arm = SmallArm();
  c_arm.width_px = 33;
  c_arm.height_px = 25;
  c_arm.detector_width_mm = 33;
  c_arm.detector_height_mm = 25;
  Fluoroscope scope(ct, c_arm, Pose(0, 0));
  image::GrayImage image;
  scope.Render({}, image);
  for (int r = 0; r < 25; ++r) {
    for (int c = 0; c < 33; ++c) {
      EXPECT_NEAR(scope.Sum(c, r), 0.0206 * InBoxMm(scope.geometry(), c, r, 30.0), 0.01)
          << c << " " << r;
    }
  }
}

TEST(Fluoroscope, TissueAtTheSidesOfTheVolumeMovesToo) {
  constexpr int kVoxels = 40;
  for (const int across : {0, 2}) {  // Axis of the CT; it moves along the other.
    for (const int from : {0, kVoxels - 3}) {
      volume::CtVolume rest = Cube(kVoxels, 1.0), now = Cube(kVoxels, 1.0);
      for (int n = 0; n < 3 * 8 * 8; ++n) {
        Eigen::Array3i v(12 + n / 3 % 8, 12 + n / 24, 12 + n / 3 % 8);
        v[across] = from + n % 3;
        rest.At(v[0], v[1], v[2]) = 1000;
        v[2 - across] += 5;
        now.At(v[0], v[1], v[2]) = 1000;
      }
      CArm c_arm = SmallArm();
      c_arm.detector_width_mm = 80;
      c_arm.detector_height_mm = 80;
      Fluoroscope moving(rest, c_arm, Pose(0, 0)), still(now, c_arm, Pose(0, 0));
      image::GrayImage image;
      still.Render({}, image);
      Eigen::Vector3d by_mm = Eigen::Vector3d::Zero();
      by_mm[2 - across] = 5.0;
      const Shift shift(by_mm);
      for (const int time : {1, 2}) {
        moving.Render({}, image, 1, &shift);
        double most = 0.0, largest = 0.0;
        for (int p = 0; p < 128 * 96; ++p) {
          const double sum = still.Sum(p % 128, p / 128);
          most = std::max(most, sum);
          largest = std::max(largest, std::abs(moving.Sum(p % 128, p / 128) - sum));
        }
        EXPECT_GT(most, 0.2);
        EXPECT_LT(largest, 0.01 * most) << "axis " << across << ", time " << time;
      }
    }
  }
}

// Only air is cut off, so that the image is the same; the three sides differ.
TEST(Fluoroscope, TissueMovesAlikeInACroppedVolume) {
  const volume::CtVolume whole = Ball(96, 1.0, 22.0);
  volume::Geometry g = whole.geometry;
  g.size = {96, 88, 80};
  volume::CtVolume cropped(g, std::int16_t{-1000});
  for (int k = 0; k < 80; ++k) {
    for (int j = 0; j < 88; ++j) {
      for (int i = 0; i < 96; ++i) cropped.At(i, j, k) = whole.At(i, j, k);
    }
  }
  const Shift part({5, 3, -4}, 2.0);
  Fluoroscope of_whole(whole, SmallArm(), Pose(20, 10));
  Fluoroscope of_cropped(cropped, SmallArm(), Pose(20, 10));
  image::GrayImage image;
  of_whole.Render({}, image, 1, &part);
  of_cropped.Render({}, image, 1, &part);
  double largest = 0.0;
  for (int p = 0; p < 128 * 96; ++p) {
    largest = std::max<double>(
        largest, std::abs(of_whole.Sum(p % 128, p / 128) - of_cropped.Sum(p % 128, p / 128)));
  }
  EXPECT_LT(largest, 1e-4 * of_whole.Sum(64, 48));
}

/// Moves what lies about `from_mm` as it is, and nothing else.
class MovedPart : public slicing::RestMap {
 public:
  MovedPart(Eigen::Vector3d from_mm, Eigen::Vector3d by_mm)
      : from_mm_(std::move(from_mm)), by_mm_(std::move(by_mm)) {}
  Eigen::Vector3d RestInCtMm(const Eigen::Vector3d& place,
                             const Eigen::Vector3d&) const noexcept override {
    return (place - from_mm_ - by_mm_).norm() < 14.0 ? Eigen::Vector3d(place - by_mm_) : place;
  }
  double SpacingMm() const noexcept override { return 4.0; }

 private:
  Eigen::Vector3d from_mm_, by_mm_;
};

TEST(Fluoroscope, OfTwoBallsTheOneThatMovesIsSeenWhereItIsNow) {
  // The three sides differ: none may stand for another.
  volume::Geometry g;
  g.size = {120, 96, 72};
  g.spacing_mm = {1, 1, 1};
  g.origin_mm = {-60, -48, -36};
  const auto balls = [&](const std::vector<Eigen::Vector3d>& middles) {
    volume::CtVolume ct(g, std::int16_t{-1000});
    for (int k = 0; k < g.size[2]; ++k) {
      for (int j = 0; j < g.size[1]; ++j) {
        for (int i = 0; i < g.size[0]; ++i) {
          const Eigen::Vector3d place = g.ct_from_index() * Eigen::Vector3d(i, j, k);
          for (const auto& middle : middles) {
            if ((place - middle).norm() < 6.0) ct.At(i, j, k) = 0;
          }
        }
      }
    }
    return ct;
  };
  const Eigen::Vector3d by_mm(5, -3, 2);
  image::GrayImage image;
  for (const Eigen::Vector3d& from :
       {Eigen::Vector3d(-36, 24, -16), Eigen::Vector3d(38, -22, 14), Eigen::Vector3d(8, 26, 12)}) {
    Fluoroscope moved(balls({from, -from}), SmallArm(), Pose(20, 10));
    Fluoroscope there(balls({from + by_mm, -from}), SmallArm(), Pose(20, 10));
    const MovedPart part(from, by_mm);
    moved.Render({}, image, 1, &part);
    there.Render({}, image);
    double largest = 0.0, sum = 0.0;
    for (int p = 0; p < 128 * 96; ++p) {
      const double truth = there.Sum(p % 128, p / 128);
      largest = std::max(largest, std::abs(moved.Sum(p % 128, p / 128) - truth));
      sum = std::max(sum, truth);
    }
    EXPECT_GT(sum, 0.0);
    EXPECT_LT(largest, 1e-4 * sum) << from.transpose();
  }
}

TEST(Fluoroscope, AMapThatMovesNothingGivesTheSameBitsAndTissueComesBack) {
  const volume::CtVolume ct = Ball(64, 1.0, 25.0);
  Fluoroscope scope(ct, SmallArm(), Pose(20, 10));
  image::GrayImage rest, still, moved, back;
  scope.Render({}, rest);
  const Shift none({0, 0, 0});
  scope.Render({}, still, 1, &none);
  EXPECT_EQ(rest.pixels, still.pixels);
  const Shift part({6, 0, 0}, 0.0);
  scope.Render({}, moved, 1, &part);
  EXPECT_NE(rest.pixels, moved.pixels);
  scope.Render({}, back, 1, &none);
  EXPECT_EQ(rest.pixels, back.pixels);
  scope.Render({}, moved, 1, &part);
  scope.Render({}, back);
  EXPECT_EQ(rest.pixels, back.pixels);
}

TEST(Fluoroscope, GivesTheSameBitsWithAnyThreadsAndInstructions) {
  const volume::CtVolume ct = Ball(64, 1.0, 25.0);
  const Shift part({3, 2, 1}, 5.0);
  image::NeedleInImage needle;
  needle.length_mm = 60;
  needle.radius_mm = 0.6;
  std::vector<image::GrayImage> images(1);
  Fluoroscope(ct, SmallArm(), Pose(20, 10)).Render(needle, images[0], 1, &part);
  for (const int threads : {2, 3}) {
    Fluoroscope(ct, SmallArm(), Pose(20, 10), threads)
        .Render(needle, images.emplace_back(), threads, &part);
  }
  testing_support::OnEveryInstructionSet([&](const char*) {
    Fluoroscope(ct, SmallArm(), Pose(20, 10)).Render(needle, images.emplace_back(), 1, &part);
  });
  for (const image::GrayImage& image : images) EXPECT_EQ(image.pixels, images[0].pixels);
}

TEST(Fluoroscope, GreyIsLogarithmicOrLinearAndEitherWayRound) {
  const volume::CtVolume ct = Cube(50, 2.0, 0);
  CArm c_arm = SmallArm();
  c_arm.window_low = 0.0;
  c_arm.window_high = 4.0;
  image::GrayImage image;
  Fluoroscope scope(ct, c_arm, Pose(0, 0));
  scope.Render({}, image);
  const double sum = scope.Sum(64, 48);
  EXPECT_NEAR(image.At(64, 48), 255 * (1 - sum / 4.0), 1.0);
  EXPECT_EQ(image.At(0, 0) == 255, scope.Sum(0, 0) == 0.0F);
  c_arm.dark_bone = false;
  Fluoroscope(ct, c_arm, Pose(0, 0)).Render({}, image);
  EXPECT_NEAR(image.At(64, 48), 255 * sum / 4.0, 1.0);
  c_arm.dark_bone = true;
  c_arm.scale = FluoroscopyScale::kLinear;
  Fluoroscope(ct, c_arm, Pose(0, 0)).Render({}, image);
  EXPECT_NEAR(image.At(64, 48), 255 * (std::exp(-sum) - std::exp(-4.0)) / (1 - std::exp(-4.0)),
              1.0);
}

TEST(Fluoroscope, TheWindowIsChosenFromThePatientAndTheNeedleIsDarker) {
  const volume::CtVolume ct = Ball(96, 1.0, 40.0);
  CArm c_arm = SmallArm();
  c_arm.window_high = 0.0;
  Fluoroscope scope(ct, c_arm, Pose(0, 0));
  EXPECT_GT(scope.window_low(), 0.05);
  EXPECT_NEAR(scope.window_high(), 1.15 * 80 * 0.0206, 0.05);
  image::NeedleInImage needle;
  needle.length_mm = 30;
  needle.radius_mm = 0.8;
  image::GrayImage image;
  scope.Render(needle, image);
  EXPECT_LT(image.At(63, 50), image.At(40, 48) - 20);
}

TEST(Fluoroscope, RaysBesideThePatientAndBeyondTheSourceAreEmpty) {
  const volume::CtVolume ct = Cube(10, 2.0, 0);
  CArm c_arm = SmallArm();
  CArmPose pose = Pose(0, 0);
  pose.isocentre_in_ct_mm = {500, 0, 0};
  Fluoroscope beside(ct, c_arm, pose);
  image::GrayImage image;
  beside.Render({}, image);
  EXPECT_EQ(*std::ranges::min_element(image.pixels), 255);
  c_arm.window_high = 0.0;
  EXPECT_THAT([&] { Fluoroscope(ct, c_arm, pose); },
              ThrowsMessage<InputError>(HasSubstr("no ray meets the patient")));
  // The source in the middle of the block: only what is in front of it counts.
  c_arm.window_high = 5;
  pose.isocentre_in_ct_mm = 600.0 * Eigen::Vector3d(0, -1, 0);
  Fluoroscope within(ct, c_arm, pose);
  within.Render({}, image);
  EXPECT_NEAR(within.Sum(64, 48), 10.0 * 0.0206, 1.5 * 0.0206);
}

TEST(CArm, ValuesOutOfRangeAreNamed) {
  const volume::CtVolume ct = Cube(4, 2.0, 0);
  const auto refuses = [&](auto change, const char* message) {
    CArm c_arm = SmallArm();
    CArmPose pose;
    change(c_arm, pose);
    EXPECT_THAT([&] { Fluoroscope(ct, c_arm, pose); },
                ThrowsMessage<InputError>(HasSubstr(message)));
  };
  refuses([](CArm& c, CArmPose&) { c.source_isocentre_mm = 1000; }, "between the two");
  refuses([](CArm& c, CArmPose&) { c.source_isocentre_mm = 0; }, "between the two");
  refuses([](CArm& c, CArmPose&) { c.width_px = 15; }, "pixels");
  refuses([](CArm& c, CArmPose&) { c.height_px = 4097; }, "pixels");
  refuses([](CArm& c, CArmPose&) { c.detector_width_mm = 0; }, "detector");
  refuses([](CArm& c, CArmPose&) { c.water_per_mm = 0; }, "attenuation");
  refuses([](CArm& c, CArmPose&) { c.metal_per_mm = -1; }, "attenuation");
  refuses([](CArm& c, CArmPose&) { c.detail = 3; }, "detail");
  refuses([](CArm& c, CArmPose&) { c.window_low = 6; }, "window");
  refuses([](CArm&, CArmPose& p) { p.lao_rad = std::nan(""); }, "pose");
  image::NeedleInImage needle;
  needle.tip_in_ct_mm.x() = std::nan("");
  image::GrayImage image;
  EXPECT_THROW(Fluoroscope(ct, SmallArm(), {}).Render(needle, image), InputError);
  EXPECT_THROW(Fluoroscope(volume::CtVolume(), SmallArm(), {}), InputError);
}

TEST(CArm, ThePresetIsReadAndDamagedFilesAreReadOrRefused) {
  const auto preset = std::filesystem::path(ACUS_SOURCE_DIR) / "configs/c_arms/mobile.json";
  const CArm c_arm = ReadCArm(preset);
  EXPECT_EQ(c_arm.source_detector_mm, 1000.0);
  EXPECT_EQ(c_arm.detail, 2);
  EXPECT_TRUE(c_arm.dark_bone);
  const testing_support::TemporaryFolder folder;
  const auto path = folder / "damaged.json";
  const auto read = [&] { ReadCArm(path); };
  EXPECT_GT(testing_support::ReadDamagedCopies(ReadTextFile(preset), path, 200, read), 50);
  auto document = config::ReadJson(preset);
  document["source_isocentre_mm"] = 1200;
  config::WriteJson(path, document);
  EXPECT_THAT(read, ThrowsMessage<InputError>(HasSubstr("damaged.json: C-arm: source")));
}

}  // namespace
}  // namespace acus::fluoroscopy
