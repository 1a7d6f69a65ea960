#include "acus/physics/breathing/moved_points.h"

#include <cmath>
#include <gtest/gtest.h>
#include <hwy/highway.h>

#include "acus/base/core/random.h"

namespace acus::breathing {
namespace {

using Eigen::Matrix3Xf;
using Eigen::Vector3d;

/// Two components over a grid that is turned and has other spacings along each axis.
MotionField TurnedField() {
  volume::Geometry nodes;
  nodes.size = {17, 13, 11};
  nodes.spacing_mm = {9.0, 12.0, 15.0};
  nodes.origin_mm = {-70, -60, -75};
  nodes.direction = Eigen::AngleAxisd(0.4, Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  MotionField field(nodes, 2);
  const Eigen::Affine3d ct_from_index = nodes.ct_from_index();
  for (int n = 0; n < 2; ++n) {
    std::vector<float> values;
    for (int k = 0; k < nodes.size[2]; ++k) {
      for (int j = 0; j < nodes.size[1]; ++j) {
        for (int i = 0; i < nodes.size[0]; ++i) {
          const Vector3d p = ct_from_index * Vector3d(i, j, k);
          for (const double mm : {3.0 * std::sin(p[1] / (20.0 + n)), 4.0 * std::cos(p[2] / 30.0),
                                  -12.0 * std::tanh(p[0] / (40.0 - n))}) {
            values.push_back(static_cast<float>(mm));
          }
        }
      }
    }
    field.SetComponent(n, values);
  }
  return field;
}

MotionMap HalfAndHalf(const MotionField& field) {
  MotionWeights weights;
  weights.Add(0, 0.7);
  weights.Add(1, 0.4);
  return {field, weights};
}

/// Inside and outside of the field; as many as leave a vector half full.
Matrix3Xf SomePoints() {
  RandomStream rng(7, "points");
  Matrix3Xf out(3, 1003);
  for (float& mm : out.reshaped()) mm = static_cast<float>(rng.Uniform(-110.0, 110.0));
  return out;
}

TEST(MovedPoints, AreThoseOfTheScalarFieldAlsoBeyondItsBorder) {
  const MotionField field = TurnedField();
  const MotionMap motion = HalfAndHalf(field);
  const Matrix3Xf rest = SomePoints();
  Matrix3Xf moved(3, rest.cols());
  DisplacementsMm(motion, rest, moved);
  for (Eigen::Index n = 0; n < rest.cols(); ++n) {
    const Vector3d truth = motion.DisplacementMm(rest.col(n).cast<double>());
    ASSERT_LT((moved.col(n).cast<double>() - truth).norm(), 1e-4) << n;
  }
  Matrix3Xf in_place = rest;
  DisplacementsMm(motion, in_place, in_place);
  EXPECT_EQ(in_place, moved);
}

TEST(MovedPoints, OfPlacesThatAreNotFiniteAreFinite) {
  const MotionField field = TurnedField();
  Matrix3Xf rest(3, 3);
  rest << NAN, 1e30F, -INFINITY, 0.0F, INFINITY, 1.0F, 2.0F, 3.0F, NAN;
  Matrix3Xf moved(3, 3);
  DisplacementsMm(HalfAndHalf(field), rest, moved);
  EXPECT_TRUE(moved.allFinite());
}

// The normal is across both tangents of the deformed surface, which are differences of places.
TEST(MovedPoints, NormalsStandOnTheDeformedSurface) {
  const MotionField field = TurnedField();
  const MotionMap motion = HalfAndHalf(field);
  const Matrix3Xf rest = SomePoints();
  Matrix3Xf normals(3, rest.cols());
  RandomStream rng(3, "normals");
  for (auto normal : normals.colwise()) {
    for (float& value : normal) value = static_cast<float>(rng.Uniform(-1.0, 1.0));
    normal.normalize();
  }
  Matrix3Xf world(3, rest.cols());
  Matrix3Xf turned(3, rest.cols());
  MoveWithNormals(motion, rest, normals, world, turned);
  int judged = 0;
  double most_turned = 0.0;
  const Eigen::Affine3d index_from_ct = field.nodes().index_from_ct();
  for (Eigen::Index n = 0; n < rest.cols(); ++n) {
    const Vector3d place = rest.col(n).cast<double>();
    // Where the gradient is that of one cell: nodes and the border are not between the differences.
    const Eigen::Array3d index = (index_from_ct * place).array();
    const Eigen::Array3d share = index - index.floor();
    if ((index < 0.0).any() || (index > (field.nodes().size - 1).cast<double>()).any() ||
        (share < 0.05).any() || (share > 0.95).any()) {
      continue;
    }
    ASSERT_LT((world.col(n).cast<double>() - motion.WorldMm(place)).norm(), 1e-4);
    const Vector3d normal = normals.col(n).cast<double>();
    const Vector3d tangent = normal.unitOrthogonal();
    for (const Vector3d& along : {tangent, Vector3d(normal.cross(tangent))}) {
      const Vector3d deformed =
          (motion.WorldMm(place + 0.2 * along) - motion.WorldMm(place - 0.2 * along)) / 0.4;
      EXPECT_LT(std::abs(deformed.dot(turned.col(n).cast<double>())), 2e-3);
    }
    EXPECT_NEAR(turned.col(n).norm(), 1.0F, 1e-5F);
    most_turned = std::max(most_turned, (turned.col(n) - normals.col(n)).cast<double>().norm());
    ++judged;
  }
  EXPECT_GT(judged, 100);
  EXPECT_GT(most_turned, 0.1);
}

TEST(MovedPoints, AreTheSameBitsOnEveryInstructionSet) {
  const MotionField field = TurnedField();
  const MotionMap motion = HalfAndHalf(field);
  const Matrix3Xf rest = SomePoints();
  const Matrix3Xf normals = rest.colwise().normalized();
  Matrix3Xf first_world;
  Matrix3Xf first_normals;
  for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    Matrix3Xf world(3, rest.cols());
    Matrix3Xf turned(3, rest.cols());
    MoveWithNormals(motion, rest, normals, world, turned);
    if (first_world.cols() == 0) {
      first_world = world;
      first_normals = turned;
    }
    EXPECT_EQ(world, first_world) << hwy::TargetName(target);
    EXPECT_EQ(turned, first_normals) << hwy::TargetName(target);
  }
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

}  // namespace
}  // namespace acus::breathing
