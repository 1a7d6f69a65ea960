// Things to look at whose place in an image is known.
#pragma once

#include <cmath>
#include <cstdint>
#include <memory>
#include <numbers>
#include <vector>

#include "acus/data/mesh/surface.h"
#include "acus/imaging/volume_rendering/patient_view.h"
#include "acus/physics/breathing/motion_map.h"

namespace acus::testing_support {

/// A ball of 300 HU in air, with a rim of partial volume of some 3 mm: -335 HU, where skin begins
/// to show, exactly at its radius.
inline std::shared_ptr<volume::CtVolume> BallCt(const Eigen::Vector3d& centre_mm,
                                                double radius_mm) {
  volume::Geometry grid;
  grid.size = {80, 90, 70};
  grid.spacing_mm = {1.5, 1.5, 2.0};
  grid.origin_mm = {-60, -70, -60};
  auto ct = std::make_shared<volume::CtVolume>(grid, std::int16_t{-1000});
  const Eigen::Affine3d ct_from_index = grid.ct_from_index();
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        const Eigen::Vector3d place = ct_from_index * Eigen::Vector3d(i, j, k);
        const double depth_mm = radius_mm - (place - centre_mm).norm();
        ct->At(i, j, k) = static_cast<std::int16_t>(
            std::lround(std::clamp(400.0 * depth_mm - 335.0, -1000.0, 300.0)));
      }
    }
  }
  return ct;
}

/// Triangles of a ball, counter-clockwise seen from outside.
inline mesh::Surface BallSurface(const Eigen::Vector3d& centre_mm, double radius_mm,
                                 int rings = 48) {
  mesh::Surface out;
  const int around = 2 * rings;
  out.nodes_mm.resize(3, (rings + 1) * around);
  for (int r = 0; r <= rings; ++r) {
    const double polar = std::numbers::pi * r / rings;
    for (int a = 0; a < around; ++a) {
      const double angle = 2.0 * std::numbers::pi * a / around;
      out.nodes_mm.col(r * around + a) =
          centre_mm + radius_mm * Eigen::Vector3d(std::sin(polar) * std::cos(angle),
                                                  std::sin(polar) * std::sin(angle),
                                                  std::cos(polar));
    }
  }
  out.triangles.resize(3, 2 * rings * around);
  for (int r = 0; r < rings; ++r) {
    for (int a = 0; a < around; ++a) {
      const int low = r * around;
      const int next = (a + 1) % around;
      out.triangles.col(2 * (low + a)) << low + a, low + around + a, low + next;
      out.triangles.col(2 * (low + a) + 1) << low + next, low + around + a, low + around + next;
    }
  }
  return out;
}

/// Breath that moves the upper part down and forward, and squeezes and shears what is between:
/// strains up to some 0.3.
inline Eigen::Vector3d DiaphragmMm(const Eigen::Vector3d& place_mm) {
  const double share = 0.5 + 0.5 * std::tanh(place_mm[2] / 40.0);
  return {2.0 * std::sin(place_mm[1] / 25.0), -4.0 * share + 1.5 * std::cos(place_mm[0] / 20.0),
          -18.0 * share};
}

/// A field in a cube around the origin. Each component is 0.4 of the one before.
template <class Displacement>
breathing::MotionField FieldOf(const Displacement& displacement_mm, int nodes_each_way = 48,
                               int num_components = 1, double edge_mm = 200.0) {
  volume::Geometry nodes;
  nodes.size.setConstant(nodes_each_way);
  nodes.spacing_mm.setConstant(edge_mm / (nodes_each_way - 1));
  nodes.origin_mm.setConstant(-0.5 * edge_mm);
  breathing::MotionField field(nodes, num_components);
  std::vector<float> values;
  const Eigen::Affine3d ct_from_index = nodes.ct_from_index();
  for (int k = 0; k < nodes.size[2]; ++k) {
    for (int j = 0; j < nodes.size[1]; ++j) {
      for (int i = 0; i < nodes.size[0]; ++i) {
        for (const double mm : displacement_mm(ct_from_index * Eigen::Vector3d(i, j, k))) {
          values.push_back(static_cast<float>(mm));
        }
      }
    }
  }
  for (int n = 0; n < num_components; ++n) {
    field.SetComponent(n, values);
    for (float& value : values) value *= 0.4F;
  }
  return field;
}

inline breathing::MotionMap At(const breathing::MotionField& field, double amount) {
  breathing::MotionWeights weights;
  weights.Add(0, amount);
  return {field, weights};
}

/// Where an image is covered: its middle and size, pixels.
struct Blob {
  Eigen::Vector2d middle_px = Eigen::Vector2d::Zero();
  double diameter_px = 0.0;  ///< Of a circle of the same area.
};
inline Blob CoveredPart(const volume_rendering::ViewImage& image) {
  Blob out;
  double sum = 0.0;
  for (int row = 0; row < image.colour.height; ++row) {
    for (int column = 0; column < image.colour.width; ++column) {
      const double share =
          image.coverage[static_cast<std::size_t>(row * image.colour.width + column)] / 255.0;
      sum += share;
      out.middle_px += share * Eigen::Vector2d(column, row);
    }
  }
  out.middle_px /= sum;
  out.diameter_px = std::sqrt(4.0 * sum / std::numbers::pi);
  return out;
}

/// Of images of one size, against the full scale; infinity: they are the same.
inline double PsnrDb(const std::vector<std::uint8_t>& a, const std::vector<std::uint8_t>& b) {
  double sum = 0.0;
  for (std::size_t n = 0; n < a.size(); ++n) sum += std::pow((a[n] - b[n]) / 255.0, 2.0);
  return -10.0 * std::log10(sum / static_cast<double>(a.size()));
}
inline double PsnrDb(const volume_rendering::ViewImage& a, const volume_rendering::ViewImage& b) {
  return PsnrDb(a.colour.rgb, b.colour.rgb);
}

}  // namespace acus::testing_support
