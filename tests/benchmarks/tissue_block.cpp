#include "benchmarks/tissue_block.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "acus/base/config/json_file.h"
#include "acus/base/core/error.h"
#include "acus/data/volume/labels.h"

namespace acus::benchmarks {
namespace {

constexpr double kGrowth = 1.5;

struct Layer {
  double bottom_mm;  ///< Below the skin.
  const char* tissue;
};
constexpr std::array<Layer, 4> kLayers = {
    {{4.0, "skin"}, {20.0, "fat"}, {36.0, "muscle"}, {TissueBlock::kDepthMm, "liver"}}};

/// Appends places from places.back() to `end` whose steps grow from `step`; the last fills up.
void Grow(std::vector<double>& places, double step, double end) {
  while (true) {
    step *= kGrowth;
    if (places.back() + 1.6 * step >= end) break;
    places.push_back(places.back() + step);
  }
  places.push_back(end);
}

std::vector<double> Across(double element_mm) {
  std::vector<double> half;
  const int count = static_cast<int>(std::lround(TissueBlock::kFineHalfWidthMm / element_mm));
  for (int n = 0; n <= count; ++n) half.push_back(TissueBlock::kFineHalfWidthMm * n / count);
  Grow(half, TissueBlock::kFineHalfWidthMm / count, TissueBlock::kHalfWidthMm);
  std::vector<double> out;
  for (std::size_t n = half.size() - 1; n > 0; --n) out.push_back(-half[n]);
  out.insert(out.end(), half.begin(), half.end());
  return out;
}

/// Depths below the skin, with every interface among them.
std::vector<double> Down(double element_mm) {
  std::vector<double> out{0.0};
  const auto divide_to = [&](double bottom) {
    const double top = out.back();
    const int count = std::max(1, static_cast<int>(std::lround((bottom - top) / element_mm)));
    for (int n = 1; n <= count; ++n) out.push_back(top + (bottom - top) * n / count);
  };
  for (const Layer& layer : kLayers)
    divide_to(std::min(layer.bottom_mm, TissueBlock::kFineDepthMm));
  Grow(out, element_mm, TissueBlock::kDepthMm);
  return out;
}

}  // namespace

volume::Label TissueBlock::TissueAt(const Eigen::Vector3d& x_mm) {
  // Once: a look-up by name is too slow for the step of a model.
  static const std::array<volume::Label, kLayers.size()> labels = [] {
    std::array<volume::Label, kLayers.size()> out{};
    for (std::size_t n = 0; n < out.size(); ++n) out[n] = volume::LabelOf(kLayers[n].tissue);
    return out;
  }();
  const double depth_mm = -x_mm[2];
  if (depth_mm < 0.0 || x_mm.head<2>().cwiseAbs().maxCoeff() > kHalfWidthMm) return 0;
  for (std::size_t n = 0; n < labels.size(); ++n) {
    if (depth_mm < kLayers[n].bottom_mm) return labels[n];
  }
  return 0;
}

mesh::TetraMesh TissueBlock::Mesh(double element_mm, volume::Label one_tissue) {
  const std::vector<double> across = Across(element_mm);
  const std::vector<double> down = Down(element_mm);
  const int n = static_cast<int>(across.size());
  const int layers = static_cast<int>(down.size());
  mesh::TetraMesh out;
  out.nodes_mm.resize(3, static_cast<Eigen::Index>(n) * n * layers);
  out.fixed_nodes.assign(static_cast<std::size_t>(out.nodes_mm.cols()), 0);
  const auto number = [&](const Eigen::Vector3i& p) { return (p[2] * n + p[1]) * n + p[0]; };
  Eigen::Vector3i p;
  for (p[2] = 0; p[2] < layers; ++p[2]) {
    for (p[1] = 0; p[1] < n; ++p[1]) {
      for (p[0] = 0; p[0] < n; ++p[0]) {
        out.nodes_mm.col(number(p)) << across[p[0]], across[p[1]], -down[p[2]];
        out.fixed_nodes[number(p)] = p[2] == layers - 1;
      }
    }
  }
  // Six tetrahedra around the diagonal of each brick: z runs down, so odd orders of the axes have
  // positive volume.
  constexpr std::array<std::array<int, 3>, 6> kOrders = {
      {{0, 2, 1}, {2, 1, 0}, {1, 0, 2}, {0, 1, 2}, {1, 2, 0}, {2, 0, 1}}};
  out.tetrahedra.resize(4, 6LL * (n - 1) * (n - 1) * (layers - 1));
  Eigen::Index count = 0;
  for (p[2] = 0; p[2] + 1 < layers; ++p[2]) {
    const double middle_mm = -0.5 * (down[p[2]] + down[p[2] + 1]);
    const volume::Label tissue = one_tissue != 0 ? one_tissue : TissueAt({0.0, 0.0, middle_mm});
    for (p[1] = 0; p[1] + 1 < n; ++p[1]) {
      for (p[0] = 0; p[0] + 1 < n; ++p[0]) {
        for (std::size_t o = 0; o < kOrders.size(); ++o) {
          Eigen::Vector3i corner = p;
          Eigen::Vector4i tetrahedron(number(p), 0, 0, 0);
          for (int c = 0; c < 3; ++c) {
            ++corner[kOrders[o][c]];
            tetrahedron[c + 1] = number(corner);
          }
          if (o >= 3) std::swap(tetrahedron[2], tetrahedron[3]);
          out.tetrahedra.col(count++) = tetrahedron;
          out.tissue.push_back(tissue);
        }
      }
    }
  }
  return out;
}

TissueBlockTables TissueBlockTables::FromPresets(Provenance& provenance) {
  const auto preset = [&](const char* name) {
    const std::filesystem::path path = config::FindConfig(name, ".");
    provenance.AddInput(path);
    return path;
  };
  return {forces::ReadForceTable(preset("forces/bovine_2021.json")),
          forces::ReadNeedle(preset("needles/trocar_18g.json")),
          mechanics::ReadElasticityTable(preset("elasticity/default.json"))};
}

double SquarePressureMmPerN(const mechanics::ElasticTissue& tissue, double half_mm, double x_mm,
                            double y_mm) {
  // The integral of 1/r over a rectangle from the place to a corner at (a, b).
  const auto corner = [](double a, double b) {
    const double r = std::hypot(a, b);
    double out = 0.0;
    if (a != 0.0) out += a * std::asinh(b / std::abs(a));
    if (b != 0.0) out += b * std::asinh(a / std::abs(b));
    return r > 0.0 ? out : 0.0;
  };
  const double left = -half_mm - x_mm, right = half_mm - x_mm;
  const double low = -half_mm - y_mm, high = half_mm - y_mm;
  const double integral_mm =
      corner(right, high) - corner(left, high) - corner(right, low) + corner(left, low);
  const double pressure_mpa = 1.0 / (4.0 * half_mm * half_mm);
  const double nu = tissue.poissons_ratio;
  return (1.0 - nu * nu) / (std::numbers::pi * tissue.youngs_modulus_mpa) * pressure_mpa *
         integral_mm;
}

}  // namespace acus::benchmarks
