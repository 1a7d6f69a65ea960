#include "acus/patient/atlas/minimal_cut.h"

#include <algorithm>
#include <cmath>

#include "acus/base/core/parallel.h"

namespace acus::atlas {
namespace {

// Their product times the squared norm of the gradient, 12, is below 1: the iteration converges.
constexpr float kPrimalStep = 0.25F, kDualStep = 0.3F;

struct Flow {
  std::vector<float> x, y, z;
};

}  // namespace

volume::Grid<float> MinimalCut(const volume::Grid<float>& preference,
                               const volume::Grid<float>& surface_cost, int iterations,
                               int num_threads) {
  const volume::Geometry& g = preference.geometry;
  const Eigen::Array3i size = g.size;
  const std::size_t row = static_cast<std::size_t>(size[0]);
  const std::size_t slice = row * static_cast<std::size_t>(size[1]);
  volume::Grid<float> u(g, 0.5F);
  std::vector<float> ahead = u.voxels;
  Flow flow{.x = std::vector<float>(ahead.size()),
            .y = std::vector<float>(ahead.size()),
            .z = std::vector<float>(ahead.size())};
  const auto limit_flow = [&](int k) {
    for (int j = 0; j < size[1]; ++j) {
      for (int i = 0; i < size[0]; ++i) {
        const std::size_t n = g.Index(i, j, k);
        const float here = ahead[n];
        const float x = flow.x[n] + kDualStep * (i + 1 < size[0] ? ahead[n + 1] - here : 0.0F);
        const float y = flow.y[n] + kDualStep * (j + 1 < size[1] ? ahead[n + row] - here : 0.0F);
        const float z = flow.z[n] + kDualStep * (k + 1 < size[2] ? ahead[n + slice] - here : 0.0F);
        const float length = std::sqrt(x * x + y * y + z * z);
        const float most = surface_cost.voxels[n];
        const float scale = length > most ? most / length : 1.0F;
        flow.x[n] = scale * x;
        flow.y[n] = scale * y;
        flow.z[n] = scale * z;
      }
    }
  };
  const auto move_region = [&](int k) {
    for (int j = 0; j < size[1]; ++j) {
      for (int i = 0; i < size[0]; ++i) {
        const std::size_t n = g.Index(i, j, k);
        const float divergence = flow.x[n] - (i > 0 ? flow.x[n - 1] : 0.0F) + flow.y[n] -
                                 (j > 0 ? flow.y[n - row] : 0.0F) + flow.z[n] -
                                 (k > 0 ? flow.z[n - slice] : 0.0F);
        const float next =
            std::clamp(u.voxels[n] + kPrimalStep * (divergence + preference.voxels[n]), 0.0F, 1.0F);
        ahead[n] = 2.0F * next - u.voxels[n];
        u.voxels[n] = next;
      }
    }
  };
  for (int iteration = 0; iteration < iterations; ++iteration) {
    ParallelFor(size[2], num_threads, limit_flow);
    ParallelFor(size[2], num_threads, move_region);
  }
  return u;
}

}  // namespace acus::atlas
