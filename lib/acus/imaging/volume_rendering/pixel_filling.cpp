#include "acus/imaging/volume_rendering/pixel_filling.h"

#include <algorithm>

namespace acus::volume_rendering {
namespace {

bool IsInGrid(int at, int size, int stride) {
  return at % stride == 0 || at == size - 1;
}

/// Between two places of a grid along one axis.
struct Between {
  Between(int at, int size, int stride) {
    if (IsInGrid(at, size, stride)) {
      low = high = at;
      return;
    }
    low = at - at % stride;
    high = std::min(low + stride, size - 1);
    share = static_cast<float>(at - low) / static_cast<float>(high - low);
  }
  int low;
  int high;
  float share = 0.0F;
};

Eigen::Array4f ValueOf(const RayColour& pixel) {
  Eigen::Array4f value;
  value << pixel.colour, pixel.opacity;
  return value;
}

/// @return false if those around differ too much.
bool Interpolate(const TilePlace& tile, const Between& across, const Between& down, float tolerance,
                 std::span<RayColour> pixels, RayColour& out) {
  const auto at = [&](int column, int row) {
    return ValueOf(pixels[static_cast<std::size_t>(row * tile.width_px + column)]);
  };
  const Eigen::Array4f a = at(across.low, down.low);
  const Eigen::Array4f b = at(across.high, down.low);
  const Eigen::Array4f c = at(across.low, down.high);
  const Eigen::Array4f d = at(across.high, down.high);
  const Eigen::Array4f spread = a.max(b).max(c.max(d)) - a.min(b).min(c.min(d));
  if (!(spread <= tolerance).all()) return false;
  const Eigen::Array4f above = a + across.share * (b - a);
  const Eigen::Array4f below = c + across.share * (d - c);
  const Eigen::Array4f value = above + down.share * (below - above);
  out.colour = value.head<3>();
  out.opacity = value[3];
  return true;
}

}  // namespace

void FirstPixels(const TilePlace& tile, std::vector<std::uint8_t>& wanted) {
  wanted.clear();
  for (int row = 0; row < tile.height_px; ++row) {
    for (int column = 0; column < tile.width_px; ++column) {
      wanted.push_back(IsInGrid(row, tile.height_px, kFirstStride) &&
                       IsInGrid(column, tile.width_px, kFirstStride));
    }
  }
}

void FillBetween(const TilePlace& tile, int stride, float tolerance,
                 std::span<const std::span<const Fragment>> fragments_of,
                 std::span<RayColour> pixels, std::vector<std::uint8_t>& wanted) {
  std::ranges::fill(wanted, std::uint8_t{0});
  for (int row = 0; row < tile.height_px; ++row) {
    if (!IsInGrid(row, tile.height_px, stride / 2)) continue;
    const Between down(row, tile.height_px, stride);
    for (int column = 0; column < tile.width_px; ++column) {
      if (!IsInGrid(column, tile.width_px, stride / 2)) continue;
      const Between across(column, tile.width_px, stride);
      if (across.low == across.high && down.low == down.high) continue;
      const auto n = static_cast<std::size_t>(row * tile.width_px + column);
      const bool has_surface = !fragments_of.empty() && !fragments_of[n].empty();
      wanted[n] = has_surface || !Interpolate(tile, across, down, tolerance, pixels, pixels[n]);
    }
  }
}

}  // namespace acus::volume_rendering
