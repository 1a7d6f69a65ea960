#include "benchmarks/trunk_body.h"

#include <cmath>
#include <vector>

namespace acus::benchmarks {
namespace {

using Eigen::Array3d;
using Eigen::Vector3d;

/// What it adds to the attenuation of what it lies in, relative to water's.
struct Ellipsoid {
  Vector3d centre_mm;
  Array3d radii_mm;
  double density = 0.0;

  bool Holds(const Vector3d& place_mm) const {
    return ((place_mm - centre_mm).array() / radii_mm).square().sum() <= 1.0;
  }
  /// Length of a line in it.
  double ChordMm(const Vector3d& from_mm, const Vector3d& to_mm) const {
    const Vector3d start = (from_mm - centre_mm).array() / radii_mm;
    const Vector3d way = (to_mm - from_mm).array() / radii_mm;
    const double a = way.squaredNorm();
    const double b = start.dot(way);
    const double root = b * b - a * (start.squaredNorm() - 1.0);
    return root > 0.0 ? 2.0 * std::sqrt(root) / a * (to_mm - from_mm).norm() : 0.0;
  }
};

const std::vector<Ellipsoid>& TrunkBodyParts() {
  static const std::vector<Ellipsoid> parts = [] {
    std::vector<Ellipsoid> out;
    out.push_back({{0.0, 0.0, 0.0}, {165.0, 115.0, 142.0}, 0.91});  // Fat, -90 HU.
    out.push_back({{0.0, 0.0, 0.0}, {145.0, 98.0, 128.0}, 0.13});   // To 40 HU.
    out.push_back({{0.0, 62.0, 0.0}, {17.0, 17.0, 105.0}, 0.66});   // To 700 HU.
    for (const double side : {-1.0, 1.0}) {
      for (int n = 0; n < 8; ++n) {
        out.push_back({{75.0 * side, -45.0, -77.0 + 22.0 * n}, {36.0, 6.0, 5.0}, 0.66});
      }
    }
    return out;
  }();
  return parts;
}

double DensityAt(const Vector3d& place_mm) {
  double density = 0.0;
  for (const Ellipsoid& part : TrunkBodyParts()) {
    if (part.Holds(place_mm))
      density += part.density;
    else if (&part == &TrunkBodyParts().front())
      break;  // All others are in it.
  }
  return density;
}

/// The mean over a voxel, of 4 x 4 x 4 places where an edge passes.
double MeanDensity(const Vector3d& centre_mm, const Array3d& spacing_mm) {
  const double middle = DensityAt(centre_mm);
  bool even = true;
  for (int n = 0; n < 8 && even; ++n) {
    const Array3d corner(n & 1 ? 0.5 : -0.5, n & 2 ? 0.5 : -0.5, n & 4 ? 0.5 : -0.5);
    even = DensityAt(centre_mm + (corner * spacing_mm).matrix()) == middle;
  }
  if (even) return middle;
  double sum = 0.0;
  for (int n = 0; n < 64; ++n) {
    const Array3d share(n % 4, n / 4 % 4, n / 16);
    sum += DensityAt(centre_mm + ((share - 1.5) / 4.0 * spacing_mm).matrix());
  }
  return sum / 64.0;
}

}  // namespace

std::shared_ptr<volume::CtVolume> TrunkBody::Ct(int per_axis) {
  volume::Geometry grid;
  grid.size.setConstant(per_axis);
  grid.spacing_mm = Array3d(384.0, 300.0, 300.0) / per_axis;
  grid.origin_mm = -0.5 * (per_axis - 1) * grid.spacing_mm.matrix();
  auto ct = std::make_shared<volume::CtVolume>(grid, std::int16_t{-1000});
  const Eigen::Affine3d ct_from_index = grid.ct_from_index();
  for (int k = 0; k < per_axis; ++k) {
    for (int j = 0; j < per_axis; ++j) {
      for (int i = 0; i < per_axis; ++i) {
        const double density = MeanDensity(ct_from_index * Vector3d(i, j, k), grid.spacing_mm);
        ct->At(i, j, k) = static_cast<std::int16_t>(std::lround(1000.0 * (density - 1.0)));
      }
    }
  }
  return ct;
}

double TrunkBody::WaterMm(const Vector3d& from_in_ct_mm, const Vector3d& to_in_ct_mm) {
  double sum_mm = 0.0;
  for (const Ellipsoid& part : TrunkBodyParts()) {
    sum_mm += part.density * part.ChordMm(from_in_ct_mm, to_in_ct_mm);
  }
  return sum_mm;
}

Vector3d TrunkBody::BreathMm(const Vector3d& rest_mm) {
  const double share = 0.5 + 0.5 * std::tanh(rest_mm[2] / 40.0);
  return {2.0 * std::sin(rest_mm[1] / 25.0), -4.0 * share + 1.5 * std::cos(rest_mm[0] / 20.0),
          -18.0 * share};
}

breathing::MotionField TrunkBody::Breath(int nodes_per_axis, int num_components) {
  volume::Geometry nodes;
  nodes.size.setConstant(nodes_per_axis);
  nodes.spacing_mm.setConstant(400.0 / (nodes_per_axis - 1));
  nodes.origin_mm.setConstant(-200.0);
  breathing::MotionField field(nodes, num_components);
  const Eigen::Affine3d ct_from_index = nodes.ct_from_index();
  for (int component = 0; component < num_components; ++component) {
    std::vector<float> values;
    for (int k = 0; k < nodes_per_axis; ++k) {
      for (int j = 0; j < nodes_per_axis; ++j) {
        for (int i = 0; i < nodes_per_axis; ++i) {
          const Vector3d mm = BreathMm(ct_from_index * Vector3d(i, j, k));
          for (int axis = 0; axis < 3; ++axis) {
            const double value = component == 0 ? mm[axis] : 0.1 * mm[(axis + component) % 3];
            values.push_back(static_cast<float>(value));
          }
        }
      }
    }
    field.SetComponent(component, values);
  }
  return field;
}

}  // namespace acus::benchmarks
