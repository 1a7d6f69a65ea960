#include "acus/window/shadow_texture.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace acus::window {
namespace {

constexpr float kNothing = std::numeric_limits<float>::lowest();
/// A closer tool is at the skin, not above it: avoids shadows that flicker.
constexpr double kTouchingMm = 1.0;
constexpr int kBlurPx = 1;  // To both sides.
constexpr int kDarkest = 200;

/// Calls visit(column, row, height) for each pixel whose centre is in the triangle.
template <typename Visit>
void ForEachPixel(const std::array<Eigen::Vector3d, 3>& corner, int size, const Visit& visit) {
  const auto& [a, b, c] = corner;
  const double area = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
  if (!(std::abs(area) > 1e-12)) return;
  const auto bound = [&](int axis, bool high) {
    const double low = std::min({a[axis], b[axis], c[axis]});
    const double top = std::max({a[axis], b[axis], c[axis]});
    const double value = high ? std::floor(top) : std::ceil(low);
    return static_cast<int>(std::clamp(value, -1.0, static_cast<double>(size)));
  };
  const int last_row = std::min(size - 1, bound(1, true));
  const int last_column = std::min(size - 1, bound(0, true));
  for (int row = std::max(0, bound(1, false)); row <= last_row; ++row) {
    for (int column = std::max(0, bound(0, false)); column <= last_column; ++column) {
      const double u = ((column - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (row - a[1])) / area;
      const double v = ((b[0] - a[0]) * (row - a[1]) - (column - a[0]) * (b[1] - a[1])) / area;
      if (u < -1e-9 || v < -1e-9 || u + v > 1.0 + 1e-9) continue;
      visit(column, row, a[2] + u * (b[2] - a[2]) + v * (c[2] - a[2]));
    }
  }
}

}  // namespace

ShadowTexture::ShadowTexture(const mesh::Surface& surface, const Eigen::Vector3d& towards_light) {
  const Eigen::Vector3d light = towards_light.normalized();
  const Eigen::Vector3d across = light.unitOrthogonal();
  light_from_ct_.row(0) = across.transpose();
  light_from_ct_.row(1) = light.cross(across).transpose();
  light_from_ct_.row(2) = light.transpose();
  const auto count = static_cast<std::size_t>(kSize) * kSize;
  height_mm_.assign(count, kNothing);
  shade_.assign(count, 0);
  row_sums_.assign(count, 0);
  rgba_.assign(4 * count, 255);
  if (surface.nodes_mm.cols() == 0) return;
  const Eigen::Matrix3Xd seen = light_from_ct_ * surface.nodes_mm;
  const Eigen::Vector2d low = seen.topRows<2>().rowwise().minCoeff();
  const Eigen::Vector2d high = seen.topRows<2>().rowwise().maxCoeff();
  mm_per_px_ = std::max((high - low).maxCoeff() / (kSize - 1), 1e-3);
  corner_mm_ = low;
  for (Eigen::Index t = 0; t < surface.triangles.cols(); ++t) {
    std::array<Eigen::Vector3d, 3> corner;
    for (int i = 0; i < 3; ++i) {
      corner[static_cast<std::size_t>(i)] = InLight(surface.nodes_mm.col(surface.triangles(i, t)));
    }
    ForEachPixel(corner, kSize, [&](int column, int row, double height) {
      float& at = height_mm_[static_cast<std::size_t>(row * kSize + column)];
      at = std::max(at, static_cast<float>(height));
    });
  }
}

Eigen::Vector3d ShadowTexture::InLight(const Eigen::Vector3d& place_mm) const {
  Eigen::Vector3d out = light_from_ct_ * place_mm;
  out.head<2>() = (out.head<2>() - corner_mm_) / mm_per_px_;
  return out;
}

float ShadowTexture::HeightAt(double column, double row) const {
  if (!(column > -0.5 && row > -0.5 && column < kSize - 0.5 && row < kSize - 0.5)) return kNothing;
  return height_mm_[static_cast<std::size_t>(std::lround(row) * kSize + std::lround(column))];
}

Eigen::Matrix2Xf ShadowTexture::PlacesOf(const Eigen::Matrix3Xd& nodes_mm) const {
  Eigen::Matrix2Xf out(2, nodes_mm.cols());
  for (Eigen::Index n = 0; n < nodes_mm.cols(); ++n) {
    const Eigen::Vector3d at = InLight(nodes_mm.col(n));
    // Centres of pixels are half a pixel inside the texture.
    out.col(n) = ((at.head<2>().array() + 0.5) / kSize).cast<float>().matrix();
  }
  return out;
}

void ShadowTexture::Clear() {
  std::ranges::fill(shade_, std::uint8_t{0});
}

void ShadowTexture::AddLine(std::span<const Eigen::Vector3d> points_mm, double radius_mm) {
  const double radius_px = std::max(0.7, radius_mm / mm_per_px_);
  const int reach = static_cast<int>(std::ceil(radius_px));
  for (std::size_t i = 1; i < points_mm.size(); ++i) {
    const Eigen::Vector3d from = InLight(points_mm[i - 1]);
    const Eigen::Vector3d to = InLight(points_mm[i]);
    if (!from.allFinite() || !to.allFinite()) continue;
    const double length_px = (to - from).head<2>().norm();
    const int steps = static_cast<int>(std::clamp(std::ceil(2.0 * length_px), 1.0, 4.0 * kSize));
    for (int s = 0; s <= steps; ++s) {
      const Eigen::Vector3d at = from + static_cast<double>(s) / steps * (to - from);
      const float skin = HeightAt(at[0], at[1]);
      if (skin == kNothing || at[2] < static_cast<double>(skin) + kTouchingMm) continue;
      const int column = static_cast<int>(std::lround(at[0]));
      const int row = static_cast<int>(std::lround(at[1]));
      for (int y = std::max(0, row - reach); y <= std::min(kSize - 1, row + reach); ++y) {
        for (int x = std::max(0, column - reach); x <= std::min(kSize - 1, column + reach); ++x) {
          if (std::hypot(x - at[0], y - at[1]) > radius_px) continue;
          shade_[static_cast<std::size_t>(y * kSize + x)] = 1;
        }
      }
    }
  }
}

void ShadowTexture::AddSurface(const mesh::Surface& tool, const Eigen::Isometry3d& ct_from_tool) {
  for (Eigen::Index t = 0; t < tool.triangles.cols(); ++t) {
    std::array<Eigen::Vector3d, 3> corner;
    bool finite = true;
    for (int i = 0; i < 3; ++i) {
      auto& at = corner[static_cast<std::size_t>(i)];
      at = InLight(ct_from_tool * tool.nodes_mm.col(tool.triangles(i, t)));
      finite = finite && at.allFinite();
    }
    if (!finite) continue;
    ForEachPixel(corner, kSize, [&](int column, int row, double height) {
      const auto at = static_cast<std::size_t>(row * kSize + column);
      if (height_mm_[at] == kNothing ||
          height < static_cast<double>(height_mm_[at]) + kTouchingMm) {
        return;
      }
      shade_[at] = 1;
    });
  }
}

Texture ShadowTexture::Finish(double lit_opacity) {
  constexpr int kWidth = 2 * kBlurPx + 1;
  constexpr int kFull = kWidth * kWidth;
  const int lit = static_cast<int>(std::lround(255.0 * std::clamp(lit_opacity, 0.0, 1.0)));
  for (int row = 0; row < kSize; ++row) {
    for (int column = kBlurPx; column < kSize - kBlurPx; ++column) {
      const auto at = static_cast<std::size_t>(row * kSize + column);
      row_sums_[at] = static_cast<std::uint8_t>(shade_[at - 1] + shade_[at] + shade_[at + 1]);
    }
  }
  for (int row = kBlurPx; row < kSize - kBlurPx; ++row) {
    for (int column = 0; column < kSize; ++column) {
      const auto at = static_cast<std::size_t>(row * kSize + column);
      const int sum = row_sums_[at - kSize] + row_sums_[at] + row_sums_[at + kSize];
      const auto light = static_cast<std::uint8_t>(255 - kDarkest * sum / kFull);
      rgba_[4 * at] = light;
      rgba_[4 * at + 1] = light;
      rgba_[4 * at + 2] = light;
      rgba_[4 * at + 3] = static_cast<std::uint8_t>(lit + (255 - lit) * sum / kFull);
    }
  }
  return {.width = kSize, .height = kSize, .rgba = rgba_};
}

bool ShadowTexture::IsShaded(const Eigen::Vector3d& place_mm) const {
  const Eigen::Vector3d at = InLight(place_mm);
  if (HeightAt(at[0], at[1]) == kNothing) return false;
  return shade_[static_cast<std::size_t>(std::lround(at[1]) * kSize + std::lround(at[0]))] != 0;
}

}  // namespace acus::window
