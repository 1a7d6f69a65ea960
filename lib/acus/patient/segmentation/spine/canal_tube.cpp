#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "acus/patient/segmentation/spine/spinal_canal.h"

namespace acus::segmentation {
namespace {

using Radii = std::array<double, kNumCanalRays>;

constexpr double kCentreBandwidthMm = 16.0;  ///< Of the local quadratic through the holes' centres.
constexpr double kBeyondChainMm = 18.0;      ///< Half a vertebra.
constexpr double kRayStepMm = 0.2;
constexpr double kShortestRayMm = 3.0;
constexpr double kLongestRayMm = 20.0;
constexpr double kCortexMm = 2.4;       ///< Beyond the first bone, its peak lies within that.
constexpr double kCanalMeanHu = 0.0;    ///< Of fluid and fat beside the bone.
constexpr double kMedianReachMm = 7.0;  ///< Weights fall by e over that distance between slices.
constexpr double kQuantile =
    0.3;  ///< Bone narrows the canal where it closes, and recedes elsewhere.
/// Least radius of curvature of a cross-section, over that of the largest circle in it.
constexpr double kRoundingShare = 0.8;
constexpr double kRoundingGridMm = 0.25;
constexpr double kSoftRimMm = 3.0;         ///< Muscle, ligament or disc may reach that far into it.
constexpr double kMostCanalSoftHu = 45.0;  ///< Of fat, fluid and nerves, over 3 x 3 x 3 voxels.
constexpr double kMostShiftMm = 4.0;
constexpr double kShiftFromMm = 0.5;

Eigen::Vector2d Direction(int ray) {
  const double angle = 2.0 * std::numbers::pi * ray / kNumCanalRays;
  return {std::cos(angle), std::sin(angle)};
}

/// Bilinear in slice k; the last value continues beyond the border.
double HuAt(const volume::CtVolume& ct, int k, const Eigen::Vector2d& p_mm) {
  const volume::Geometry& g = ct.geometry;
  const double x = std::clamp(p_mm.x() / g.spacing_mm[0], 0.0, g.size[0] - 1.001);
  const double y = std::clamp(p_mm.y() / g.spacing_mm[1], 0.0, g.size[1] - 1.001);
  const int i = static_cast<int>(x);
  const int j = static_cast<int>(y);
  const double a = x - i;
  const double b = y - j;
  return (1 - b) * ((1 - a) * ct.At(i, j, k) + a * ct.At(i + 1, j, k)) +
         b * ((1 - a) * ct.At(i, j + 1, k) + a * ct.At(i + 1, j + 1, k));
}

/// Distance to the inner edge of the bone along a ray, or NaN if there is none.
double EdgeMm(const volume::CtVolume& ct, int k, const Eigen::Vector2d& centre_mm, int ray,
              double bone_hu) {
  const Eigen::Vector2d direction = Direction(ray);
  const auto hu = [&](double r) { return HuAt(ct, k, centre_mm + r * direction); };
  double first = kShortestRayMm;
  while (first <= kLongestRayMm && hu(first) <= bone_hu) first += kRayStepMm;
  if (first > kLongestRayMm) return std::numeric_limits<double>::quiet_NaN();
  double peak = bone_hu;
  for (double r = first; r <= first + kCortexMm; r += kRayStepMm) peak = std::max(peak, hu(r));
  const double half = std::max(0.5 * (peak + kCanalMeanHu), bone_hu);
  double edge = first;
  while (edge < first + kCortexMm && hu(edge) < half) edge += kRayStepMm;
  return edge - 0.5 * kRayStepMm;
}

double WeightedQuantile(std::vector<std::pair<double, double>>& value_weight) {
  std::ranges::sort(value_weight);
  double total = 0.0;
  for (const auto& [value, weight] : value_weight) total += weight;
  double sum = 0.0;
  for (const auto& [value, weight] : value_weight) {
    sum += weight;
    if (sum >= kQuantile * total) return value;
  }
  return std::numeric_limits<double>::quiet_NaN();
}

/// The centre at height z_mm: a quadratic through the chain's centres nearby.
Eigen::Vector2d LocalCentre(const std::vector<CanalHole>& chain, double spacing_mm, double z_mm) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Matrix<double, 3, 2> right = Eigen::Matrix<double, 3, 2>::Zero();
  for (const CanalHole& hole : chain) {
    const double t = (hole.k * spacing_mm - z_mm) / kCentreBandwidthMm;
    // Heavy tails, so that a quadratic is determined also in the middle of a long gap.
    const double weight = 1.0 / std::pow(1.0 + t * t, 2);
    const Eigen::Vector3d basis(1.0, t, t * t);
    normal += weight * basis * basis.transpose();
    right += weight * basis * hole.centre_mm.transpose();
  }
  normal += 1e-6 * normal(0, 0) * Eigen::Matrix3d::Identity();
  return normal.ldlt().solve(right).row(0).transpose();
}

/// Fills angles without a value from their neighbours on the circle.
void FillAround(Radii& radii) {
  const Radii known = radii;
  for (int n = 0; n < kNumCanalRays; ++n) {
    if (!std::isnan(known[static_cast<std::size_t>(n)])) continue;
    double sum = 0.0;
    double weights = 0.0;
    for (int m = 0; m < kNumCanalRays; ++m) {
      const double value = known[static_cast<std::size_t>(m)];
      if (std::isnan(value)) continue;
      const int apart = std::min(std::abs(m - n), kNumCanalRays - std::abs(m - n));
      const double weight = std::pow(0.5, apart);
      sum += weight * value;
      weights += weight;
    }
    radii[static_cast<std::size_t>(n)] = weights > 0.0 ? sum / weights : kShortestRayMm;
  }
}

/// Between the rays, linear in the angle.
double RadiusAt(const Radii& radii, const Eigen::Vector2d& from_centre_mm) {
  double turn = std::atan2(from_centre_mm.y(), from_centre_mm.x()) / (2.0 * std::numbers::pi);
  if (turn < 0.0) turn += 1.0;
  const double at = turn * kNumCanalRays;
  const int n = static_cast<int>(at);
  const double share = at - n;
  return (1.0 - share) * radii[static_cast<std::size_t>(n % kNumCanalRays)] +
         share * radii[static_cast<std::size_t>((n + 1) % kNumCanalRays)];
}

/// The cross-section without corners, which a disc somewhat smaller than the largest in it does not
/// reach into: fat in the lateral recesses and between the laminae is not taken for canal.
Radii Rounded(const Radii& radii) {
  volume::Geometry g;
  const int half = static_cast<int>(std::ceil(kLongestRayMm / kRoundingGridMm)) + 2;
  g.size = {2 * half + 1, 2 * half + 1, 1};
  g.spacing_mm = {kRoundingGridMm, kRoundingGridMm, 1.0};
  Mask section(g), outside(g);
  for (int j = 0; j < g.size[1]; ++j) {
    for (int i = 0; i < g.size[0]; ++i) {
      const Eigen::Vector2d p(kRoundingGridMm * (i - half), kRoundingGridMm * (j - half));
      section.At(i, j, 0) = p.norm() < RadiusAt(radii, p) ? 1 : 0;
      outside.At(i, j, 0) = 1 - section.At(i, j, 0);
    }
  }
  // Only within the slice: the grid is one voxel high.
  const double widest_mm = std::ranges::max(DistanceMm(outside, 1).voxels);
  const Mask opened = Opened(section, kRoundingShare * widest_mm, 1);
  Radii out{};
  for (int n = 0; n < kNumCanalRays; ++n) {
    const Eigen::Vector2d direction = Direction(n);
    double r = radii[static_cast<std::size_t>(n)];
    const auto is_out = [&](double at) {
      const Eigen::Vector2d p = at / kRoundingGridMm * direction;
      return opened.At(half + static_cast<int>(std::lround(p.x())),
                       half + static_cast<int>(std::lround(p.y())), 0) == 0;
    };
    while (r > kShortestRayMm && is_out(r - 0.5 * kRoundingGridMm)) r -= 0.1;
    out[static_cast<std::size_t>(n)] = r;
  }
  return out;
}

/// 1-2-1 around the circle.
Radii Smoothed(const Radii& radii) {
  Radii out{};
  for (int n = 0; n < kNumCanalRays; ++n) {
    const auto at = [&](int m) {
      return radii[static_cast<std::size_t>((m + kNumCanalRays) % kNumCanalRays)];
    };
    out[static_cast<std::size_t>(n)] = 0.25 * (at(n - 1) + 2.0 * at(n) + at(n + 1));
  }
  return out;
}

/// Calls visit(hu) for the 3 x 3 x 3 voxels around one.
template <typename Visit>
void ForNeighbours(const volume::CtVolume& ct, int i, int j, int k, const Visit& visit) {
  const auto& size = ct.geometry.size;
  for (int c = std::max(k - 1, 0); c <= std::min(k + 1, size[2] - 1); ++c) {
    for (int b = std::max(j - 1, 0); b <= std::min(j + 1, size[1] - 1); ++b) {
      for (int a = std::max(i - 1, 0); a <= std::min(i + 1, size[0] - 1); ++a)
        visit(ct.At(a, b, c));
    }
  }
}

/// Whether a voxel and what is around it are muscle, ligament or disc. Beside bone there is no
/// conclusive: its blur looks like that.
bool IsSoft(const volume::CtVolume& ct, int i, int j, int k, double bone_hu) {
  double sum = 0.0;
  int count = 0;
  int peak = 0;
  ForNeighbours(ct, i, j, k, [&](int hu) {
    sum += hu;
    ++count;
    peak = std::max(peak, hu);
  });
  return sum > kMostCanalSoftHu * count && peak < bone_hu;
}

/// Dense, and above half of the edge to the densest neighbour.
bool IsBone(const volume::CtVolume& ct, int i, int j, int k, double bone_hu) {
  if (ct.At(i, j, k) <= bone_hu) return false;
  int peak = 0;
  ForNeighbours(ct, i, j, k, [&](int hu) { peak = std::max(peak, hu); });
  return ct.At(i, j, k) >= 0.5 * (peak + kCanalMeanHu);
}

/// Moves the centre of an open slice back if the vertebral body in front reaches into the tube.
void ShiftBehindBody(const volume::CtVolume& ct, int k, double bone_hu, const Radii& radii,
                     Eigen::Vector2d& centre_mm) {
  std::vector<double> reach_mm;
  for (int n = 0; n < kNumCanalRays; ++n) {
    const Eigen::Vector2d direction = Direction(n);
    if (direction.y() > -0.7) continue;
    const double edge = EdgeMm(ct, k, centre_mm, n, bone_hu);
    const double beyond = radii[static_cast<std::size_t>(n)] - edge;
    reach_mm.push_back(std::isnan(edge) ? 0.0 : beyond * -direction.y());
  }
  std::ranges::sort(reach_mm);
  const double median = reach_mm[reach_mm.size() / 2];
  if (median > kShiftFromMm) centre_mm.y() += std::min(median, kMostShiftMm);
}

/// Calls visit(i, j, k, inside_mm) for the voxels of the tube; inside_mm from its surface.
template <typename Visit>
void ForTube(const CanalTube& tube, const volume::Geometry& g, const Visit& visit) {
  for (int k = tube.first; k <= tube.last(); ++k) {
    const Eigen::Vector2d centre = tube.Centre(k);
    const auto low = ((centre.array() - kLongestRayMm) / g.spacing_mm.head<2>()).floor();
    const auto high = ((centre.array() + kLongestRayMm) / g.spacing_mm.head<2>()).ceil();
    for (int j = std::max(static_cast<int>(low[1]), 0);
         j <= std::min(static_cast<int>(high[1]), g.size[1] - 1); ++j) {
      for (int i = std::max(static_cast<int>(low[0]), 0);
           i <= std::min(static_cast<int>(high[0]), g.size[0] - 1); ++i) {
        const Eigen::Vector2d from(i * g.spacing_mm[0] - centre.x(),
                                   j * g.spacing_mm[1] - centre.y());
        const double inside_mm = tube.RadiusMm(k, from) - from.norm();
        if (inside_mm >= 0.0) visit(i, j, k, inside_mm);
      }
    }
  }
}

}  // namespace

