#include "acus/imaging/volume_rendering/shadow_map.h"

#include <algorithm>
#include <cmath>

namespace acus::volume_rendering {
namespace {

constexpr float kNothing = -1e30F;

}  // namespace

ShadowFrame ShadowMap::FrameOf(const Eigen::Vector3f& to_lamp, const Eigen::AlignedBox3f& box_mm) {
  ShadowFrame frame;
  const Eigen::Vector3f x = to_lamp.unitOrthogonal();
  frame.lamp_from_ct.row(0) = x;
  frame.lamp_from_ct.row(1) = to_lamp.cross(x);
  frame.lamp_from_ct.row(2) = to_lamp;
  Eigen::AlignedBox3f box;
  for (int n = 0; n < 8; ++n) {
    box.extend(frame.lamp_from_ct * box_mm.corner(static_cast<Eigen::AlignedBox3f::CornerType>(n)));
  }
  // Room for the soft edge.
  frame.mm_per_cell = std::max(0.2F, box.sizes().head<2>().maxCoeff() / (kSize - 8));
  frame.low_mm = box.min().head<2>() - Eigen::Vector2f::Constant(4.0F * frame.mm_per_cell);
  return frame;
}

void ShadowMap::Begin(const ShadowFrame& frame) {
  frame_ = frame;
  height_mm_.assign(static_cast<std::size_t>(kSize * kSize), kNothing);
}

void ShadowMap::Add(const Eigen::Matrix3Xf& nodes_mm, const Eigen::Matrix3Xi& triangles) {
  for (const auto& corners : triangles.colwise()) {
    Eigen::Matrix3f at;
    for (int n = 0; n < 3; ++n) at.col(n) = frame_.lamp_from_ct * nodes_mm.col(corners[n]);
    at.topRows<2>() = (at.topRows<2>().colwise() - frame_.low_mm) / frame_.mm_per_cell;
    const Eigen::Vector2f a = at.col(1).head<2>() - at.col(0).head<2>();
    const Eigen::Vector2f b = at.col(2).head<2>() - at.col(0).head<2>();
    const float area = a[0] * b[1] - a[1] * b[0];
    if (area == 0.0F) continue;
    const Eigen::Array2i low =
        at.topRows<2>().rowwise().minCoeff().array().ceil().cast<int>().max(0);
    const Eigen::Array2i high =
        at.topRows<2>().rowwise().maxCoeff().array().floor().cast<int>().min(kSize - 1);
    for (int v = low[1]; v <= high[1]; ++v) {
      for (int u = low[0]; u <= high[0]; ++u) {
        const Eigen::Vector2f p = Eigen::Vector2f(u, v) - at.col(0).head<2>();
        const float along = (p[0] * b[1] - p[1] * b[0]) / area;
        const float across = (a[0] * p[1] - a[1] * p[0]) / area;
        if (along < 0.0F || across < 0.0F || along + across > 1.0F) continue;
        const float height =
            at(2, 0) + along * (at(2, 1) - at(2, 0)) + across * (at(2, 2) - at(2, 0));
        float& cell = height_mm_[static_cast<std::size_t>(v * kSize + u)];
        cell = std::max(cell, height);
      }
    }
  }
}

float ShadowMap::LitAt(const Eigen::Vector3f& place_mm) const noexcept {
  const Eigen::Vector3f at = frame_.lamp_from_ct * place_mm;
  const Eigen::Vector2f cell = (at.head<2>() - frame_.low_mm) / frame_.mm_per_cell;
  // As numbers with a fraction: a place far away has no cell that an integer could name.
  constexpr float kEnd = kSize - 2;
  if (!(cell[0] >= 1.0F && cell[1] >= 1.0F && cell[0] < kEnd && cell[1] < kEnd)) return 1.0F;
  const auto u = static_cast<int>(cell[0]);
  const auto v = static_cast<int>(cell[1]);
  // The share of 4 x 4 cells in the light, each as far as it is within a square of 3 cells' width.
  const float fu = cell[0] - static_cast<float>(u);
  const float fv = cell[1] - static_cast<float>(v);
  const float weights_u[4] = {1.0F - fu, 1.0F, 1.0F, fu};
  const float weights_v[4] = {1.0F - fv, 1.0F, 1.0F, fv};
  float shadow = 0.0F;
  for (int j = 0; j < 4; ++j) {
    for (int i = 0; i < 4; ++i) {
      const float height = height_mm_[static_cast<std::size_t>((v - 1 + j) * kSize + u - 1 + i)];
      if (height > at[2] + kClearMm) shadow += weights_u[i] * weights_v[j];
    }
  }
  return 1.0F - shadow / 9.0F;
}

}  // namespace acus::volume_rendering
