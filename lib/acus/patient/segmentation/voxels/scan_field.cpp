#include "acus/patient/segmentation/voxels/scan_field.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "acus/base/core/parallel.h"
#include "acus/base/core/random.h"
#include "acus/patient/segmentation/segmenters/tissues.h"

namespace acus::segmentation {
namespace {

constexpr int kNumSlicesLookedAt = 16;
constexpr std::int16_t kPaddedAirHu = -1024;
constexpr double kDenseHu = -300.0;  ///< Tissue; next to padding in one step, it has been cut off.
constexpr std::size_t kFewestEdges = 60;
constexpr int kNumTrials = 400;
constexpr double kLeastRadiusMm = 40.0;
constexpr double kMostRadiusMm = 500.0;
constexpr double kShareOfPaddingEdges = 0.9;
constexpr double kShareOfHardEdges = 0.7;
constexpr double kMostDenseBeyond = 1e-4;  ///< Share of dense voxels that may lie beyond.
constexpr double kToleranceVoxels = 1.2;
constexpr double kEdgeVoxels = 1.5;  ///< The circle is found to within that.

/// The axial slices of a volume in two directions u and v.
struct SliceView {
  explicit SliceView(const volume::Geometry& g)
      : axis(AxialAxis(g)),
        u(axis == 0 ? 1 : 0),
        v(axis == 2 ? 1 : 2),
        stride{1, static_cast<std::size_t>(g.size[0]), g.Index(0, 0, 1)},
        num_u(g.size[u]),
        num_v(g.size[v]),
        num_slices(g.size[axis]),
        spacing_mm(g.spacing_mm[u], g.spacing_mm[v]) {}

  std::size_t At(int slice, int iu, int iv) const {
    return static_cast<std::size_t>(slice) * stride[static_cast<std::size_t>(axis)] +
           static_cast<std::size_t>(iu) * stride[static_cast<std::size_t>(u)] +
           static_cast<std::size_t>(iv) * stride[static_cast<std::size_t>(v)];
  }
  Eigen::Vector2d PlaceMm(int iu, int iv) const { return {iu * spacing_mm[0], iv * spacing_mm[1]}; }

