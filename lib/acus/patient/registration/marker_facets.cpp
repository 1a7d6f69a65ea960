#include "acus/patient/registration/marker_facets.h"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "acus/base/core/error.h"
#include "acus/base/math/distributions.h"
#include "acus/base/math/statistics.h"

namespace acus::registration {
namespace {

using Eigen::Index;
using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr double kOutlierFactor = 5.0;
constexpr double kRoundingMm = 1e-6;
constexpr int kMostFacetIterations = 200;

Isometry3d FitPose(const transforms::Markers& from_mm, const transforms::Markers& to_mm) {
  Isometry3d pose;
  pose.matrix() = Eigen::umeyama(from_mm, to_mm, /*with_scaling=*/false);
  return pose;
}

void Append(const transforms::Markers& more_mm, transforms::Markers& all_mm) {
  const Index before = all_mm.cols();
  all_mm.conservativeResize(3, before + more_mm.cols());
  all_mm.rightCols(more_mm.cols()) = more_mm;
}

void CheckFacets(const std::vector<Facet>& facets) {
  ACUS_REQUIRE(!facets.empty(), "there is no facet");
  std::set<std::string> names;
  for (const Facet& facet : facets) {
    ACUS_REQUIRE(names.insert(facet.name).second, "the facet '", facet.name, "' is there twice");
    ACUS_REQUIRE(facet.points_mm.cols() >= 3, "facet '", facet.name,
                 "': at least 3 points are needed, got ", facet.points_mm.cols());
    const Vector3d spread_mm = SpreadMm(facet.points_mm);
    ACUS_REQUIRE(spread_mm[1] > 0.1, "facet '", facet.name,
                 "': its points lie on a line (spread across it ", spread_mm[1],
                 " mm); its pose cannot be found");
  }
}

/// Places every facet along a chain of facets that were seen together.
class FirstGuess {
 public:
  FirstGuess(const std::vector<Facet>& facets, std::span<const FacetPoses> moments)
      : facets_(facets), moments_(moments), placed_(facets.size()) {}

  std::vector<Isometry3d> Run() {
    placed_[0] = Isometry3d::Identity();
    for (bool grew = true; grew;) {
      grew = false;
      for (std::size_t i = 0; i < facets_.size(); ++i) {
        for (std::size_t j = 0; j < facets_.size() && placed_[i]; ++j) {
          if (placed_[j] || !Relative(i, j)) continue;
          placed_[j] = *placed_[i] * *Relative(i, j);
          grew = true;
        }
      }
    }
    std::string lost;
    std::vector<Isometry3d> places;
    for (std::size_t i = 0; i < facets_.size(); ++i) {
      if (placed_[i])
        places.push_back(*placed_[i]);
      else
        lost += (lost.empty() ? "'" : ", '") + facets_[i].name + "'";
    }
    if (!lost.empty()) {
      throw NoAnswerError(Message(
          "never seen together with '", facets_[0].name, "', not even through others: ", lost,
          "; turn the object so that the camera sees adjacent facets at once"));
    }
    return places;
  }

 private:
  /// Pose at the middle moment in which both are seen: single flips rarely hit it, and the later
  /// iterations reject them.
  std::optional<Isometry3d> Relative(std::size_t i, std::size_t j) const {
    std::vector<Isometry3d> found;
    for (const FacetPoses& poses : moments_) {
      if (poses[i] && poses[j]) found.push_back(poses[i]->inverse() * *poses[j]);
    }
    if (found.empty()) return std::nullopt;
    // The medoid of a few: nearest to the others by where it puts the facet's points.
    const std::size_t step = std::max<std::size_t>(1, found.size() / 15);
    std::vector<transforms::Markers> points_mm;
    for (std::size_t k = 0; k < found.size(); k += step) {
      points_mm.push_back(found[k] * facets_[j].points_mm);
    }
    std::size_t best = 0;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < points_mm.size(); ++k) {
      double sum = 0.0;
      for (const transforms::Markers& other : points_mm) sum += (points_mm[k] - other).norm();
      if (sum < least) {
        least = sum;
        best = k;
      }
    }
    return found[best * step];
  }

