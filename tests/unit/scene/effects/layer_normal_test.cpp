#include "acus/scene/effects/fluid/layer_normal.h"

#include <cmath>
#include <gtest/gtest.h>

namespace acus::effects {
namespace {

using Eigen::Vector3d;

/// A layer of label 2 in label 1 through the middle of the volume.
volume::LabelMap Layer(const Vector3d& normal, double half_thickness_mm) {
  volume::LabelMap labels;
  labels.geometry.size = Eigen::Array3i(40, 40, 40);
  labels.geometry.spacing_mm = Eigen::Array3d(0.7, 0.7, 0.7);
  labels.voxels.resize(labels.geometry.num_voxels());
  for (int k = 0; k < 40; ++k) {
    for (int j = 0; j < 40; ++j) {
      for (int i = 0; i < 40; ++i) {
        const Vector3d from_middle_mm = 0.7 * (Vector3d(i, j, k) - Vector3d::Constant(20.0));
        labels.At(i, j, k) = std::abs(from_middle_mm.dot(normal)) <= half_thickness_mm ? 2 : 1;
      }
    }
  }
  return labels;
}

TEST(LayerNormal, IsAcrossTheLayerWhereverTheNeedleComesFrom) {
  for (const Vector3d& normal :
       {Vector3d(0, 0, 1), Vector3d(1, 0, 0), Vector3d(0.6, 0, 0.8), Vector3d(0.48, 0.64, 0.6)}) {
    const volume::LabelMap labels = Layer(normal, 1.5);
    const Vector3d middle = labels.geometry.ct_from_index() * Vector3d::Constant(20.0);
    const auto found = LayerNormal(labels, labels.geometry.index_from_ct(), middle);
    ASSERT_TRUE(found);
    EXPECT_NEAR(found->norm(), 1.0, 1e-12);
    EXPECT_GT(std::abs(found->dot(normal)), std::cos(0.15)) << normal.transpose();
  }
}

TEST(LayerNormal, ATissueOnAllSidesHasNone) {
  const volume::LabelMap labels = Layer(Vector3d::UnitZ(), 30.0);
  const Vector3d middle = labels.geometry.ct_from_index() * Vector3d::Constant(20.0);
  EXPECT_FALSE(LayerNormal(labels, labels.geometry.index_from_ct(), middle));
}

}  // namespace
}  // namespace acus::effects
