#include "acus/patient/phantom/anatomy/duct_tree.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "acus/base/core/error.h"
#include "acus/base/core/random.h"

namespace acus::phantom {
namespace {

using Eigen::Vector3d;

constexpr int kForkTries = 160;
constexpr int kRootTries = 96;
constexpr double kLargestAngleRad = 1.6;
constexpr double kMostShortened = 0.75;  ///< Of the length, where there is less room.
constexpr double kRootStepMm = 4.0;      ///< Between places that are tried for the root,
constexpr std::size_t kMostRoots = 200;  ///< so many of them.
constexpr std::size_t kMostSegments = 20000;

Vector3d AnyAcross(const Vector3d& direction) {
  const Vector3d axis = std::abs(direction.x()) < 0.8 ? Vector3d::UnitX() : Vector3d::UnitY();
  return direction.cross(axis).normalized();
}

/// Angle of a branch to the tube before the fork, rad: the least work for the flow.
double BranchAngle(double parent, double branch, double other) {
  const double p4 = std::pow(parent, 4), b4 = std::pow(branch, 4), o4 = std::pow(other, 4);
  return std::acos(std::clamp((p4 + b4 - o4) / (2 * parent * parent * branch * branch), -1.0, 1.0));
}

class Grower {
 public:
  Grower(const FreeSpace& space, std::span<const DuctSegment> others,
         const DuctTreeSettings& settings)
      : space_(space),
        others_(others),
        settings_(settings),
        random_(settings.seed, "duct tree " + settings.name) {}

  std::optional<std::vector<DuctSegment>> Grow(const Vector3d& hint_mm) {
    std::vector<Vector3d> tried;
    for (const Vector3d& root : RootsNear(hint_mm)) {
      const auto is_near = [&](const Vector3d& p) { return (p - root).norm() < kRootStepMm; };
      if (std::ranges::any_of(tried, is_near)) continue;
      if (tried.size() == kMostRoots) break;
      tried.push_back(root);
      if (AddStem(root)) break;
    }
    if (tree_.empty()) return std::nullopt;
    for (std::size_t next = 0; next < tree_.size() && tree_.size() < kMostSegments; ++next) {
      Fork(next);
    }
    return std::move(tree_);
  }

 private:
  /// Where a ball of the root's radius has room, the nearest first.
  std::vector<Vector3d> RootsNear(const Vector3d& hint_mm) const {
    const volume::Geometry& g = space_.distance_mm.geometry;
    const Eigen::Affine3d ct_from_index = g.ct_from_index();
    std::vector<Vector3d> roots;
    for (int k = 0; k < g.size[2]; ++k) {
      for (int j = 0; j < g.size[1]; ++j) {
        for (int i = 0; i < g.size[0]; ++i) {
          const Vector3d point = ct_from_index * Vector3d(i, j, k);
          const double needed_mm = settings_.root_radius_mm + settings_.margin_mm;
          if (space_.ClearanceOf(i, j, k) >= needed_mm) roots.push_back(point);
        }
      }
    }
    std::ranges::stable_sort(roots, {}, [&](const Vector3d& p) { return (p - hint_mm).norm(); });
    return roots;
  }

  bool AddStem(const Vector3d& root) {
    std::optional<DuctSegment> best;
    double best_mm = 0.0;
    for (int i = 0; i < kRootTries; ++i) {
      const double shorter = 1.0 - kMostShortened * static_cast<double>(i) / kRootTries;
      const double z = random_.Uniform(-1, 1), turn = random_.Uniform(0, 2 * std::numbers::pi);
      const double s = std::sqrt(1 - z * z);
      const Vector3d direction(s * std::cos(turn), s * std::sin(turn), z);
      const double length_mm = shorter * settings_.length_over_radius * settings_.root_radius_mm;
      const DuctSegment stem{.parent = -1,
                             .from_mm = root,
                             .to_mm = root + length_mm * direction,
                             .radius_mm = settings_.root_radius_mm};
      const double room_mm = shorter * space_.ClearanceMm(stem.to_mm);
      if (room_mm <= best_mm || !IsFree(stem, {})) continue;
      best = stem;
      best_mm = room_mm;
    }
    if (best) tree_.push_back(*best);
    return best.has_value();
  }

  void Fork(std::size_t number) {
    const DuctSegment parent = tree_[number];
    if (parent.radius_mm < settings_.least_radius_mm) return;
    const Vector3d along = (parent.to_mm - parent.from_mm).normalized();
    const Vector3d across = AnyAcross(along);
    std::array<DuctSegment, 2> best;
    double best_mm = 0.0;
    for (int i = 0; i < kForkTries; ++i) {
      // First long forks of like branches at the angles of least work; the more is tried, the
      // shorter, more unequal and wider they are.
      const double tried = static_cast<double>(i) / kForkTries;
      const double shorter = 1.0 - kMostShortened * tried;
      const double least_share = 0.3 - 0.28 * tried;
      const double share = random_.Uniform(least_share, 1.0 - least_share);
      const double wider = 1.0 + tried * random_.Uniform(0.0, 2.0);
      const double turn = random_.Uniform(0, 2 * std::numbers::pi);
      const Vector3d side = Eigen::AngleAxisd(turn, along) * across;
      const std::array<double, 2> radii = {parent.radius_mm * std::cbrt(share),
                                           parent.radius_mm * std::cbrt(1.0 - share)};
      std::array<DuctSegment, 2> fork;
      for (std::size_t b = 0; b < 2; ++b) {
        const double bend = std::min(kLargestAngleRad,
                                     wider * BranchAngle(parent.radius_mm, radii[b], radii[1 - b]));
        const double angle = b == 0 ? bend : -bend;
        const double length_mm =
            shorter * random_.Uniform(0.8, 1.2) * settings_.length_over_radius * radii[b];
        fork[b] = {
            .parent = static_cast<int>(number),
            .from_mm = parent.to_mm,
            .to_mm = parent.to_mm + length_mm * (std::cos(angle) * along + std::sin(angle) * side),
            .radius_mm = radii[b]};
      }
      const double room_mm =
          std::min(space_.ClearanceMm(fork[0].to_mm), space_.ClearanceMm(fork[1].to_mm)) * shorter;
      if (room_mm <= best_mm || !IsFree(fork[0], number) || !IsFree(fork[1], number)) continue;
      best = fork;
      best_mm = room_mm;
    }
    if (best_mm > 0.0) tree_.insert(tree_.end(), best.begin(), best.end());
  }