  const std::vector<Facet>& facets_;
  std::span<const FacetPoses> moments_;
  std::vector<std::optional<Isometry3d>> placed_;
};

/// The alternation between poses of the object and places of the facets.
class Procrustes {
 public:
  Procrustes(FacetModel& model, std::span<const FacetPoses> moments)
      : model_(model), good_(moments.size(), std::vector<bool>(model.facets.size(), false)) {
    for (const FacetPoses& poses : moments) moments_.push_back(&poses);
    for (std::size_t m = 0; m < moments_.size(); ++m) {
      const auto seen =
          std::ranges::count_if(*moments_[m], [](const auto& p) { return p.has_value(); });
      for (std::size_t f = 0; f < model_.facets.size() && seen >= 2; ++f) {
        good_[m][f] = (*moments_[m])[f].has_value();
      }
    }
    object_from_tracker_.resize(moments_.size());
  }

  void Run() {
    for (int round = 0; round < 4; ++round) {
      for (int iteration = 0; iteration < kMostFacetIterations; ++iteration) {
        LocateObject();
        if (PlaceFacets() < kRoundingMm) break;
      }
      LocateObject();
      if (!Reject()) break;
    }
    Summarise();
  }

 private:
  std::size_t GoodIn(std::size_t m) const {
    return static_cast<std::size_t>(std::ranges::count(good_[m], true));
  }

  void LocateObject() {
    for (std::size_t m = 0; m < moments_.size(); ++m) {
      if (GoodIn(m) < 2) continue;
      transforms::Markers tracker_mm(3, 0), object_mm(3, 0);
      for (std::size_t f = 0; f < model_.facets.size(); ++f) {
        if (!good_[m][f]) continue;
        Append(*(*moments_[m])[f] * model_.facets[f].points_mm, tracker_mm);
        Append(model_.PointsInObjectMm(f), object_mm);
      }
      object_from_tracker_[m] = FitPose(tracker_mm, object_mm);
    }
  }

  transforms::Markers SeenInObjectMm(std::size_t m, std::size_t f) const {
    return object_from_tracker_[m] * (*(*moments_[m])[f] * model_.facets[f].points_mm);
  }

  /// @returns the largest change of a point, mm.
  double PlaceFacets() {
    double change_mm = 0.0;
    std::vector<Isometry3d> places = model_.object_from_facet;
    for (std::size_t f = 0; f < model_.facets.size(); ++f) {
      transforms::Markers mean_mm = transforms::Markers::Zero(3, model_.facets[f].points_mm.cols());
      double count = 0.0;
      for (std::size_t m = 0; m < moments_.size(); ++m) {
        if (!good_[m][f] || GoodIn(m) < 2) continue;
        mean_mm += SeenInObjectMm(m, f);
        count += 1.0;
      }
      if (count > 0.0) places[f] = FitPose(model_.facets[f].points_mm, mean_mm / count);
    }
    const Isometry3d first_from_object = places[0].inverse();  // The object's frame is facet 0's.
    for (std::size_t f = 0; f < places.size(); ++f) {
      const transforms::Markers before_mm = model_.PointsInObjectMm(f);
      model_.object_from_facet[f] = first_from_object * places[f];
      change_mm =
          std::max(change_mm, (model_.PointsInObjectMm(f) - before_mm).colwise().norm().maxCoeff());
    }
    return change_mm;
  }

  double ResidualMm(std::size_t m, std::size_t f) const {
    const transforms::Markers off_mm = SeenInObjectMm(m, f) - model_.PointsInObjectMm(f);
    return std::sqrt(off_mm.squaredNorm() / static_cast<double>(off_mm.cols()));
  }

  /// In each moment the worst reading, if it is far off: it pulls the others along.
  bool Reject() {
    std::vector<double> all_mm;
    for (std::size_t m = 0; m < moments_.size(); ++m) {
      for (std::size_t f = 0; f < model_.facets.size() && GoodIn(m) >= 2; ++f) {
        if (good_[m][f]) all_mm.push_back(ResidualMm(m, f));
      }
    }
    const double limit_mm = kOutlierFactor * math::Median(all_mm) + kRoundingMm;
    bool rejected = false;
    for (std::size_t m = 0; m < moments_.size(); ++m) {
      if (GoodIn(m) < 2) continue;
      std::size_t worst = 0;
      double worst_mm = 0.0;
      for (std::size_t f = 0; f < model_.facets.size(); ++f) {
        if (good_[m][f] && ResidualMm(m, f) > worst_mm) worst_mm = ResidualMm(m, worst = f);
      }
      if (worst_mm <= limit_mm) continue;
      good_[m][worst] = false;
      ++model_.num_rejected;
      rejected = true;
    }
    return rejected;
  }

