// Closed surfaces for tests: a trunk without symmetry, a cylinder, a ball.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <numbers>

#include "acus/data/mesh/surface.h"

namespace acus::testing_support {

/// A surface over directions: latitude and longitude cells in triangles, outwards.
inline mesh::Surface SurfaceOver(const std::function<Eigen::Vector3d(double, double)>& place,
                                 int num_latitudes, int num_longitudes) {
  mesh::Surface surface;
  surface.nodes_mm.resize(3, (num_latitudes + 1) * num_longitudes);
  surface.triangles.resize(3, 2 * num_latitudes * num_longitudes);
  Eigen::Index t = 0;
  for (int i = 0; i <= num_latitudes; ++i) {
    for (int j = 0; j < num_longitudes; ++j) {
      surface.nodes_mm.col(i * num_longitudes + j) =
          place(std::numbers::pi * (static_cast<double>(i) / num_latitudes - 0.5),
                2.0 * std::numbers::pi * j / num_longitudes);
      if (i == num_latitudes) continue;
      const int a = i * num_longitudes + j;
      const int b = i * num_longitudes + (j + 1) % num_longitudes;
      surface.triangles.col(t++) = Eigen::Vector3i(a, b, b + num_longitudes);
      surface.triangles.col(t++) = Eigen::Vector3i(a, b + num_longitudes, a + num_longitudes);
    }
  }
  return surface;
}

/// 300 x 200 x 400 mm, with a navel, flanks and a belly to one side.
inline Eigen::Vector3d TrunkPlace(double latitude, double longitude) {
  const double c = std::cos(latitude);
  const double bump = 1.0 + 0.08 * std::cos(2 * longitude + 1.0) * c +
                      0.06 * std::sin(3 * latitude + longitude) * c +
                      0.05 * std::cos(3 * longitude - 2 * latitude) * c;
  return {150 * bump * c * std::cos(longitude), 100 * bump * c * std::sin(longitude),
          200 * bump * std::sin(latitude)};
}

inline mesh::Surface Trunk(int num_latitudes = 60, int num_longitudes = 90) {
  return SurfaceOver(TrunkPlace, num_latitudes, num_longitudes);
}

inline mesh::Surface Ball(double radius_mm) {
  return SurfaceOver(
      [radius_mm](double latitude, double longitude) {
        return Eigen::Vector3d(radius_mm * std::cos(latitude) * std::cos(longitude),
                               radius_mm * std::cos(latitude) * std::sin(longitude),
                               radius_mm * std::sin(latitude));
      },
      60, 90);
}

/// Without its ends.
inline mesh::Surface Cylinder(double radius_mm, double length_mm) {
  return SurfaceOver(
      [=](double latitude, double longitude) {
        return Eigen::Vector3d(radius_mm * std::cos(longitude), radius_mm * std::sin(longitude),
                               length_mm * latitude / std::numbers::pi);
      },
      40, 180);
}

}  // namespace acus::testing_support
