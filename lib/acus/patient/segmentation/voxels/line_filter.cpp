#include "acus/patient/segmentation/voxels/line_filter.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "acus/base/core/parallel.h"

namespace acus::segmentation {
namespace {

constexpr double kKernelSigmas = 3.5;  ///< Half the length of a kernel.

/// Half of a symmetric kernel, its sum over both halves 1.
std::vector<float> GaussianKernel(double sigma_voxels) {
  const int reach = static_cast<int>(std::ceil(kKernelSigmas * sigma_voxels));
  std::vector<double> weight;
  double sum = 0.0;
  for (int n = 0; n <= reach; ++n) {
    weight.push_back(std::exp(-0.5 * n * n / (sigma_voxels * sigma_voxels)));
    sum += n == 0 ? weight.back() : 2.0 * weight.back();
  }
  std::vector<float> kernel;
  for (const double w : weight) kernel.push_back(static_cast<float>(w / sum));
  return kernel;
}

/// Blurs `count` values that lie `stride` apart.
void BlurLine(float* values, int count, std::size_t stride, const std::vector<float>& kernel,
              std::vector<float>& line) {
  const int reach = static_cast<int>(kernel.size()) - 1;
  line.resize(static_cast<std::size_t>(count + 2 * reach));
  for (int n = 0; n < count + 2 * reach; ++n) {
    const int from = std::clamp(n - reach, 0, count - 1);
    line[static_cast<std::size_t>(n)] = values[static_cast<std::size_t>(from) * stride];
  }
  for (int n = 0; n < count; ++n) {
    const float* middle = line.data() + n + reach;
    float sum = kernel[0] * middle[0];
    for (int d = 1; d <= reach; ++d) {
      sum += kernel[static_cast<std::size_t>(d)] * (middle[d] + middle[-d]);
    }
    values[static_cast<std::size_t>(n) * stride] = sum;
  }
}

void BlurAlong(volume::Grid<float>& image, int axis, double sigma_mm, int num_threads) {
  const volume::Geometry& g = image.geometry;
  const std::vector<float> kernel = GaussianKernel(sigma_mm / g.spacing_mm[axis]);
  const std::size_t stride[] = {1, g.Index(0, 1, 0), g.Index(0, 0, 1)};
  const int slow = axis == 2 ? 1 : 2;  // Lines are numbered by these two axes.
  const int fast = 3 - axis - slow;
  ParallelFor(g.size[slow], num_threads, [&](int s) {
    std::vector<float> line;
    for (int f = 0; f < g.size[fast]; ++f) {
      float* first = image.voxels.data() + static_cast<std::size_t>(s) * stride[slow] +
                     static_cast<std::size_t>(f) * stride[fast];
      BlurLine(first, g.size[axis], stride[axis], kernel, line);
    }
  });
}

/// The Hessian at a voxel by central differences, per mm^2; beyond the border as at it.
Eigen::Matrix3d HessianAt(const volume::Grid<float>& image, const Eigen::Array3i& at) {
  const volume::Geometry& g = image.geometry;
  const auto value = [&](const Eigen::Array3i& voxel) {
    const Eigen::Array3i v = voxel.max(0).min(g.size - 1);
    return static_cast<double>(image.At(v[0], v[1], v[2]));
  };
  Eigen::Matrix3d hessian;
  for (int a = 0; a < 3; ++a) {
    const Eigen::Array3i da = Eigen::Vector3i::Unit(a).array();
    hessian(a, a) =
        (value(at + da) - 2.0 * value(at) + value(at - da)) / (g.spacing_mm[a] * g.spacing_mm[a]);
    for (int b = 0; b < a; ++b) {
      const Eigen::Array3i db = Eigen::Vector3i::Unit(b).array();
      hessian(a, b) = hessian(b, a) =
          (value(at + da + db) - value(at + da - db) - value(at - da + db) + value(at - da - db)) /
          (4.0 * g.spacing_mm[a] * g.spacing_mm[b]);
    }
  }
  return hessian;
}

}  // namespace

volume::Grid<float> Blurred(const volume::Grid<float>& image, double sigma_mm, int num_threads) {
  volume::Grid<float> out = image;
  for (int axis = 0; axis < 3; ++axis) BlurAlong(out, axis, sigma_mm, num_threads);
  return out;
}

volume::Grid<float> LineResponse(const volume::Grid<float>& image, const Mask& where,
                                 double sigma_mm, int num_threads) {
  const volume::Grid<float> blurred = Blurred(image, sigma_mm, num_threads);
  const volume::Geometry& g = image.geometry;
  volume::Grid<float> response(g);
  ParallelFor(g.size[2], num_threads, [&](int k) {
    for (int j = 0; j < g.size[1]; ++j) {
      for (int i = 0; i < g.size[0]; ++i) {
        if (where.At(i, j, k) == 0) continue;
        Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
        solver.computeDirect(HessianAt(blurred, {i, j, k}), Eigen::EigenvaluesOnly);
        const double middle = solver.eigenvalues()[1];  // Sorted, the least first.
        response.At(i, j, k) = static_cast<float>(-std::numbers::e * sigma_mm * sigma_mm * middle);
      }
    }
  });
  return response;
}

}  // namespace acus::segmentation
