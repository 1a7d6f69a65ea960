#include "acus/physics/tissue/tip_kernel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <tuple>

#include "acus/data/mesh/quality.h"
#include "acus/data/mesh/tetra_faces.h"

namespace acus::tissue {
namespace {

constexpr std::array<double, 6> kSpacingsMm = {0.0, 2.0, 2.7, 4.0, 5.5, 7.5};
constexpr double kSpacingsPerRadius = 2.7;
/// A force on one node moves it so many times as far as if it were spread over a ball of the volume
/// that the node stands for. Found on boxes with cells of 1.5 to 3 mm.
constexpr double kNodeOverBall = 1.75;

/// What every node of the mesh stands for.
struct NodeShares {
  std::vector<double> volume_mm3, area_mm2;
};

NodeShares SharesOf(const mesh::TetraMesh& mesh) {
  const std::size_t count = static_cast<std::size_t>(mesh.nodes_mm.cols());
  NodeShares out{std::vector<double>(count, 0.0), std::vector<double>(count, 0.0)};
  for (Eigen::Index t = 0; t < mesh.tetrahedra.cols(); ++t) {
    const double volume_mm3 = std::abs(mesh::VolumeMm3(mesh::CornersOf(mesh, t)));
    for (const int node : mesh.tetrahedra.col(t)) {
      out.volume_mm3[static_cast<std::size_t>(node)] += 0.25 * volume_mm3;
    }
  }
  const std::vector<mesh::TetraFace> faces = mesh::SortedFaces(mesh);
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const bool is_inner = (f > 0 && faces[f].IsSameFace(faces[f - 1])) ||
                          (f + 1 < faces.size() && faces[f].IsSameFace(faces[f + 1]));
    if (is_inner) continue;
    const Eigen::Vector3d a = mesh.nodes_mm.col(faces[f].nodes[0]);
    const Eigen::Vector3d b = mesh.nodes_mm.col(faces[f].nodes[1]);
    const Eigen::Vector3d c = mesh.nodes_mm.col(faces[f].nodes[2]);
    const double third_mm2 = (b - a).cross(c - a).norm() / 6.0;
    for (const int node : faces[f].nodes) out.area_mm2[static_cast<std::size_t>(node)] += third_mm2;
  }
  return out;
}

/// Those of the places that are at least `spacing_mm` apart, chosen by place alone, whatever their
/// numbers; ascending.
std::vector<int> Thinned(const std::vector<Eigen::Vector3d>& place_mm, std::vector<int> rows,
                         double spacing_mm) {
  std::ranges::sort(rows, {}, [&](int row) {
    const Eigen::Vector3d& x = place_mm[static_cast<std::size_t>(row)];
    return std::tuple(x.z(), x.y(), x.x());
  });
  std::vector<int> kept;
  for (const int row : rows) {
    const auto is_near = [&](int other) {
      return (place_mm[static_cast<std::size_t>(other)] - place_mm[static_cast<std::size_t>(row)])
                 .norm() < spacing_mm;
    };
    if (std::none_of(kept.rbegin(), kept.rend(), is_near)) kept.push_back(row);
  }
  std::ranges::sort(kept);
  return kept;
}

/// The nearest of `kept` other than `self`, as a place in the list; its distance.
std::pair<std::size_t, double> Nearest(const std::vector<Eigen::Vector3d>& kept_mm,
                                       const Eigen::Vector3d& x_mm, std::size_t self) {
  std::pair<std::size_t, double> best{0, std::numeric_limits<double>::infinity()};
  for (std::size_t k = 0; k < kept_mm.size(); ++k) {
    const double distance2 = (kept_mm[k] - x_mm).squaredNorm();
    if (k != self && distance2 < best.second) best = {k, distance2};
  }
  best.second = std::sqrt(best.second);
  return best;
}

constexpr std::size_t kNoSelf = std::numeric_limits<std::size_t>::max();

}  // namespace

struct TipKernel::Quadrature {
  const mesh::TetraMesh& mesh;
  const mechanics::Compliance& compliance;
  const std::vector<Eigen::Vector3d>& rest_of_row;
  const std::vector<double>& share;  ///< By mesh node.
  bool is_volume;

