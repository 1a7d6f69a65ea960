// A field of motion whose every number differs, and points in and around it.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "acus/base/core/random.h"
#include "acus/physics/breathing/motion_map.h"

namespace acus::breathing {

/// Two components over a grid that is turned and has other spacings along each axis.
inline MotionField TurnedField() {
  volume::Geometry nodes;
  nodes.size = {17, 13, 11};
  nodes.spacing_mm = {9.0, 12.0, 15.0};
  nodes.origin_mm = {-70, -60, -75};
  nodes.direction =
      Eigen::AngleAxisd(0.4, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  MotionField field(nodes, 2);
  const Eigen::Affine3d ct_from_index = nodes.ct_from_index();
  for (int n = 0; n < 2; ++n) {
    std::vector<float> values;
    for (int k = 0; k < nodes.size[2]; ++k) {
      for (int j = 0; j < nodes.size[1]; ++j) {
        for (int i = 0; i < nodes.size[0]; ++i) {
          const Eigen::Vector3d p = ct_from_index * Eigen::Vector3d(i, j, k);
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

inline MotionMap HalfAndHalf(const MotionField& field) {
  MotionWeights weights;
  weights.Add(0, 0.7);
  weights.Add(1, 0.4);
  return {field, weights};
}

/// Inside and outside of the field; as many as leave a vector half full.
inline Eigen::Matrix3Xf SomePoints() {
  RandomStream rng(7, "points");
  Eigen::Matrix3Xf out(3, 1003);
  for (float& mm : out.reshaped()) mm = static_cast<float>(rng.Uniform(-110.0, 110.0));
  return out;
}

}  // namespace acus::breathing
