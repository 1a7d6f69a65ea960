#include "acus/physics/breathing/moved_points.h"

#include <cmath>
#include <gtest/gtest.h>

#include "support/instruction_sets.h"
#include "support/turned_field.h"

namespace acus::breathing {
namespace {

using Eigen::Matrix3Xf;
using Eigen::Vector3d;

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

TEST(MovedPoints, AreTheSameBitsOnEveryInstructionSet) {
  const MotionField field = TurnedField();
  const MotionMap motion = HalfAndHalf(field);
  const Matrix3Xf rest = SomePoints();
  Matrix3Xf first;
  testing_support::OnEveryInstructionSet([&](const char* name) {
    Matrix3Xf moved(3, rest.cols());
    DisplacementsMm(motion, rest, moved);
    if (first.cols() == 0) first = moved;
    EXPECT_EQ(moved, first) << name;
  });
}

}  // namespace
}  // namespace acus::breathing
