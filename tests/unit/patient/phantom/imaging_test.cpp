#include "acus/patient/phantom/anatomy/imaging.h"

#include <cmath>
#include <gtest/gtest.h>

#include "acus/data/volume/labels.h"

namespace acus::phantom {
namespace {

using Eigen::Vector3d;
using volume::Geometry;

Anatomy Patient(std::uint64_t seed = 1) {
  BodySettings settings;
  settings.lesion_centre_mm = Vector3d(-88, -50, 115);
  return Anatomy(settings, seed);
}

Geometry GridAround(const Vector3d& centre, const Eigen::Array3i& size,
                    const Eigen::Array3d& spacing) {
  Geometry g;
  g.size = size;
  g.spacing_mm = spacing;
  g.origin_mm = centre - (0.5 * (size.cast<double>() - 1.0) * spacing).matrix();
  return g;
}

/// Distinct HU, so that mixtures can be told apart.
ScannerSettings Scanner(double psf, double noise, int supersampling = 2) {
  ScannerSettings settings;
  for (int m = 0; m < kNumMaterials; ++m) settings.hu[m] = -900.0 + 80.0 * m;
  settings.psf_sigma_mm = psf;
  settings.noise_sd_hu = noise;
  settings.supersampling = supersampling;
  return settings;
}

double Hu(const ScannerSettings& settings, Material m) {
  return settings.hu[static_cast<int>(m)];
}

TEST(RenderScan, LabelsAreExactAtVoxelCentres) {
  const Anatomy anatomy = Patient();
  const Geometry g = GridAround({0, 10, 0}, {70, 60, 12}, {2, 2, 3});
  const Scan scan = RenderScan(anatomy, g, Scanner(0.5, 10), {});
  for (int k = 0; k < g.size[2]; ++k) {
    for (int j = 0; j < g.size[1]; ++j) {
      for (int i = 0; i < g.size[0]; ++i) {
        ASSERT_EQ(scan.labels.At(i, j, k), anatomy.LabelAt(g.ct_from_index() * Vector3d(i, j, k)));
      }
    }
  }
  EXPECT_EQ(scan.labels.names.at(volume::LabelOf("bone")), "bone");
  EXPECT_FALSE(scan.labels.names.contains(volume::LabelOf("lung")));
}

TEST(RenderScan, GivesTheConfiguredMeanAndDeviationInsideATissue) {
  const ScannerSettings settings = Scanner(0.6, 12);
  const Geometry g = GridAround({-80, -30, 160}, {24, 24, 10}, {1, 1, 2});  // Liver and its veins.
  RunContext context;
  context.seed = 11;
  const Scan scan = RenderScan(Patient(), g, settings, context);
  double sum = 0.0, squares = 0.0;
  int n = 0;
  const auto liver = volume::LabelOf("liver");
  for (int k = 2; k < g.size[2] - 2; ++k) {
    for (int j = 3; j < g.size[1] - 3; ++j) {
      for (int i = 3; i < g.size[0] - 3; ++i) {
        bool core = true;  // Nothing else within reach of the blur.
        for (int c = -2; c <= 2; ++c) {
          for (int b = -3; b <= 3; ++b) {
            for (int a = -3; a <= 3; ++a)
              core = core && scan.labels.At(i + a, j + b, k + c) == liver;
          }
        }
        if (!core) continue;
        const double error = scan.ct.At(i, j, k) - Hu(settings, Material::kLiver);
        sum += error;
        squares += error * error;
        ++n;
      }
    }
  }
  ASSERT_GT(n, 500);
  // Neighbours share noise: the sum over [1 2 1] x [1 2 1] makes (16/6)^2 = 7.1 voxels worth one.
  const double independent = n / 7.1;
  EXPECT_NEAR(sum / n, 0.0, 4.0 * 12 / std::sqrt(independent));
  EXPECT_NEAR(std::sqrt(squares / n), 12.0, 4.0 * 12 / std::sqrt(2.0 * independent));
}

TEST(RenderScan, MixesPartialVolumesByTheirShare) {
  // Without blur and noise, the mean over all voxels is the mean of HU over a fine lattice.
  const Anatomy anatomy = Patient();
  const ScannerSettings settings = Scanner(0, 0, 6);
  const Geometry g = GridAround({0, 25, -18}, {14, 14, 6}, {4, 4, 4});
  const Scan scan = RenderScan(anatomy, g, settings, {});
  double mean = 0.0, truth = 0.0;
  for (const std::int16_t hu : scan.ct.voxels) mean += hu / static_cast<double>(g.num_voxels());
  const int fine = 14;
  for (int k = 0; k < g.size[2] * fine; ++k) {
    for (int j = 0; j < g.size[1] * fine; ++j) {
      for (int i = 0; i < g.size[0] * fine; ++i) {
        const Vector3d index = Vector3d(i + 0.5, j + 0.5, k + 0.5) / fine - Vector3d::Constant(0.5);
        truth += Hu(settings, anatomy.MaterialAt(g.ct_from_index() * index));
      }
    }
  }
  truth /= static_cast<double>(g.num_voxels()) * fine * fine * fine;
  EXPECT_NEAR(mean, truth, 1.0);
}

TEST(RenderScan, BlurMovesNoHuAroundInTotal) {
  const Anatomy anatomy = Patient();
  // Liver all around: what flows over the border flows back.
  const Geometry g = GridAround(anatomy.Landmark("lesion"), {40, 40, 20}, {1, 1, 2});
  const Scan sharp = RenderScan(anatomy, g, Scanner(0, 0), {});
  const Scan blurred = RenderScan(anatomy, g, Scanner(1.5, 0), {});
  double difference = 0.0;
  int changed = 0;
  for (std::size_t n = 0; n < sharp.ct.voxels.size(); ++n) {
    difference += blurred.ct.voxels[n] - sharp.ct.voxels[n];
    changed += blurred.ct.voxels[n] != sharp.ct.voxels[n];
  }
  EXPECT_GT(changed, 1000);
  EXPECT_NEAR(difference / static_cast<double>(g.num_voxels()), 0.0, 0.1);
}

TEST(RenderScan, CountsTheVolumeOfASphere) {
  const Anatomy anatomy = Patient();
  const double radius = 11.0 * anatomy.scale();
  const Geometry g = GridAround(anatomy.Landmark("lesion"), {40, 40, 40}, {0.7, 0.7, 0.7});
  const Scan scan = RenderScan(anatomy, g, Scanner(0, 0), {});
  const auto count = std::ranges::count(scan.labels.voxels, volume::LabelOf("lesion"));
  const double truth = 4.0 / 3.0 * std::numbers::pi * std::pow(radius, 3);
  EXPECT_NEAR(static_cast<double>(count) * g.voxel_volume_mm3(), truth, 0.01 * truth);
}

TEST(RenderScan, GivesTheSameBitsForAnyNumberOfThreads) {
  const Geometry g = GridAround({0, 0, 60}, {90, 70, 24}, {4, 4, 4});
  RunContext one, two, other;
  one.seed = two.seed = 5;
  two.num_threads = 2;
  other.seed = 6;
  const Scan a = RenderScan(Patient(), g, Scanner(0.8, 10), one);
  const Scan b = RenderScan(Patient(), g, Scanner(0.8, 10), two);
  const Scan c = RenderScan(Patient(), g, Scanner(0.8, 10), other);
  EXPECT_EQ(a.ct.voxels, b.ct.voxels);
  EXPECT_EQ(a.labels.voxels, b.labels.voxels);
  EXPECT_EQ(a.labels.voxels, c.labels.voxels);
  EXPECT_NE(a.ct.voxels, c.ct.voxels);
}

}  // namespace
}  // namespace acus::phantom