  void Summarise() {
    const std::size_t count = model_.facets.size();
    std::vector<double> sum_mm2(count, 0.0);
    model_.num_seen.assign(count, 0);
    model_.facet_rms_mm.assign(count, 0.0);
    for (std::size_t m = 0; m < moments_.size(); ++m) {
      if (GoodIn(m) < 2) continue;
      ++model_.num_moments;
      for (std::size_t f = 0; f < count; ++f) {
        if (!good_[m][f]) continue;
        ++model_.num_seen[f];
        sum_mm2[f] += std::pow(ResidualMm(m, f), 2);
      }
    }
    for (std::size_t f = 0; f < count; ++f) {
      if (model_.num_seen[f] == 0) continue;
      model_.facet_rms_mm[f] = std::sqrt(sum_mm2[f] / static_cast<double>(model_.num_seen[f]));
    }
  }

  FacetModel& model_;
  std::vector<const FacetPoses*> moments_;
  std::vector<std::vector<bool>> good_;
  std::vector<Isometry3d> object_from_tracker_;
};

/// Weighted rigid fit; each facet's points weigh by the inverse of its variance.
struct Stack {
  transforms::Markers object_mm{3, 0};
  transforms::Markers tracker_mm{3, 0};
  std::vector<double> weights;
};

Isometry3d WeightedPose(const Stack& stack) {
  const Eigen::Map<const Eigen::VectorXd> w(stack.weights.data(),
                                            static_cast<Index>(stack.weights.size()));
  const Vector3d object_mean = stack.object_mm * w / w.sum();
  const Vector3d tracker_mean = stack.tracker_mm * w / w.sum();
  // Scaling both sides by the root of the weight makes plain least squares weighted.
  const Eigen::RowVectorXd root = w.cwiseSqrt().transpose();
  const transforms::Markers object =
      (stack.object_mm.colwise() - object_mean).array().rowwise() * root.array();
  const transforms::Markers tracker =
      (stack.tracker_mm.colwise() - tracker_mean).array().rowwise() * root.array();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(tracker * object.transpose(),
                                              Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Vector3d sign(1, 1, (svd.matrixU() * svd.matrixV().transpose()).determinant());
  Isometry3d pose = Isometry3d::Identity();
  pose.linear() = svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
  pose.translation() = tracker_mean - pose.linear() * object_mean;
  return pose;
}

Stack StackOf(const FacetModel& model, const FacetPoses& seen, const std::vector<bool>& used) {
  Stack stack;
  for (std::size_t f = 0; f < used.size(); ++f) {
    if (!used[f]) continue;
    Append(model.PointsInObjectMm(f), stack.object_mm);
    Append(*seen[f] * model.facets[f].points_mm, stack.tracker_mm);
    const double noise_mm = std::max(0.01, model.facet_rms_mm[f]);
    stack.weights.resize(static_cast<std::size_t>(stack.object_mm.cols()),
                         1.0 / (noise_mm * noise_mm));
  }
  return stack;
}

/// How far facet f is off, in multiples of its noise.
double Excess(const FacetModel& model, const FacetPoses& seen, std::size_t f,
              const Isometry3d& tracker_from_object) {
  const transforms::Markers off_mm =
      tracker_from_object * model.PointsInObjectMm(f) - *seen[f] * model.facets[f].points_mm;
  return std::sqrt(off_mm.squaredNorm() / static_cast<double>(off_mm.cols())) /
         std::max(0.01, model.facet_rms_mm[f]);
}

}  // namespace

FacetModel CalibrateFacets(const std::vector<Facet>& facets, std::span<const FacetPoses> moments) {
  CheckFacets(facets);
  for (const FacetPoses& poses : moments) ACUS_ASSERT(poses.size() == facets.size());
  FacetModel model;
  model.facets = facets;
  model.object_from_facet = FirstGuess(facets, moments).Run();
  model.facet_rms_mm.assign(facets.size(), 0.0);
  model.num_seen.assign(facets.size(), 0);
  if (facets.size() > 1) Procrustes(model, moments).Run();
  return model;
}

std::optional<FusedPose> FuseFacets(const FacetModel& model, const FacetPoses& seen) {
  ACUS_ASSERT(seen.size() == model.facets.size());
  FusedPose fused;
  for (const auto& pose : seen) fused.used.push_back(pose.has_value());
  auto count = std::ranges::count(fused.used, true);
  if (count == 0) return std::nullopt;
  while (true) {
    fused.tracker_from_object = WeightedPose(StackOf(model, seen, fused.used));
    std::size_t worst = fused.used.size();
    double worst_excess = kOutlierFactor;
    // What the others say of each: a wrong facet would otherwise pull its own residual down.
    for (std::size_t f = 0; f < fused.used.size() && count >= 2; ++f) {
      if (!fused.used[f]) continue;
      auto others = fused.used;
      others[f] = false;
      const double excess = Excess(model, seen, f, WeightedPose(StackOf(model, seen, others)));
      const Isometry3d without = WeightedPose(StackOf(model, seen, others));
      double agreement = 0.0;
      for (std::size_t g = 0; g < others.size(); ++g) {
        if (others[g]) agreement = std::max(agreement, Excess(model, seen, g, without));
      }
      if (excess / std::max(1.0, agreement) > worst_excess) {
        worst_excess = excess / std::max(1.0, agreement);
        worst = f;
      }
    }
    if (worst == fused.used.size()) break;
    if (count == 2) {
      fused.facets_disagree = true;
      break;
    }
    fused.used[worst] = false;
    --count;
  }
  const Stack stack = StackOf(model, seen, fused.used);
  const transforms::Markers off_mm = fused.tracker_from_object * stack.object_mm - stack.tracker_mm;
  fused.rms_mm = std::sqrt(off_mm.squaredNorm() / static_cast<double>(off_mm.cols()));
  return fused;
}

std::vector<MovedFacet> FindMovedFacets(const transforms::Markers& object_mm,
                                        const transforms::Markers& ct_mm,
                                        const std::vector<std::size_t>& facet_of,
                                        const std::vector<std::string>& facet_names,
                                        double significance) {
  const Index n = ct_mm.cols();
  ACUS_ASSERT(static_cast<Index>(facet_of.size()) == n);
  const double all = FitMarkers(object_mm, ct_mm).residual_mm.squaredNorm();
  std::vector<MovedFacet> moved;
  for (std::size_t f = 0; f < facet_names.size(); ++f) {
    std::vector<Index> own, others;
    for (Index i = 0; i < n; ++i) {
      (facet_of[static_cast<std::size_t>(i)] == f ? own : others).push_back(i);
    }
    if (own.empty() || others.size() < 3 || SpreadMm(ct_mm(Eigen::all, others))[1] < 0.1) continue;
    const MarkerFit fit = FitMarkers(object_mm(Eigen::all, others), ct_mm(Eigen::all, others));
    const double rest = std::max(fit.residual_mm.squaredNorm(), kRoundingMm * kRoundingMm);
    const double freedom = 3.0 * static_cast<double>(others.size()) - 6.0;
    const double removed = 3.0 * static_cast<double>(own.size());
    const double ratio = std::max(0.0, all - rest) / removed / (rest / freedom);
    const transforms::Markers off_mm =
        ct_mm(Eigen::all, own) -
        fit.ct_from_reference * transforms::Markers(object_mm(Eigen::all, own));
    const double p = std::min(
        1.0, static_cast<double>(facet_names.size()) * math::FUpperTail(ratio, removed, freedom));
    if (p >= significance) continue;
    moved.push_back({.name = facet_names[f],
                     .moved_mm = std::sqrt(off_mm.squaredNorm() / static_cast<double>(own.size())),
                     .p_value = p});
  }
  std::ranges::sort(moved, {}, &MovedFacet::p_value);
  return moved;
}

}  // namespace acus::registration
