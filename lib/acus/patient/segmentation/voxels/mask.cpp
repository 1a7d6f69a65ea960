#include "acus/patient/segmentation/voxels/mask.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "acus/base/core/parallel.h"

namespace acus::segmentation {
namespace {

constexpr float kFar = 1e18F;

/// Squared distance along i to the nearest voxel that is `target`, in mm^2, row by row.
void DistanceAlongRows(const Mask& mask, std::uint8_t target, std::vector<float>& squared,
                       int num_threads) {
  const auto& size = mask.geometry.size;
  const auto step = static_cast<float>(mask.geometry.spacing_mm[0]);
  ParallelFor(size[2], num_threads, [&](int k) {
    for (int j = 0; j < size[1]; ++j) {
      const std::size_t row = mask.geometry.Index(0, j, k);
      float distance = kFar;
      for (int i = 0; i < size[0]; ++i) {
        const std::size_t at = row + static_cast<std::size_t>(i);
        distance = mask.voxels[at] == target ? 0.0F : distance + step;
        squared[at] = distance;
      }
      distance = kFar;
      for (int i = size[0] - 1; i >= 0; --i) {
        const std::size_t at = row + static_cast<std::size_t>(i);
        distance = squared[at] == 0.0F ? 0.0F : distance + step;
        const float nearest = std::min(distance, squared[at]);
        squared[at] = nearest >= kFar ? kFar : nearest * nearest;
      }
    }
  });
}

/// out = min over `row` shifts along one axis of in + (shift * spacing)^2, up to `reach` steps.
void MinimumOverWindow(const volume::Geometry& g, int axis, int reach, const std::vector<float>& in,
                       std::vector<float>& out, int num_threads) {
  const int count = g.size[axis];
  const std::size_t stride = axis == 1 ? static_cast<std::size_t>(g.size[0]) : g.Index(0, 0, 1);
  const auto columns = static_cast<std::size_t>(g.size[0]);
  ParallelFor(g.size[2], num_threads, [&](int k) {
    for (int j = 0; j < g.size[1]; ++j) {
      const std::size_t row = g.Index(0, j, k);
      const int here = axis == 1 ? j : k;
      float* const to = &out[row];
      std::copy_n(&in[row], columns, to);
      for (int shift = -reach; shift <= reach; ++shift) {
        if (shift == 0 || here + shift < 0 || here + shift >= count) continue;
        const auto away = static_cast<float>(shift * g.spacing_mm[axis]);
        const float add = away * away;
        const float* const from = &in[row] + static_cast<std::ptrdiff_t>(stride) * shift;
        for (std::size_t i = 0; i < columns; ++i) to[i] = std::min(to[i], from[i] + add);
      }
    }
  });
}

/// Voxels within `radius_mm` of a voxel that is `target`.
Mask Near(const Mask& mask, std::uint8_t target, double radius_mm, int num_threads) {
  ACUS_ASSERT(radius_mm >= 0.0);
  const volume::Geometry& g = mask.geometry;
  std::vector<float> a(mask.voxels.size());
  std::vector<float> b(mask.voxels.size());
  DistanceAlongRows(mask, target, a, num_threads);
  const auto reach = [&](int axis) {
    return static_cast<int>(std::floor(radius_mm / g.spacing_mm[axis] + 1e-6));
  };
  MinimumOverWindow(g, 1, reach(1), a, b, num_threads);
  MinimumOverWindow(g, 2, reach(2), b, a, num_threads);
  const auto limit = static_cast<float>(radius_mm * radius_mm * (1.0 + 1e-5));
  Mask near(g);
  for (std::size_t i = 0; i < a.size(); ++i) near.voxels[i] = a[i] <= limit ? 1 : 0;
  return near;
}

/// Union of runs by number, with path halving.
class DisjointSets {
 public:
  std::int32_t Add() {
    parent_.push_back(static_cast<std::int32_t>(parent_.size()));
    return parent_.back();
  }
  std::int32_t Root(std::int32_t x) {
    while (parent_[static_cast<std::size_t>(x)] != x) {
      auto& parent = parent_[static_cast<std::size_t>(x)];
      parent = parent_[static_cast<std::size_t>(parent)];
      x = parent;
    }
    return x;
  }
  void Join(std::int32_t a, std::int32_t b) {
    a = Root(a);
    b = Root(b);
    parent_[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
  }
  std::size_t size() const { return parent_.size(); }

 private:
  std::vector<std::int32_t> parent_;
};

/// Lower envelope of parabolas along one line of n samples; f in and out, in mm^2.
void EnvelopeAlongLine(std::vector<double>& f, double spacing_mm, std::vector<int>& place,
                       std::vector<double>& begin, std::vector<double>& out) {
  const int n = static_cast<int>(f.size());
  int top = -1;
  for (int q = 0; q < n; ++q) {
    const double value = f[static_cast<std::size_t>(q)];
    if (value >= kFar) continue;
    const double x = q * spacing_mm;
    double start = -std::numeric_limits<double>::infinity();
    while (top >= 0) {
      const int p = place[static_cast<std::size_t>(top)];
      const double px = p * spacing_mm;
      start = ((value + x * x) - (f[static_cast<std::size_t>(p)] + px * px)) / (2.0 * (x - px));
      if (start > begin[static_cast<std::size_t>(top)]) break;
      --top;
      start = -std::numeric_limits<double>::infinity();
    }
    ++top;
    place[static_cast<std::size_t>(top)] = q;
    begin[static_cast<std::size_t>(top)] = start;
  }
  if (top < 0) return;
  int at = 0;
  for (int q = 0; q < n; ++q) {
    const double x = q * spacing_mm;
    while (at < top && begin[static_cast<std::size_t>(at) + 1] < x) ++at;
    const int p = place[static_cast<std::size_t>(at)];
    const double away = (q - p) * spacing_mm;
    out[static_cast<std::size_t>(q)] = away * away + f[static_cast<std::size_t>(p)];
  }
  f = out;
}

}  // namespace

Mask MaskOf(const volume::Grid<volume::Label>& labels, volume::Label label) {
  Mask mask(labels.geometry);
  std::ranges::transform(labels.voxels, mask.voxels.begin(),
                         [&](volume::Label here) { return here == label ? 1 : 0; });
  return mask;
}

Mask BodyOf(const volume::Grid<volume::Label>& labels) {
  Mask body(labels.geometry);
  std::ranges::transform(labels.voxels, body.voxels.begin(),
                         [](volume::Label here) { return here != 0 ? 1 : 0; });
  return body;
}

std::size_t Count(const Mask& mask) {
  return std::accumulate(mask.voxels.begin(), mask.voxels.end(), std::size_t{0});
}

Mask Dilated(const Mask& mask, double radius_mm, int num_threads) {
  return Near(mask, 1, radius_mm, num_threads);
}

Mask Eroded(const Mask& mask, double radius_mm, int num_threads) {
  Mask eroded = Near(mask, 0, radius_mm, num_threads);
  for (auto& voxel : eroded.voxels) voxel ^= 1U;
  return eroded;
}

Mask Closed(const Mask& mask, double radius_mm, int num_threads) {
  return Eroded(Dilated(mask, radius_mm, num_threads), radius_mm, num_threads);
}

Mask Opened(const Mask& mask, double radius_mm, int num_threads) {
  return Dilated(Eroded(mask, radius_mm, num_threads), radius_mm, num_threads);
}

Components ConnectedComponents(const Mask& mask) {
  Components out{volume::Grid<std::int32_t>(mask.geometry), {0}};
  const auto& size = mask.geometry.size;
  auto& number = out.number.voxels;
  const auto row_stride = static_cast<std::size_t>(size[0]);
  const std::size_t slice_stride = mask.geometry.Index(0, 0, 1);
  DisjointSets sets;
  sets.Add();
  for (int k = 0; k < size[2]; ++k) {
    for (int j = 0; j < size[1]; ++j) {
      const std::size_t row = mask.geometry.Index(0, j, k);
      std::int32_t current = 0;
      for (std::size_t at = row; at < row + row_stride; ++at) {
        if (mask.voxels[at] == 0) {
          current = 0;
          continue;
        }
        const std::int32_t above = j > 0 ? number[at - row_stride] : 0;
        const std::int32_t below = k > 0 ? number[at - slice_stride] : 0;
        if (current == 0) current = above != 0 ? above : below != 0 ? below : sets.Add();
        if (above != 0 && above != current) sets.Join(above, current);
        if (below != 0 && below != current) sets.Join(below, current);
        number[at] = current;
      }
    }
  }
  std::vector<std::int32_t> final_number(sets.size(), 0);
  for (std::size_t s = 1; s < sets.size(); ++s) {
    const auto root = static_cast<std::size_t>(sets.Root(static_cast<std::int32_t>(s)));
    if (final_number[root] == 0) {
      final_number[root] = static_cast<std::int32_t>(out.num_voxels.size());
      out.num_voxels.push_back(0);
    }
    final_number[s] = final_number[root];
  }
  for (auto& n : number) {
    if (n == 0) continue;
    n = final_number[static_cast<std::size_t>(n)];
    ++out.num_voxels[static_cast<std::size_t>(n)];
  }
  return out;
}

Mask Kept(const Components& components, const std::function<bool(std::int32_t)>& keep) {
  std::vector<std::uint8_t> kept(components.num_voxels.size(), 0);
  for (std::size_t n = 1; n < kept.size(); ++n)
    kept[n] = keep(static_cast<std::int32_t>(n)) ? 1 : 0;
  Mask mask(components.number.geometry);
  for (std::size_t i = 0; i < mask.voxels.size(); ++i) {
    mask.voxels[i] = kept[static_cast<std::size_t>(components.number.voxels[i])];
  }
  return mask;
}

void FillInSlices(Mask& mask, int axis, int num_threads,
                  const std::function<bool(const SliceRegion&)>& accept) {
  const volume::Geometry& g = mask.geometry;
  const int u_axis = axis == 0 ? 1 : 0;
  const int v_axis = axis == 2 ? 1 : 2;
  const std::array<std::size_t, 3> stride = {1, static_cast<std::size_t>(g.size[0]),
                                             g.Index(0, 0, 1)};
  const int nu = g.size[u_axis];
  const int nv = g.size[v_axis];
  ParallelFor(g.size[axis], num_threads, [&](int slice) {
    const std::size_t base =
        stride[static_cast<std::size_t>(axis)] * static_cast<std::size_t>(slice);
    const auto index = [&](int u, int v) {
      return base + static_cast<std::size_t>(u) * stride[static_cast<std::size_t>(u_axis)] +
             static_cast<std::size_t>(v) * stride[static_cast<std::size_t>(v_axis)];
    };
    // 1 where nothing is to be done: mask, beyond the border, seen.
    const auto row = static_cast<std::size_t>(nu) + 2;
    std::vector<std::uint8_t> closed(row * (static_cast<std::size_t>(nv) + 2), 1);
    const auto at_closed = [row](int u, int v) {
      return static_cast<std::size_t>(v + 1) * row + static_cast<std::size_t>(u + 1);
    };
    for (int v = 0; v < nv; ++v) {
      for (int u = 0; u < nu; ++u) closed[at_closed(u, v)] = mask.voxels[index(u, v)];
    }
    std::vector<std::pair<int, int>> stack;
    const auto push = [&](int u, int v) {
      auto& flag = closed[at_closed(u, v)];
      if (flag != 0) return;
      flag = 1;
      stack.emplace_back(u, v);
    };
    SliceRegion region;
    for (int v0 = 0; v0 < nv; ++v0) {
      for (int u0 = 0; u0 < nu; ++u0) {
        if (closed[at_closed(u0, v0)] != 0) continue;
        region.voxels.clear();
        region.touches_border = false;
        push(u0, v0);
        while (!stack.empty()) {
          const auto [u, v] = stack.back();
          stack.pop_back();
          region.touches_border |= u == 0 || v == 0 || u == nu - 1 || v == nv - 1;
          region.voxels.push_back(index(u, v));
          push(u - 1, v);
          push(u + 1, v);
          push(u, v - 1);
          push(u, v + 1);
        }
        if (accept ? !accept(region) : region.touches_border) continue;
        for (const std::size_t at : region.voxels) mask.voxels[at] = 1;
      }
    }
  });
}

volume::Grid<float> DistanceMm(const Mask& mask, int num_threads) {
  const volume::Geometry& g = mask.geometry;
  volume::Grid<float> out(g);
  DistanceAlongRows(mask, 1, out.voxels, num_threads);
  for (const int axis : {1, 2}) {
    const int other = axis == 1 ? 2 : 1;
    const auto n = static_cast<std::size_t>(g.size[axis]);
    ParallelFor(g.size[other], num_threads, [&](int o) {
      std::vector<double> line(n);
      std::vector<double> result(n);
      std::vector<int> place(n);
      std::vector<double> begin(n);
      for (int i = 0; i < g.size[0]; ++i) {
        const std::size_t first = axis == 1 ? g.Index(i, 0, o) : g.Index(i, o, 0);
        const std::size_t stride =
            axis == 1 ? static_cast<std::size_t>(g.size[0]) : g.Index(0, 0, 1);
        for (std::size_t q = 0; q < n; ++q) line[q] = out.voxels[first + q * stride];
        EnvelopeAlongLine(line, g.spacing_mm[axis], place, begin, result);
        for (std::size_t q = 0; q < n; ++q)
          out.voxels[first + q * stride] = static_cast<float>(line[q]);
      }
    });
  }
  for (auto& voxel : out.voxels) {
    voxel = voxel >= kFar ? std::numeric_limits<float>::infinity() : std::sqrt(voxel);
  }
  return out;
}

Box BoundsOf(const Mask& mask) {
  Box box;
  box.low = mask.geometry.size;
  const auto& size = mask.geometry.size;
  for (int k = 0; k < size[2]; ++k) {
    for (int j = 0; j < size[1]; ++j) {
      const auto row =
          mask.voxels.begin() + static_cast<std::ptrdiff_t>(mask.geometry.Index(0, j, k));
      const auto end = row + size[0];
      const auto first = std::find(row, end, 1);
      if (first == end) continue;
      const auto last =
          std::find(std::make_reverse_iterator(end), std::make_reverse_iterator(row), 1);
      box.low = box.low.min(Eigen::Array3i(static_cast<int>(first - row), j, k));
      box.high = box.high.max(Eigen::Array3i(static_cast<int>(last.base() - row) - 1, j, k));
    }
  }
  return box;
}

}  // namespace acus::segmentation
