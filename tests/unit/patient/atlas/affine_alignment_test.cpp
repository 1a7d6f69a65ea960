#include "acus/patient/atlas/affine_alignment.h"

#include <cmath>
#include <gtest/gtest.h>

namespace acus::atlas {
namespace {

using Eigen::Vector3d;

/// A body of an ellipse's section with organs in it, in a grid of 6 mm about a place.
struct ScannedBody {
  volume::Grid<float> image;
  segmentation::Mask body;

  ScannedBody(const Eigen::Array3i& size, const Vector3d& grid_middle_mm, const Vector3d& body_mm) {
    volume::Geometry g;
    g.size = size;
    g.spacing_mm.setConstant(6.0);
    g.origin_mm = grid_middle_mm - 3.0 * (size - 1).cast<double>().matrix();
    image = volume::Grid<float>(g);
    body = segmentation::Mask(g, 0);
    for (std::size_t n = 0; n < image.voxels.size(); ++n) {
      const auto columns = static_cast<std::size_t>(size[0]),
                 rows = static_cast<std::size_t>(size[1]);
      const Vector3d index(static_cast<double>(n % columns),
                           static_cast<double>(n / columns % rows),
                           static_cast<double>(n / (columns * rows)));
      const Vector3d p = g.ct_from_index() * index - body_mm;
      const bool inside = std::hypot(p.x() / 90.0, p.y() / 60.0) < 1.0;
      body.voxels[n] = inside ? 1 : 0;
      const double organ = 60.0 * std::exp(-(p - Vector3d(30, -10, 20)).squaredNorm() / 900.0) -
                           80.0 * std::exp(-(p - Vector3d(-40, 10, -25)).squaredNorm() / 700.0);
      image.voxels[n] = static_cast<float>(inside ? 40.0 + organ : -250.0);
    }
  }
};

TEST(AlignBodies, FindsTheShiftOfAShortScan) {
  const Vector3d moved_mm(12.0, -7.0, 9.0);
  const ScannedBody patient({40, 30, 16}, Vector3d::Zero(), Vector3d::Zero());
  const ScannedBody atlas({40, 30, 16}, Vector3d::Zero(), moved_mm);
  const auto map = AlignBodies(patient.image, patient.body,
                               breathing_registration::ModelImage(atlas.image, 1), atlas.body);
  ASSERT_TRUE(map.has_value());
  for (const Vector3d& p : {Vector3d(30, -10, 20), Vector3d(-40, 10, -25), Vector3d(0, 0, 0)}) {
    EXPECT_LT((*map * p - p - moved_mm).norm(), 6.0) << p.transpose();  // A voxel.
  }
}

TEST(AlignBodies, GivesNothingForAScanOfAnotherPart) {
  const ScannedBody patient({40, 30, 16}, Vector3d::Zero(), Vector3d::Zero());
  // So little of it is in the atlas, at any height.
  const ScannedBody atlas({12, 10, 4}, Vector3d::Zero(), Vector3d::Zero());
  EXPECT_FALSE(AlignBodies(patient.image, patient.body,
                           breathing_registration::ModelImage(atlas.image, 1), atlas.body)
                   .has_value());
}

}  // namespace
}  // namespace acus::atlas
