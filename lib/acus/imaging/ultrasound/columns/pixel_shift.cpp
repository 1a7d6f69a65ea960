#include "acus/imaging/ultrasound/columns/pixel_shift.h"

#include <algorithm>
#include <cmath>

namespace acus::ultrasound {
namespace {

/// Grey between the centres of pixels; outside the image black.
double GreyBetween(const std::vector<std::uint8_t>& pixels, int width, int height,
                   const Eigen::Vector2d& at) {
  const double column = std::floor(at.x());
  const double row = std::floor(at.y());
  const auto grey = [&](double c, double r) -> double {
    if (!(c >= 0.0 && r >= 0.0 && c < width && r < height)) return 0.0;
    return pixels[static_cast<std::size_t>(r) * static_cast<std::size_t>(width) +
                  static_cast<std::size_t>(c)];
  };
  const double x = at.x() - column;
  const double y = at.y() - row;
  return (1.0 - y) * ((1.0 - x) * grey(column, row) + x * grey(column + 1.0, row)) +
         y * ((1.0 - x) * grey(column, row + 1.0) + x * grey(column + 1.0, row + 1.0));
}

}  // namespace

void PixelShift::Apply(const image::ImageGeometry& geometry, const Eigen::Isometry3d& ct_from_probe,
                       const slicing::RestMap& rest, image::GrayImage& image) {
  const Eigen::Affine3d ct_from_image = geometry.ct_from_image(ct_from_probe);
  const Eigen::Affine3d image_from_ct = ct_from_image.inverse();
  const double finest_mm = std::min(geometry.lateral_mm_per_px, geometry.axial_mm_per_px);
  const int step = std::max(1, static_cast<int>(rest.SpacingMm() / finest_mm));
  const int columns = (image.width - 1) / step + 2;  // The last knots are at the edge or beyond.
  const int rows = (image.height - 1) / step + 2;
  at_knot_.resize(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
  bool moved = false;
  for (int r = 0; r < rows; ++r) {
    Eigen::Vector3d offset_mm = Eigen::Vector3d::Zero();
    for (int c = 0; c < columns; ++c) {
      const Eigen::Vector3d at_mm = ct_from_image * Eigen::Vector3d(c * step, r * step, 0.0);
      const Eigen::Vector3d rest_mm = rest.RestInCtMm(at_mm, at_mm + offset_mm);
      offset_mm = rest_mm - at_mm;
      const bool moves = !offset_mm.isZero(0.0);
      moved = moved || moves;
      const Eigen::Vector3d offset = image_from_ct.linear() * offset_mm;
      at_knot_[static_cast<std::size_t>(r) * static_cast<std::size_t>(columns) +
               static_cast<std::size_t>(c)] =
          moves ? Eigen::Vector2d(offset.head<2>()) : Eigen::Vector2d::Zero();
    }
  }
  if (!moved) return;
  before_.assign(image.pixels.begin(), image.pixels.end());
  for (int r = 0; r < image.height; ++r) {
    const double y = static_cast<double>(r % step) / step;
    const Eigen::Vector2d* const knots =
        at_knot_.data() + static_cast<std::ptrdiff_t>(r / step) * columns;
    for (int c = 0; c < image.width; ++c) {
      const Eigen::Vector2d* const knot = knots + c / step;
      const double x = static_cast<double>(c % step) / step;
      const Eigen::Vector2d offset = (1.0 - y) * ((1.0 - x) * knot[0] + x * knot[1]) +
                                     y * ((1.0 - x) * knot[columns] + x * knot[columns + 1]);
      if (offset.isZero(0.0)) continue;
      const double grey =
          GreyBetween(before_, image.width, image.height, Eigen::Vector2d(c, r) + offset);
      image.pixels[static_cast<std::size_t>(r) * static_cast<std::size_t>(image.width) +
                   static_cast<std::size_t>(c)] = static_cast<std::uint8_t>(std::lround(grey));
    }
  }
}

image::NeedleInImage NeedleAtRest(const image::NeedleInImage& needle,
                                  const slicing::RestMap& rest) {
  constexpr int kPointsOfStraight = math::Polyline::kMaxPoints;
  image::NeedleInImage out = needle;
  if (out.shape.num_points < 2) {
    out.shape.Clear();
    for (int n = 0; n < kPointsOfStraight; ++n) {
      const double along_mm = needle.length_mm * n / (kPointsOfStraight - 1);
      out.shape.Add(needle.tip_in_ct_mm - along_mm * needle.axis_in_ct);
    }
  }
  for (int n = 0; n < out.shape.num_points; ++n) {
    Eigen::Vector3d& point_mm = out.shape.point_mm[static_cast<std::size_t>(n)];
    point_mm = rest.RestInCtMm(point_mm, point_mm);
  }
  return out;
}

}  // namespace acus::ultrasound