  /// Whether a tube keeps the margin, but to the one that it begins at.
  bool IsFree(const DuctSegment& tube, std::optional<std::size_t> parent) const {
    const double needed_mm = tube.radius_mm + settings_.margin_mm;
    const double length_mm = (tube.to_mm - tube.from_mm).norm();
    const double step_mm = 0.5 * space_.distance_mm.geometry.spacing_mm.minCoeff();
    const int steps = 1 + static_cast<int>(length_mm / step_mm);
    // The end first: it is what fails most.
    for (int i = steps; i >= 0; --i) {
      const Vector3d at = tube.from_mm + (tube.to_mm - tube.from_mm) * i / steps;
      if (space_.ClearanceMm(at) < needed_mm) return false;
    }
    const auto clear = [&](const DuctSegment& other, double gap_mm) {
      return AxisDistanceMm(tube, other) >= tube.radius_mm + other.radius_mm + gap_mm;
    };
    for (std::size_t i = 0; i < tree_.size(); ++i) {
      if (parent && (i == *parent || tree_[i].parent == static_cast<int>(*parent))) continue;
      if (!clear(tree_[i], IsAtForkBefore(i, parent) ? 0.0 : settings_.margin_mm)) return false;
    }
    return std::ranges::all_of(
        others_, [&](const DuctSegment& other) { return clear(other, settings_.margin_mm); });
  }

  /// Whether a tube is at the fork that the parent begins at: it is near, and only must not meet
  /// the parent's branches.
  bool IsAtForkBefore(std::size_t other, std::optional<std::size_t> parent) const {
    if (!parent) return false;
    const int grandparent = tree_[*parent].parent;
    return grandparent >= 0 &&
           (static_cast<int>(other) == grandparent || tree_[other].parent == grandparent);
  }

  const FreeSpace& space_;
  std::span<const DuctSegment> others_;
  const DuctTreeSettings& settings_;
  RandomStream random_;
  std::vector<DuctSegment> tree_;
};

void CheckSettings(const DuctTreeSettings& s) {
  ACUS_REQUIRE(s.root_radius_mm >= 0.5 && s.root_radius_mm <= 30.0, "root of a tree: radius ",
               s.root_radius_mm, " mm; allowed are 0.5 to 30");
  ACUS_REQUIRE(s.least_radius_mm >= 0.3 && s.least_radius_mm <= s.root_radius_mm,
               "thinnest branch that forks: radius ", s.least_radius_mm,
               " mm; allowed are 0.3 mm to that of the root, ", s.root_radius_mm);
  ACUS_REQUIRE(s.margin_mm >= 0.0 && s.margin_mm <= 50.0, "margin of ", s.margin_mm,
               " mm; allowed are 0 to 50");
}

}  // namespace

double DuctSegment::DistanceMm(const Vector3d& point_mm) const {
  const Vector3d axis = to_mm - from_mm;
  const double length2 = axis.squaredNorm();
  const double along =
      length2 > 0.0 ? std::clamp((point_mm - from_mm).dot(axis) / length2, 0.0, 1.0) : 0.0;
  return (point_mm - from_mm - along * axis).norm() - radius_mm;
}

double FreeSpace::ClearanceOf(int i, int j, int k) const {
  return distance_mm.At(i, j, k) - 0.5 * distance_mm.geometry.spacing_mm.matrix().norm();
}

double FreeSpace::ClearanceMm(const Vector3d& point_mm) const {
  const volume::Geometry& g = distance_mm.geometry;
  const Vector3d index = g.index_from_ct() * point_mm;
  const Eigen::Array3i at = index.array().round().cast<int>();
  return g.Contains(at[0], at[1], at[2]) ? ClearanceOf(at[0], at[1], at[2]) : -1.0;
}

double AxisDistanceMm(const DuctSegment& a, const DuctSegment& b) {
  const Vector3d da = a.to_mm - a.from_mm, db = b.to_mm - b.from_mm, r = a.from_mm - b.from_mm;
  const double aa = da.squaredNorm(), bb = db.squaredNorm(), ab = da.dot(db);
  const double ar = da.dot(r), br = db.dot(r);
  const double determinant = aa * bb - ab * ab;
  double s =
      determinant > 1e-12 * aa * bb ? std::clamp((ab * br - ar * bb) / determinant, 0.0, 1.0) : 0.0;
  double t = bb > 0.0 ? (ab * s + br) / bb : 0.0;
  if (t < 0.0 || t > 1.0) {
    t = std::clamp(t, 0.0, 1.0);
    s = aa > 0.0 ? std::clamp((ab * t - ar) / aa, 0.0, 1.0) : 0.0;
  }
  return (r + s * da - t * db).norm();
}

std::optional<std::vector<DuctSegment>> GrowDuctTree(const FreeSpace& space,
                                                     const Vector3d& hint_mm,
                                                     std::span<const DuctSegment> others,
                                                     const DuctTreeSettings& settings) {
  CheckSettings(settings);
  return Grower(space, others, settings).Grow(hint_mm);
}

}  // namespace acus::phantom
