// Light on surfaces and in the volume: one lamp beside the camera, and a little from everywhere.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

namespace acus::volume_rendering {

struct Light {
  Eigen::Vector3f to_lamp = Eigen::Vector3f::UnitZ();  ///< Unit, CT space.
  float ambient = 0.34F;
  float diffuse = 0.50F;
  float fill = 0.28F;  ///< From the camera.
  float gloss = 0.18F;
};

/// Blinn-Phong. Both sides of a surface are lit alike.
/// @param normal, to_eye  Unit vectors, CT space.
/// @param lit  1 in the light, 0 in a shadow.
inline Eigen::Array3f Shade(const Light& light, const Eigen::Array3f& colour,
                            const Eigen::Vector3f& normal, const Eigen::Vector3f& to_eye,
                            float lit = 1.0F) noexcept {
  const float toward_eye = normal.dot(to_eye);
  const float side = toward_eye < 0.0F ? -1.0F : 1.0F;
  const float toward_lamp = std::max(0.0F, side * normal.dot(light.to_lamp));
  const Eigen::Vector3f half = (light.to_lamp + to_eye).normalized();
  float shine = std::max(0.0F, side * normal.dot(half));
  for (int n = 0; n < 5; ++n) shine *= shine;  // To the 32nd.
  const float matt =
      light.ambient + light.fill * side * toward_eye + lit * light.diffuse * toward_lamp;
  return colour * matt + lit * light.gloss * shine;
}

}  // namespace acus::volume_rendering
