#include "acus/physics/breathing/attached_points.h"

#include <cmath>
#include <gtest/gtest.h>

#include "acus/base/core/random.h"
#include "support/instruction_sets.h"
#include "support/turned_field.h"

namespace acus::breathing {
namespace {

using Eigen::Matrix3Xf;
using Eigen::Vector3d;

// The normal is across both tangents of the deformed surface, which are differences of places.
TEST(AttachedPoints, NormalsStandOnTheDeformedSurface) {
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
  AttachedPoints(rest, normals).MoveTo(motion, 1, world, turned);
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
    ASSERT_LT((world.col(n).cast<double>() - motion.WorldMm(place)).norm(), 3e-4);
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

// Five components, of which a moment has two: more than are kept.
TEST(AttachedPoints, WhatCameBeforeAndThreadsChangeNoBit) {
  MotionField field(TurnedField().nodes(), 5);
  for (int n = 0; n < 5; ++n) {
    auto values = TurnedField().Component(n % 2);
    for (float& value : values) value *= 1.0F + 0.3F * static_cast<float>(n);
    field.SetComponent(n, values);
  }
  const Matrix3Xf rest = SomePoints();
  const Matrix3Xf normals = rest.colwise().normalized();
  AttachedPoints kept(rest, normals);
  for (const int first : {0, 1, 2, 3, 0, 3, 1}) {
    MotionWeights weights;
    weights.Add(first, 0.25);
    weights.Add(first + 1, 0.75);
    Matrix3Xf world(3, rest.cols()), turned(3, rest.cols());
    Matrix3Xf world_anew(3, rest.cols()), turned_anew(3, rest.cols());
    kept.MoveTo({field, weights}, 2, world, turned);
    AttachedPoints(rest, normals).MoveTo({field, weights}, 1, world_anew, turned_anew);
    EXPECT_EQ(world, world_anew) << first;
    EXPECT_EQ(turned, turned_anew) << first;
  }
}

TEST(AttachedPoints, SeeThatAFieldHasChanged) {
  MotionField field = TurnedField();
  const Matrix3Xf rest = SomePoints();
  AttachedPoints points(rest, rest.colwise().normalized());
  Matrix3Xf before(3, rest.cols()), after(3, rest.cols()), normals(3, rest.cols());
  points.MoveTo(HalfAndHalf(field), 1, before, normals);
  auto values = field.Component(0);
  for (float& value : values) value = 0.5F * value;
  field.SetComponent(0, values);
  points.MoveTo(HalfAndHalf(field), 1, after, normals);
  EXPECT_GT((after - before).cwiseAbs().maxCoeff(), 1.0F);
}

TEST(AttachedPoints, AreTheSameBitsOnEveryInstructionSet) {
  const MotionField field = TurnedField();
  const MotionMap motion = HalfAndHalf(field);
  const Matrix3Xf rest = SomePoints();
  const Matrix3Xf normals = rest.colwise().normalized();
  Matrix3Xf first_world;
  Matrix3Xf first_normals;
  testing_support::OnEveryInstructionSet([&](const char* name) {
    Matrix3Xf world(3, rest.cols());
    Matrix3Xf turned(3, rest.cols());
    AttachedPoints(rest, normals).MoveTo(motion, 1, world, turned);
    if (first_world.cols() == 0) {
      first_world = world;
      first_normals = turned;
    }
    EXPECT_EQ(world, first_world) << name;
    EXPECT_EQ(turned, first_normals) << name;
  });
}

}  // namespace
}  // namespace acus::breathing
