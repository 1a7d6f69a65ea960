#include "acus/physics/breathing/motion_field.h"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>

#include "acus/base/core/error.h"

namespace acus::breathing {
namespace {

volume::Geometry ObliqueNodes() {
  volume::Geometry nodes;
  nodes.size = {7, 6, 5};
  nodes.spacing_mm = {4.0, 5.0, 6.0};
  nodes.origin_mm = {-10.0, 20.0, 3.0};
  nodes.direction = Eigen::AngleAxisd(0.4, Eigen::Vector3d(1, 2, 3).normalized()).matrix();
  return nodes;
}

/// A field that trilinear interpolation repeats exactly.
Eigen::Vector3d Linear(const Eigen::Vector3d& place_mm) {
  Eigen::Matrix3d strain;
  strain << 0.1, -0.05, 0.02, 0.03, 0.2, -0.1, 0.0, 0.07, -0.15;
  return strain * place_mm + Eigen::Vector3d(1, -2, 3);
}

std::vector<float> AtNodes(const volume::Geometry& nodes) {
  std::vector<float> values;
  const Eigen::Affine3d ct_from_index = nodes.ct_from_index();
  for (int k = 0; k < nodes.size[2]; ++k) {
    for (int j = 0; j < nodes.size[1]; ++j) {
      for (int i = 0; i < nodes.size[0]; ++i) {
        for (const double value : Linear(ct_from_index * Eigen::Vector3d(i, j, k))) {
          values.push_back(static_cast<float>(value));
        }
      }
    }
  }
  return values;
}

MotionField TwoComponents() {
  MotionField field(ObliqueNodes(), 2);
  auto values = AtNodes(field.nodes());
  field.SetComponent(0, values);
  for (float& value : values) value *= -0.5F;
  field.SetComponent(1, values);
  return field;
}

TEST(MotionField, RepeatsALinearFieldToItsResolutionAnywhereInside) {
  const MotionField field = TwoComponents();
  MotionWeights weights;
  weights.Add(0, 0.7);
  weights.Add(1, 0.2);
  const Eigen::Affine3d ct_from_index = field.nodes().ct_from_index();
  const double resolution_mm = 3.0 * (field.MmPerUnit(0) + field.MmPerUnit(1));
  for (const Eigen::Vector3d& index :
       {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(6, 5, 4), Eigen::Vector3d(2.3, 4.9, 0.1),
        Eigen::Vector3d(5.9, 0, 3)}) {
    const Eigen::Vector3d place = ct_from_index * index;
    const Eigen::Vector3d truth = (0.7 - 0.5 * 0.2) * Linear(place);
    EXPECT_LT((field.DisplacementMm(weights, place) - truth).norm(), resolution_mm) << place;
  }
}

TEST(MotionField, IsGoodToAMicrometreWhenItReaches64Mm) {
  volume::Geometry nodes = ObliqueNodes();
  MotionField field(nodes, 1);
  std::vector<float> values(3 * nodes.num_voxels());
  for (std::size_t n = 0; n < values.size(); ++n) {
    values[n] = static_cast<float>(64.0 * std::sin(0.37 * static_cast<double>(n * n)));
  }
  field.SetComponent(0, values);
  const auto back = field.Component(0);
  for (std::size_t n = 0; n < values.size(); ++n) EXPECT_NEAR(back[n], values[n], 1e-3);
}

TEST(MotionField, BeyondItsBorderItIsAsAtTheBorder) {
  const MotionField field = TwoComponents();
  MotionWeights weights;
  weights.Add(0, 1.0);
  const Eigen::Affine3d ct_from_index = field.nodes().ct_from_index();
  EXPECT_EQ(field.DisplacementMm(weights, ct_from_index * Eigen::Vector3d(-50, 2, 2)),
            field.DisplacementMm(weights, ct_from_index * Eigen::Vector3d(-1, 2, 2)));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(field.DisplacementMm(weights, {nan, 1, 1e300}).allFinite());
}

TEST(MotionField, WithoutWeightsNothingMoves) {
  MotionWeights weights;
  weights.Add(0, 0.0);
  EXPECT_EQ(weights.count, 0);
  EXPECT_EQ(TwoComponents().DisplacementMm(weights, {1, 2, 3}), Eigen::Vector3d::Zero());
}

TEST(MotionField, StoredValuesMakeTheSameField) {
  const MotionField field = TwoComponents();
  MotionField copy(field.nodes(), 2);
  for (const int n : {0, 1}) {
    std::vector<std::int16_t> values;
    for (int k = 0; k < field.nodes().size[2]; ++k) {
      for (int j = 0; j < field.nodes().size[1]; ++j) {
        std::ranges::copy(field.StoredRow(n, j, k), std::back_inserter(values));
      }
    }
    copy.SetStored(n, values, field.MmPerUnit(n));
  }
  MotionWeights weights;
  weights.Add(1, 1.0);
  const Eigen::Vector3d place(5, 30, 15);
  EXPECT_EQ(copy.DisplacementMm(weights, place), field.DisplacementMm(weights, place));
  // A slice takes whole lines of the cache: 3 * 7 * 6 values fit into four.
  EXPECT_EQ(field.bytes(), 2 * 2 * (4 * 32 * 5 + 2));
}

TEST(MotionField, RefusesFieldsThatCannotBe) {
  volume::Geometry flat = ObliqueNodes();
  flat.size[1] = 1;
  EXPECT_THROW(MotionField(flat, 1), InputError);
  EXPECT_THROW(MotionField(ObliqueNodes(), 0), InputError);
  EXPECT_THROW(MotionField(ObliqueNodes(), MotionField::kMaxComponents + 1), InputError);
  MotionField field(ObliqueNodes(), 1);
  auto values = AtNodes(field.nodes());
  EXPECT_THROW(field.SetComponent(0, std::span(values).first(values.size() - 1)), InputError);
  values[17] = 1001.0F;
  EXPECT_THROW(field.SetComponent(0, values), InputError);
  values[17] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(field.SetComponent(0, values), InputError);
}

}  // namespace
}  // namespace acus::breathing
