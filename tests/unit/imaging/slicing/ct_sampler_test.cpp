#include "acus/imaging/slicing/ct_sampler.h"

#include <cstring>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <limits>

#include "acus/base/core/error.h"
#include "acus/base/core/random.h"

namespace acus::slicing {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

/// A volume with oblique axes, so that a mixed-up axis or a missing transform cannot pass.
volume::Geometry CtSamplerObliqueGeometry() {
  volume::Geometry g;
  g.size = {40, 33, 27};
  g.spacing_mm = {0.7, 0.9, 1.6};
  g.origin_mm = {-12.0, 30.0, 5.0};
  g.direction = Eigen::AngleAxisd(0.4, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  return g;
}

/// hu = 10 i - 7 j + 3 k: trilinear interpolation reproduces it exactly, anywhere inside.
double Ramp(const Eigen::Vector3d& index) {
  return 10.0 * index[0] - 7.0 * index[1] + 3.0 * index[2];
}

volume::CtVolume CtSamplerRampVolume(const volume::Geometry& g) {
  volume::CtVolume ct(g);
  for (int k = 0; k < g.size[2]; ++k) {
    for (int j = 0; j < g.size[1]; ++j) {
      for (int i = 0; i < g.size[0]; ++i) {
        ct.At(i, j, k) = static_cast<std::int16_t>(Ramp({1.0 * i, 1.0 * j, 1.0 * k}));
      }
    }
  }
  return ct;
}

acoustics::ScanGrid SmallGrid(int width, int height) {
  return acoustics::ScanGridOf(image::ImageGeometry{
      .width_px = width, .height_px = height, .lateral_mm_per_px = 0.37, .axial_mm_per_px = 0.41});
}

BeamImage SampleGrid(const CtSampler& sampler, const acoustics::ScanGrid& grid,
                     const Eigen::Isometry3d& pose, int num_threads = 1) {
  BeamLines lines;
  BeamImage hu;
  sampler.PlaceLines(grid, pose, lines);
  hu.Resize(grid.lines(), grid.samples);
  sampler.Sample(lines, BeamBend(), hu, num_threads);
  return hu;
}

/// The middle of the volume, turned in every direction.
Eigen::Isometry3d ObliquePose(const volume::Geometry& g) {
  const Eigen::Vector3d middle = 0.5 * (g.size - 1).cast<double>();
  return Eigen::Translation3d(g.ct_from_index() * middle) *
         Eigen::AngleAxisd(1.1, Eigen::Vector3d(-2, 1, 0.5).normalized());
}

TEST(CtSampler, ReproducesALinearFieldOnAnObliquePlane) {
  const volume::Geometry g = CtSamplerObliqueGeometry();
  const volume::CtVolume ct = CtSamplerRampVolume(g);
  const CtSampler sampler(ct);
  const acoustics::ScanGrid grid = SmallGrid(37, 70);
  const Eigen::Isometry3d pose = ObliquePose(g);
  const BeamImage hu = SampleGrid(sampler, grid, pose);
  int inside = 0;
  for (int line = 0; line < grid.lines(); ++line) {
    for (int k = 0; k < grid.samples; ++k) {
      const Eigen::Vector2d at = grid.start_mm[line] + k * grid.step_mm * grid.direction[line];
      const Eigen::Vector3d index = g.index_from_ct() * (pose * Eigen::Vector3d(at.x(), at.y(), 0));
      if ((index.array() < 0.01).any() || (index.array() > g.size.cast<double>() - 1.01).any())
        continue;
      ++inside;
      EXPECT_NEAR(hu.row(k)[line], Ramp(index), 2e-3) << "line " << line << ", sample " << k;
    }
  }
  EXPECT_GT(inside, 1000);
}

TEST(CtSampler, AgreesWithItsSlowTwinOnRandomVoxelsAndBeyondTheBorder) {
  volume::CtVolume ct(CtSamplerObliqueGeometry());
  RandomStream random(3, "voxels");
  for (auto& v : ct.voxels) v = static_cast<std::int16_t>(random.Uniform(-1000.0, 2000.0));
  const CtSampler sampler(ct);
  const acoustics::ScanGrid grid = SmallGrid(150, 150);
  Eigen::Isometry3d pose = ObliquePose(ct.geometry);
  pose.translate(Eigen::Vector3d(0.0, -25.0, 0.0));
  const BeamImage hu = SampleGrid(sampler, grid, pose);
  int outside = 0;
  for (int line = 0; line < grid.lines(); ++line) {
    for (int k = 0; k < grid.samples; ++k) {
      const Eigen::Vector2d at = grid.start_mm[line] + k * grid.step_mm * grid.direction[line];
      const double expected = sampler.At(pose * Eigen::Vector3d(at.x(), at.y(), 0.0));
      if (expected == CtSampler::kOutsideHu) ++outside;
      EXPECT_NEAR(hu.row(k)[line], expected, 0.1);
    }
  }
  EXPECT_GT(outside, 1000);
  EXPECT_LT(outside, 22000);
}

TEST(CtSampler, AVoxelReachesHalfASpacingBeyondItsCentre) {
  volume::Geometry g;
  g.size = {4, 4, 4};
  const volume::CtVolume ct(g, 77);
  const CtSampler sampler(ct);
  EXPECT_EQ(sampler.At({-0.49, 1, 1}), 77.0);
  EXPECT_EQ(sampler.At({-0.51, 1, 1}), -1024.0);
  EXPECT_EQ(sampler.At({1, 1, 3.49}), 77.0);
  EXPECT_EQ(sampler.At({1, 1, 3.51}), -1024.0);
}

TEST(CtSampler, ASingleSliceIsASlabOfOneVoxel) {
  volume::Geometry g;
  g.size = {8, 8, 1};
  g.spacing_mm = {1, 1, 2};
  const volume::CtVolume ct(g, 50);
  const CtSampler sampler(ct);
  const acoustics::ScanGrid grid = SmallGrid(16, 10);
  for (const auto& [z_mm, expected] :
       {std::pair{-1.01, -1024.0F}, {-0.99, 50.0F}, {0.99, 50.0F}, {1.01, -1024.0F}}) {
    const Eigen::Isometry3d pose(Eigen::Translation3d(4.0, 2.0, z_mm));
    EXPECT_EQ(SampleGrid(sampler, grid, pose).row(3)[8], expected) << "z " << z_mm;
    EXPECT_EQ(sampler.At({4, 4, z_mm}), expected) << "z " << z_mm;
  }
}

TEST(CtSampler, GivesTheSameBitsWithOneAndTwoThreads) {
  volume::CtVolume ct(CtSamplerObliqueGeometry());
  RandomStream random(4, "voxels");
  for (auto& v : ct.voxels) v = static_cast<std::int16_t>(random.Uniform(-1000.0, 2000.0));
  const CtSampler sampler(ct);
  const acoustics::ScanGrid grid = SmallGrid(99, 200);
  const BeamImage one = SampleGrid(sampler, grid, ObliquePose(ct.geometry), 1);
  const BeamImage two = SampleGrid(sampler, grid, ObliquePose(ct.geometry), 2);
  for (int k = 0; k < grid.samples; ++k) {
    EXPECT_EQ(std::memcmp(one.row(k), two.row(k), sizeof(float) * 99), 0) << "row " << k;
  }
}

TEST(CtSampler, APlaneFarAwayIsAllOutside) {
  const volume::CtVolume ct(CtSamplerObliqueGeometry(), 40);
  const CtSampler sampler(ct);
  for (const double far_mm : {1e3, 1e9, 1e300}) {
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.translation() << far_mm, -far_mm, far_mm;
    const BeamImage hu = SampleGrid(sampler, SmallGrid(20, 20), pose);
    for (int line = 0; line < 20; ++line) EXPECT_EQ(hu.row(7)[line], -1024.0F) << far_mm;
  }
}

TEST(CtSampler, RefusesWhatItCannotSample) {
  const volume::CtVolume ct(CtSamplerObliqueGeometry(), 40);
  const CtSampler sampler(ct);
  BeamLines lines;
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.translation().y() = bad;
    EXPECT_THAT([&] { sampler.PlaceLines(SmallGrid(4, 4), pose, lines); },
                ThrowsMessage<InputError>(HasSubstr("not finite")));
  }
  const volume::CtVolume empty;
  EXPECT_THAT([&] { CtSampler{empty}; }, ThrowsMessage<InputError>(HasSubstr("no voxels")));
  volume::CtVolume short_of_voxels(CtSamplerObliqueGeometry());
  short_of_voxels.voxels.pop_back();
  EXPECT_THAT([&] { CtSampler{short_of_voxels}; },
              ThrowsMessage<InputError>(HasSubstr("its size says")));
  volume::CtVolume flat(CtSamplerObliqueGeometry());
  flat.geometry.spacing_mm[1] = 0.0;
  EXPECT_THAT([&] { CtSampler{flat}; }, ThrowsMessage<InputError>(HasSubstr("inverted")));
}

}  // namespace
}  // namespace acus::slicing