  int axis, u, v;
  std::array<std::size_t, 3> stride;
  int num_u, num_v, num_slices;
  Eigen::Array2d spacing_mm;
};

/// The voxels of a slice that have exactly `hu` and are connected with its border: 1 by u + v
/// num_u.
std::vector<std::uint8_t> PaddingOf(const volume::CtVolume& ct, const SliceView& view, int slice,
                                    std::int16_t hu) {
  std::vector<std::uint8_t> padding(static_cast<std::size_t>(view.num_u) *
                                    static_cast<std::size_t>(view.num_v));
  std::vector<std::pair<int, int>> front;
  const auto visit = [&](int iu, int iv) {
    if (iu < 0 || iv < 0 || iu >= view.num_u || iv >= view.num_v) return;
    auto& here = padding[static_cast<std::size_t>(iv) * static_cast<std::size_t>(view.num_u) +
                         static_cast<std::size_t>(iu)];
    if (here != 0 || ct.voxels[view.At(slice, iu, iv)] != hu) return;
    here = 1;
    front.emplace_back(iu, iv);
  };
  for (int iu = 0; iu < view.num_u; ++iu) {
    visit(iu, 0);
    visit(iu, view.num_v - 1);
  }
  for (int iv = 0; iv < view.num_v; ++iv) {
    visit(0, iv);
    visit(view.num_u - 1, iv);
  }
  while (!front.empty()) {
    const auto [iu, iv] = front.back();
    front.pop_back();
    visit(iu - 1, iv);
    visit(iu + 1, iv);
    visit(iu, iv - 1);
    visit(iu, iv + 1);
  }
  return padding;
}

std::optional<std::int16_t> CornerValue(const volume::CtVolume& ct, const SliceView& view) {
  const std::int16_t first = ct.voxels[view.At(0, 0, 0)];
  for (int slice = 0; slice < view.num_slices; ++slice) {
    for (const int iu : {0, view.num_u - 1}) {
      for (const int iv : {0, view.num_v - 1}) {
        if (ct.voxels[view.At(slice, iu, iv)] != first) return std::nullopt;
      }
    }
  }
  return first;
}

struct Edges {
  std::vector<Eigen::Vector2d> padding_mm;  ///< Where padding ends.
  std::vector<Eigen::Vector2d> hard_mm;     ///< Where it meets tissue at once.
  std::vector<Eigen::Vector2d> dense_mm;    ///< Some places of tissue.
};

Edges EdgesOf(const volume::CtVolume& ct, const SliceView& view, std::int16_t hu) {
  Edges edges;
  const int step = std::max(1, view.num_slices / kNumSlicesLookedAt);
  for (int slice = 0; slice < view.num_slices; slice += step) {
    const auto padding = PaddingOf(ct, view, slice, hu);
    const auto is_padding = [&](int iu, int iv) {
      return padding[static_cast<std::size_t>(iv) * static_cast<std::size_t>(view.num_u) +
                     static_cast<std::size_t>(iu)] != 0;
    };
    for (int iv = 1; iv + 1 < view.num_v; ++iv) {
      for (int iu = 1; iu + 1 < view.num_u; ++iu) {
        if (is_padding(iu, iv)) continue;
        const bool dense = ct.voxels[view.At(slice, iu, iv)] > kDenseHu;
        const Eigen::Vector2d place_mm = view.PlaceMm(iu, iv);
        if (dense) edges.dense_mm.push_back(place_mm);
        if (!is_padding(iu - 1, iv) && !is_padding(iu + 1, iv) && !is_padding(iu, iv - 1) &&
            !is_padding(iu, iv + 1)) {
          continue;
        }
        edges.padding_mm.push_back(place_mm);
        if (dense) edges.hard_mm.push_back(place_mm);
      }
    }
  }
  return edges;
}

std::optional<ScanCircle> CircleThrough(const Eigen::Vector2d& a, const Eigen::Vector2d& b,
                                        const Eigen::Vector2d& c) {
  Eigen::Matrix2d m;
  m.row(0) = 2.0 * (b - a).transpose();
  m.row(1) = 2.0 * (c - a).transpose();
  const double det = m.determinant();
  if (std::abs(det) < 1.0) return std::nullopt;
  const Eigen::Vector2d right(b.squaredNorm() - a.squaredNorm(), c.squaredNorm() - a.squaredNorm());
  ScanCircle circle;
  circle.centre_mm = m.inverse() * right;
  circle.radius_mm = (a - circle.centre_mm).norm();
  if (circle.radius_mm < kLeastRadiusMm || circle.radius_mm > kMostRadiusMm) return std::nullopt;
  return circle;
}

std::size_t NumOn(const ScanCircle& circle, const std::vector<Eigen::Vector2d>& places_mm,
                  double tolerance_mm) {
  return static_cast<std::size_t>(std::ranges::count_if(places_mm, [&](const Eigen::Vector2d& p) {
    return std::abs((p - circle.centre_mm).norm() - circle.radius_mm) < tolerance_mm;
  }));
}

/// Least squares through the places on a circle: x^2 + y^2 = 2 c.x + k is linear (Kasa 1976).
ScanCircle Refined(const ScanCircle& circle, const std::vector<Eigen::Vector2d>& places_mm,
                   double tolerance_mm) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const Eigen::Vector2d& p : places_mm) {
    const Eigen::Vector2d d = p - circle.centre_mm;
    if (std::abs(d.norm() - circle.radius_mm) >= tolerance_mm) continue;
    const Eigen::Vector3d row(2.0 * d.x(), 2.0 * d.y(), 1.0);
    normal += row * row.transpose();
    right += d.squaredNorm() * row;
  }
  const Eigen::Vector3d x = normal.ldlt().solve(right);
  const double radius_mm = std::sqrt(std::max(0.0, x[2] + x.head<2>().squaredNorm()));
  if (!x.allFinite() || std::abs(radius_mm - circle.radius_mm) > 2.0 * tolerance_mm) return circle;
  return {circle.centre_mm + x.head<2>(), radius_mm};
}

