#include "acus/patient/meshing/material_field.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "acus/base/core/parallel.h"

namespace acus::meshing {

MaterialField::MaterialField(const volume::LabelMap& labels,
                             const MaterialOfLabel& material_of_label, int num_materials,
                             double spacing_mm, double smoothing_mm, double padding_mm,
                             int num_threads)
    : fields_(num_materials), offsets_(num_materials, 0.0) {
  const volume::Geometry& g = labels.geometry;
  Eigen::Array3i block;
  for (int d = 0; d < 3; ++d) {
    block[d] = std::max(1, static_cast<int>(std::lround(spacing_mm / g.spacing_mm[d])));
    spacing_[d] = g.spacing_mm[d] * block[d];
    padding_[d] = static_cast<int>(std::ceil(padding_mm / spacing_[d])) + 1;
    size_[d] = (g.size[d] + block[d] - 1) / block[d] + 2 * padding_[d];
    low_[d] = 0.5 * (block[d] - 1) * g.spacing_mm[d] - padding_[d] * spacing_[d];
  }
  Average(labels, material_of_label, block, num_threads);
  std::vector<double> voxels(num_materials, 0.0);
  for (int m = 0; m < num_materials; ++m) {
    for (const float value : fields_[m]) voxels[m] += value;
  }
  if (smoothing_mm > 0.0) Smooth(smoothing_mm, num_threads);
  MatchVolumes(voxels, num_threads);
  FindInterfaces();
}

void MaterialField::Average(const volume::LabelMap& labels,
                            const MaterialOfLabel& material_of_label, const Eigen::Array3i& block,
                            int num_threads) {
  const volume::Geometry& g = labels.geometry;
  const std::size_t count = Index(0, 0, size_[2]);
  for (auto& field : fields_) field.assign(count, 0.0F);
  const float share = 1.0F / static_cast<float>(block.prod());
  ParallelFor(size_[2], num_threads, [&](int k) {
    // Whatever the volume leaves of a block is outside.
    std::fill_n(fields_[0].begin() + static_cast<std::ptrdiff_t>(Index(0, 0, k)),
                static_cast<std::size_t>(size_[0]) * size_[1], 1.0F);
    const int first = (k - padding_[2]) * block[2];
    for (int vk = std::max(0, first); vk < std::min(first + block[2], g.size[2]); ++vk) {
      for (int vj = 0; vj < g.size[1]; ++vj) {
        for (int vi = 0; vi < g.size[0]; ++vi) {
          const std::uint8_t material = material_of_label[labels.At(vi, vj, vk)];
          if (material == 0) continue;
          const std::size_t at = Index(vi / block[0] + padding_[0], vj / block[1] + padding_[1], k);
          fields_[material][at] += share;
          fields_[0][at] -= share;
        }
      }
    }
  });
}

void MaterialField::Smooth(double smoothing_mm, int num_threads) {
  for (auto& field : fields_) {
    for (int axis = 0; axis < 3; ++axis) {
      const double sigma = smoothing_mm / spacing_[axis];
      const int radius = static_cast<int>(std::ceil(3.0 * sigma));
      std::vector<float> kernel(2 * radius + 1);
      float sum = 0.0F;
      for (int r = -radius; r <= radius; ++r) {
        kernel[r + radius] = static_cast<float>(std::exp(-0.5 * r * r / (sigma * sigma)));
        sum += kernel[r + radius];
      }
      for (float& value : kernel) value /= sum;
      const std::size_t step = axis == 0 ? 1 : axis == 1 ? size_[0] : Index(0, 0, 1);
      const int length = size_[axis];
      const int outer = axis == 2 ? size_[1] : size_[2];
      const int inner = axis == 0 ? size_[1] : size_[0];
      ParallelFor(outer, num_threads, [&](int o) {
        std::vector<float> line(length);
        for (int i = 0; i < inner; ++i) {
          const std::size_t start = axis == 0   ? Index(0, i, o)
                                    : axis == 1 ? Index(i, 0, o)
                                                : Index(i, o, 0);
          for (int n = 0; n < length; ++n) line[n] = field[start + n * step];
          for (int n = 0; n < length; ++n) {
            float value = 0.0F;
            for (int r = -radius; r <= radius; ++r) {
              value += kernel[r + radius] * line[std::clamp(n + r, 0, length - 1)];
            }
            field[start + n * step] = value;
          }
        }
      });
    }
  }
}

void MaterialField::MatchVolumes(const std::vector<double>& voxels_of_material, int num_threads) {
  // One material against the rest: phi > t holds as much volume as before smoothing, and
  // phi - (1 - phi) + b > 0 is phi > (1 - b) / 2.
  constexpr int kBins = 4096;
  ParallelFor(num_materials(), num_threads, [&](int m) {
    if (m == 1) return;  // The rest takes what the others leave.
    std::vector<double> histogram(kBins + 1, 0.0);
    AddToHistogram(fields_[m], histogram);
    // Outside has no end: there, what is not outside is counted.
    double voxels = voxels_of_material[m];
    if (m == 0) {
      voxels = static_cast<double>(fields_[0].size()) - voxels;
      std::ranges::reverse(histogram);
    }
    double above = 0.0;
    int bin = kBins;
    while (bin > 0 && above < voxels) above += histogram[bin--];
    if (m == 0) bin = kBins - 1 - bin;
    const double threshold = std::clamp((bin + 1.0) / kBins, 0.2, 0.8);
    offsets_[m] = 1.0 - 2.0 * threshold;
  });
}

void MaterialField::AddToHistogram(const std::vector<float>& field,
                                   std::vector<double>& histogram) const {
  // Voxels count by their values at such places between their centre and the next ones: where
  // slices are far apart the field falls from 1 to 0 within one voxel.
  constexpr std::array<double, 4> kPlaces = {0.125, 0.375, 0.625, 0.875};
  const double num_bins = static_cast<double>(histogram.size()) - 1.0;
  const auto add = [&](double value, double volume) {
    histogram[static_cast<std::size_t>(std::clamp(value, 0.0, 1.0) * num_bins)] += volume;
  };
  for (int k = 0; k + 1 < size_[2]; ++k) {
    for (int j = 0; j + 1 < size_[1]; ++j) {
      for (int i = 0; i + 1 < size_[0]; ++i) {
        std::array<double, 8> corner;
        for (int c = 0; c < 8; ++c) {
          corner[c] = field[Index(i + (c & 1), j + ((c >> 1) & 1), k + ((c >> 2) & 1))];
        }
        const auto [low, high] = std::ranges::minmax(corner);
        if (high - low < 1e-3) {
          add(corner[0], 1.0);
          continue;
        }
        for (const double w : kPlaces) {
          for (const double v : kPlaces) {
            const double a = std::lerp(std::lerp(corner[0], corner[2], v),
                                       std::lerp(corner[4], corner[6], v), w);
            const double b = std::lerp(std::lerp(corner[1], corner[3], v),
                                       std::lerp(corner[5], corner[7], v), w);
            for (const double u : kPlaces) add(std::lerp(a, b, u), 1.0 / 64.0);
          }
        }
      }
    }
  }
}

void MaterialField::FindInterfaces() {
  material_.assign(fields_[0].size(), 0);
  for (std::size_t n = 0; n < material_.size(); ++n) {
    double best = fields_[0][n] + offsets_[0];
    for (int m = 1; m < num_materials(); ++m) {
      const double value = fields_[m][n] + offsets_[m];
      if (value > best) {
        best = value;
        material_[n] = static_cast<std::uint8_t>(m);
      }
    }
  }
  const Eigen::Vector3i table = size_ + Eigen::Vector3i::Ones();
  const auto at = [&](int i, int j, int k) {
    return (static_cast<std::size_t>(k) * table[1] + j) * table[0] + i;
  };
  for (auto& counts : counts_) counts.assign(at(0, 0, table[2]), 0);
  for (int k = 0; k < size_[2]; ++k) {
    for (int j = 0; j < size_[1]; ++j) {
      std::array<std::int32_t, 3> row{};
      for (int i = 0; i < size_[0]; ++i) {
        const std::uint8_t here = material_[Index(i, j, k)];
        std::array<bool, 3> is{here != 0, false, false};
        for (int d = 0; d < 3; ++d) {
          Eigen::Vector3i next(i, j, k);
          if (++next[d] >= size_[d]) continue;
          const std::uint8_t there = material_[Index(next[0], next[1], next[2])];
          is[1] = is[1] || (here != there && (here == 0 || there == 0));
          is[2] = is[2] || (here != there && here != 0 && there != 0);
        }
        for (int w = 0; w < 3; ++w) {
          row[w] += is[w];
          counts_[w][at(i + 1, j + 1, k + 1)] = row[w] + counts_[w][at(i + 1, j, k + 1)] +
                                                counts_[w][at(i + 1, j + 1, k)] -
                                                counts_[w][at(i + 1, j, k)];
        }
      }
    }
  }
}

bool MaterialField::BoxHolds(const Eigen::Vector3d& low, const Eigen::Vector3d& high,
                             What what) const {
  Eigen::Vector3i from;
  Eigen::Vector3i to;  // Exclusive.
  for (int d = 0; d < 3; ++d) {
    from[d] =
        std::clamp(static_cast<int>(std::floor((low[d] - low_[d]) / spacing_[d])), 0, size_[d]);
    to[d] =
        std::clamp(static_cast<int>(std::ceil((high[d] - low_[d]) / spacing_[d])) + 1, 0, size_[d]);
    if (from[d] >= to[d]) return false;
  }
  const auto& c = counts_[static_cast<std::size_t>(what)];
  const auto at = [&](int i, int j, int k) {
    return c[(static_cast<std::size_t>(k) * (size_[1] + 1) + j) * (size_[0] + 1) + i];
  };
  return at(to[0], to[1], to[2]) - at(from[0], to[1], to[2]) - at(to[0], from[1], to[2]) -
             at(to[0], to[1], from[2]) + at(from[0], from[1], to[2]) + at(from[0], to[1], from[2]) +
             at(to[0], from[1], from[2]) - at(from[0], from[1], from[2]) >
         0;
}

Eigen::Vector3d MaterialField::high_mm() const {
  return low_ + (size_ - Eigen::Vector3i::Ones()).cast<double>().cwiseProduct(spacing_);
}

MaterialField::Cell MaterialField::Locate(const Eigen::Vector3d& x) const {
  Eigen::Vector3i base;
  Eigen::Vector3d f;
  for (int d = 0; d < 3; ++d) {
    const double u = std::clamp((x[d] - low_[d]) / spacing_[d], 0.0, size_[d] - 1.0);
    base[d] = std::min(static_cast<int>(u), size_[d] - 2);
    f[d] = u - base[d];
  }
  Cell out;
  const std::size_t first = Index(base[0], base[1], base[2]);
  const std::size_t row = size_[0];
  const std::size_t slice = row * size_[1];
  for (int c = 0; c < 8; ++c) {
    out.index[c] = first + (c & 1) + ((c >> 1) & 1) * row + ((c >> 2) & 1) * slice;
    out.weight[c] =
        ((c & 1) ? f[0] : 1 - f[0]) * ((c & 2) ? f[1] : 1 - f[1]) * ((c & 4) ? f[2] : 1 - f[2]);
  }
  return out;
}

double MaterialField::Sample(const Cell& cell, int material) const {
  double value = offsets_[material];
  for (int c = 0; c < 8; ++c) value += cell.weight[c] * fields_[material][cell.index[c]];
  return value;
}

int MaterialField::MaterialAt(const Eigen::Vector3d& x) const {
  const Cell cell = Locate(x);
  int best = 0;
  double best_value = Sample(cell, 0);
  for (int m = 1; m < num_materials(); ++m) {
    const double value = Sample(cell, m);
    if (value > best_value) {
      best_value = value;
      best = m;
    }
  }
  return best;
}

double MaterialField::Value(const Eigen::Vector3d& x, int material) const {
  return Sample(Locate(x), material);
}

double MaterialField::Difference(const Eigen::Vector3d& x, int a, int b) const {
  const Cell cell = Locate(x);
  return Sample(cell, a) - Sample(cell, b);
}

Eigen::Vector3d MaterialField::Gradient(const Eigen::Vector3d& x, int a, int b) const {
  Eigen::Vector3d out;
  for (int d = 0; d < 3; ++d) {
    // Over a whole voxel: the trilinear slope jumps from cell to cell.
    const double h = 0.5 * spacing_[d];
    Eigen::Vector3d low = x;
    Eigen::Vector3d high = x;
    low[d] -= h;
    high[d] += h;
    out[d] = (Difference(high, a, b) - Difference(low, a, b)) / (2.0 * h);
  }
  return out;
}

bool MaterialField::Project(Eigen::Vector3d& x, int a, int b, double reach_mm) const {
  const Eigen::Vector3d start = x;
  for (int step = 0; step < 6; ++step) {
    const double value = Difference(x, a, b);
    if (std::abs(value) < 1e-3) return true;
    const Eigen::Vector3d slope = Gradient(x, a, b);
    const double squared = slope.squaredNorm();
    if (squared < 1e-8) return false;
    x -= value / squared * slope;
    if (!((x - start).squaredNorm() <= reach_mm * reach_mm)) return false;
  }
  return std::abs(Difference(x, a, b)) < 0.02;
}

}  // namespace acus::meshing