  /// Every node of the mesh counts for the nearest row, if that is no farther than rows are apart.
  Level LevelOf(const std::vector<int>& rows, double spacing_mm) const {
    Level out;
    out.spacing_mm = spacing_mm;
    std::vector<Eigen::Vector3d> kept_mm;
    for (const int row : rows) kept_mm.push_back(rest_of_row[static_cast<std::size_t>(row)]);
    std::vector<double> reach_mm;
    for (std::size_t k = 0; k < kept_mm.size(); ++k) {
      reach_mm.push_back(std::max(spacing_mm, Nearest(kept_mm, kept_mm[k], k).second));
      out.node.push_back({kept_mm[k], rows[k], 0.0, 0.0});
    }
    Eigen::AlignedBox3d box;
    for (const Eigen::Vector3d& x : kept_mm) box.extend(x);
    for (int node = 0; node < static_cast<int>(mesh.nodes_mm.cols()); ++node) {
      const std::size_t at = static_cast<std::size_t>(node);
      const Eigen::Vector3d x = mesh.nodes_mm.col(node);
      if (share[at] <= 0.0 || box.exteriorDistance(x) > kSpacingsMm.back()) continue;
      if (mesh.fixed_nodes[at] != 0) {
        out.node.push_back({x, -1, share[at], 0.0});
        continue;
      }
      const auto [nearest, distance_mm] = Nearest(kept_mm, x, kNoSelf);
      if (distance_mm <= reach_mm[nearest]) out.node[nearest].share += share[at];
    }
    if (!is_volume) return out;
    for (std::size_t k = 0; k < rows.size(); ++k) {
      const auto radius_mm = [](double mm3) { return std::cbrt(0.75 * mm3 / std::numbers::pi); };
      const double own_mm = radius_mm(share[static_cast<std::size_t>(compliance.nodes()[rows[k]])]);
      const double all_mm = radius_mm(out.node[k].share);
      // All nodes of the ball would move it by a ball's 6/5r, and each itself by more.
      const double own_share = own_mm * own_mm / (all_mm * all_mm);
      const double due = (1.0 + (kNodeOverBall - 1.0) * own_share) / all_mm;
      out.node[k].self_per_mm = std::min(0.0, 1.2 * (due - kNodeOverBall / own_mm));
    }
    return out;
  }
};

TipKernel::TipKernel(const mesh::TetraMesh& mesh, const mechanics::Compliance& compliance) {
  const NodeShares shares = SharesOf(mesh);
  std::vector<int> all_rows, outer_rows;
  for (int row = 0; row < compliance.num_nodes(); ++row) {
    const int node = compliance.nodes()[static_cast<std::size_t>(row)];
    rest_of_row_.push_back(mesh.nodes_mm.col(node));
    all_rows.push_back(row);
    if (shares.area_mm2[static_cast<std::size_t>(node)] > 0.0) outer_rows.push_back(row);
  }
  const Quadrature ball{mesh, compliance, rest_of_row_, shares.volume_mm3, true};
  const Quadrature disc{mesh, compliance, rest_of_row_, shares.area_mm2, false};
  for (const double spacing_mm : kSpacingsMm) {
    volume_.push_back(ball.LevelOf(Thinned(rest_of_row_, all_rows, spacing_mm), spacing_mm));
    surface_.push_back(disc.LevelOf(Thinned(rest_of_row_, outer_rows, spacing_mm), spacing_mm));
  }
}

KernelPlace TipKernel::Sum(const std::vector<Level>& levels, const Eigen::Vector3d& rest_in_ct_mm,
                           double radius_mm) noexcept {
  KernelPlace out;
  // The coarsest that is fine enough, or the next ones if those are still too many.
  std::size_t l = levels.size() - 1;
  while (l > 0 && levels[l].spacing_mm > radius_mm / kSpacingsPerRadius) --l;
  for (; l < levels.size(); ++l) {
    out = {};
    double sum = 0.0;
    bool is_full = false;
    for (const Node& node : levels[l].node) {
      const double inside =
          1.0 - (node.rest_in_ct_mm - rest_in_ct_mm).squaredNorm() / (radius_mm * radius_mm);
      if (!(inside > 0.0)) continue;
      const double weight = node.share * inside * inside;
      sum += weight;
      if (node.row < 0 || weight <= 0.0) continue;
      is_full = out.place.num_rows == ContactPlace::kMostRows;
      if (is_full) break;
      const std::size_t n = static_cast<std::size_t>(out.place.num_rows++);
      out.place.row[n] = node.row;
      out.place.weight[n] = weight;
      out.self_per_mm += weight * weight * node.self_per_mm;
    }
    if (is_full && l + 1 < levels.size()) continue;
    if (!(sum > 0.0)) return {};
    for (int n = 0; n < out.place.num_rows; ++n)
      out.place.weight[static_cast<std::size_t>(n)] /= sum;
    out.self_per_mm /= sum * sum;
    return out;
  }
  return out;
}

KernelPlace TipKernel::Ball(const Eigen::Vector3d& rest_in_ct_mm, double radius_mm) const noexcept {
  return Sum(volume_, rest_in_ct_mm, radius_mm);
}

KernelPlace TipKernel::Disc(const Eigen::Vector3d& rest_in_ct_mm, double radius_mm) const noexcept {
  return Sum(surface_, rest_in_ct_mm, radius_mm);
}

}  // namespace acus::tissue