/// The circle on which at least `share` of the places lie.
std::optional<ScanCircle> CircleOf(const std::vector<Eigen::Vector2d>& places_mm, double share,
                                   double tolerance_mm) {
  if (places_mm.size() < kFewestEdges) return std::nullopt;
  RandomStream random(1, "scan circle", 0);
  const auto draw = [&] {
    const auto n = static_cast<double>(places_mm.size());
    return places_mm[std::min(static_cast<std::size_t>(random.Uniform() * n),
                              places_mm.size() - 1)];
  };
  std::optional<ScanCircle> best;
  std::size_t best_count = 0;
  for (int trial = 0; trial < kNumTrials; ++trial) {
    const auto a = draw(), b = draw(), c = draw();
    const auto circle = CircleThrough(a, b, c);
    if (!circle) continue;
    const std::size_t count = NumOn(*circle, places_mm, tolerance_mm);
    if (count > best_count) {
      best_count = count;
      best = circle;
    }
  }
  if (!best || static_cast<double>(best_count) < share * static_cast<double>(places_mm.size())) {
    return std::nullopt;
  }
  return Refined(*best, places_mm, tolerance_mm);
}

/// No tissue may lie beyond what a scanner reconstructs.
bool HoldsAll(const ScanCircle& circle, const std::vector<Eigen::Vector2d>& dense_mm,
              double tolerance_mm) {
  const auto beyond = std::ranges::count_if(dense_mm, [&](const Eigen::Vector2d& p) {
    return (p - circle.centre_mm).norm() > circle.radius_mm + 2.0 * tolerance_mm;
  });
  return static_cast<double>(beyond) <= kMostDenseBeyond * static_cast<double>(dense_mm.size());
}

}  // namespace

ScanField FindScanField(const volume::CtVolume& ct) {
  const SliceView view(ct.geometry);
  ScanField field;
  field.padding_hu = CornerValue(ct, view);
  if (!field.padding_hu) return field;
  const Edges edges = EdgesOf(ct, view, *field.padding_hu);
  const double tolerance_mm = kToleranceVoxels * view.spacing_mm.maxCoeff();
  auto circle = CircleOf(edges.padding_mm, kShareOfPaddingEdges, tolerance_mm);
  if (!circle) circle = CircleOf(edges.hard_mm, kShareOfHardEdges, tolerance_mm);
  // The edge lies between the last voxel that was seen and the padding.
  if (circle) circle->radius_mm += 0.5 * view.spacing_mm.mean();
  if (circle && HoldsAll(*circle, edges.dense_mm, tolerance_mm)) field.circle = circle;
  return field;
}

Mask UnseenBy(const ScanField& field, const volume::CtVolume& ct) {
  Mask unseen(ct.geometry);
  if (!field.circle) return unseen;
  const SliceView view(ct.geometry);
  const double edge_mm = kEdgeVoxels * view.spacing_mm.maxCoeff();
  for (int iv = 0; iv < view.num_v; ++iv) {
    for (int iu = 0; iu < view.num_u; ++iu) {
      const Eigen::Vector2d from_centre = view.PlaceMm(iu, iv) - field.circle->centre_mm;
      const double beyond_mm = from_centre.norm() - field.circle->radius_mm;
      if (beyond_mm <= -edge_mm) continue;
      for (int slice = 0; slice < view.num_slices; ++slice) {
        const std::size_t at = view.At(slice, iu, iv);
        const bool is_padding = ct.voxels[at] == *field.padding_hu || ct.voxels[at] == kPaddedAirHu;
        if (beyond_mm > 0.0 || is_padding) unseen.voxels[at] = 1;
      }
    }
  }
  return unseen;
}

std::optional<volume::CtVolume> WithoutDensePadding(const volume::CtVolume& ct,
                                                    const ScanField& field,
                                                    double body_threshold_hu, int num_threads) {
  if (!field.padding_hu || *field.padding_hu <= body_threshold_hu) return std::nullopt;
  volume::CtVolume out = ct;
  const SliceView view(ct.geometry);
  ParallelFor(view.num_slices, num_threads, [&](int slice) {
    const auto padding = PaddingOf(ct, view, slice, *field.padding_hu);
    for (int iv = 0; iv < view.num_v; ++iv) {
      for (int iu = 0; iu < view.num_u; ++iu) {
        if (padding[static_cast<std::size_t>(iv) * static_cast<std::size_t>(view.num_u) +
                    static_cast<std::size_t>(iu)] != 0) {
          out.voxels[view.At(slice, iu, iv)] = kPaddedAirHu;
        }
      }
    }
  });
  return out;
}

}  // namespace acus::segmentation