double CanalTube::RadiusMm(int k, const Eigen::Vector2d& from_centre_mm) const {
  return RadiusAt(radius_mm[static_cast<std::size_t>(k - first)], from_centre_mm);
}

CanalTube FitCanalTube(const volume::CtVolume& ct, const std::vector<CanalHole>& chain,
                       double bone_hu) {
  const double step_mm = ct.geometry.spacing_mm[2];
  const int beyond = static_cast<int>(kBeyondChainMm / step_mm);
  CanalTube tube;
  tube.first = std::max(chain.front().k - beyond, 0);
  const int last = std::min(chain.back().k + beyond, ct.geometry.size[2] - 1);
  const double low_mm = chain.front().k * step_mm;
  const double high_mm = chain.back().k * step_mm;
  for (int k = tube.first; k <= last; ++k) {
    const double z_mm = k * step_mm;
    const double inside_mm = std::clamp(z_mm, low_mm, high_mm);
    Eigen::Vector2d centre = LocalCentre(chain, step_mm, inside_mm);
    if (z_mm != inside_mm) {
      // Straight on beyond the ends.
      const double back_mm = inside_mm + (z_mm < inside_mm ? 1.0 : -1.0) * kBeyondChainMm;
      const Eigen::Vector2d within =
          LocalCentre(chain, step_mm, std::clamp(back_mm, low_mm, high_mm));
      centre += (centre - within) * std::abs(z_mm - inside_mm) / kBeyondChainMm;
    }
    tube.centre_mm.push_back(centre);
  }
  tube.is_closed.assign(tube.centre_mm.size(), 0);
  std::vector<Radii> edges;
  for (const CanalHole& hole : chain) {
    tube.is_closed[static_cast<std::size_t>(hole.k - tube.first)] = 1;
    Radii edge{};
    for (int n = 0; n < kNumCanalRays; ++n) {
      edge[static_cast<std::size_t>(n)] = EdgeMm(ct, hole.k, tube.Centre(hole.k), n, bone_hu);
    }
    edges.push_back(edge);
  }
  for (int k = tube.first; k <= last; ++k) {
    Radii radii{};
    for (std::size_t n = 0; n < kNumCanalRays; ++n) {
      std::vector<std::pair<double, double>> samples;
      for (std::size_t c = 0; c < chain.size(); ++c) {
        if (std::isnan(edges[c][n])) continue;
        const double apart_mm = std::abs(chain[c].k - k) * step_mm;
        samples.emplace_back(edges[c][n], std::exp(-apart_mm / kMedianReachMm));
      }
      radii[n] = WeightedQuantile(samples);
    }
    FillAround(radii);
    const auto s = static_cast<std::size_t>(k - tube.first);
    radii = Rounded(Smoothed(radii));
    if (tube.is_closed[s] == 0) ShiftBehindBody(ct, k, bone_hu, radii, tube.centre_mm[s]);
    tube.radius_mm.push_back(radii);
  }
  return tube;
}

Mask CanalMask(const CanalTube& tube, const volume::CtVolume& ct, double bone_hu) {
  Mask canal(ct.geometry);
  ForTube(tube, ct.geometry, [&](int i, int j, int k, double inside_mm) {
    const bool is_foreign =
        IsBone(ct, i, j, k, bone_hu) || (inside_mm < kSoftRimMm && IsSoft(ct, i, j, k, bone_hu));
    canal.At(i, j, k) = is_foreign ? 0 : 1;
  });
  return canal;
}

Mask CanalLining(const CanalTube& tube, const volume::CtVolume& ct, const Mask& bone,
                 const Mask& canal, double fat_upper_hu) {
  Mask lining(ct.geometry);
  ForTube(tube, ct.geometry, [&](int i, int j, int k, double /*inside_mm*/) {
    const bool is_soft = bone.At(i, j, k) == 0 && canal.At(i, j, k) == 0;
    lining.At(i, j, k) = is_soft && ct.At(i, j, k) > fat_upper_hu ? 1 : 0;
  });
  return lining;
}

}  // namespace acus::segmentation
