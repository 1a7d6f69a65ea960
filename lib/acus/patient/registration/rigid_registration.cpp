#include "acus/patient/registration/rigid_registration.h"

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>

#include "acus/base/core/error.h"
#include "acus/base/math/distributions.h"
#include "acus/patient/registration/correspondence.h"

namespace acus::registration {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kMinSpreadMm = 0.1;
constexpr double kMinSpreadRatio = 1e-3;

/// Differences below this are rounding, whatever their ratio.
constexpr double kFitRoundingMm = 1e-6;

transforms::Markers Centred(const transforms::Markers& markers_mm) {
  return markers_mm.colwise() - markers_mm.rowwise().mean();
}

bool IsDegenerate(const Vector3d& spread_mm) {
  return spread_mm[1] < kMinSpreadMm || spread_mm[1] < kMinSpreadRatio * spread_mm[0];
}

transforms::Markers WithoutColumn(const transforms::Markers& markers_mm, Index column) {
  const Index n = markers_mm.cols();
  transforms::Markers rest(3, n - 1);
  rest.leftCols(column) = markers_mm.leftCols(column);
  rest.rightCols(n - 1 - column) = markers_mm.rightCols(n - 1 - column);
  return rest;
}

double SumOfSquares(const MarkerFit& fit) {
  return fit.residual_mm.squaredNorm();
}

}  // namespace

Vector3d SpreadMm(const transforms::Markers& markers_mm) {
  const transforms::Markers centred = Centred(markers_mm);
  const Matrix3d scatter = centred * centred.transpose() / static_cast<double>(centred.cols());
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(scatter, Eigen::EigenvaluesOnly);
  return solver.eigenvalues().cwiseMax(0.0).cwiseSqrt().reverse();
}

MarkerFit FitMarkers(const transforms::Markers& reference_mm, const transforms::Markers& ct_mm) {
  ACUS_ASSERT(reference_mm.cols() == ct_mm.cols());
  ACUS_REQUIRE(ct_mm.cols() >= 3, "a rigid registration needs at least 3 points, got ",
               ct_mm.cols());
  for (const auto& [space, markers_mm] : {std::pair{"reference", &reference_mm}, {"CT", &ct_mm}}) {
    const Vector3d spread_mm = SpreadMm(*markers_mm);
    ACUS_REQUIRE(spread_mm[0] >= kMinSpreadMm, "the points are all at the same place in the ",
                 space, " frame (spread ", spread_mm[0],
                 " mm); was one point recorded again and again?");
    ACUS_REQUIRE(!IsDegenerate(spread_mm), "the points lie on a line in the ", space,
                 " frame (spread along it ", spread_mm[0], " mm, across it ", spread_mm[1],
                 " mm): the rotation about it cannot be found; add a point beside the line");
  }
  MarkerFit fit;
  fit.ct_from_reference.matrix() = Eigen::umeyama(reference_mm, ct_mm, /*with_scaling=*/false);
  fit.residual_mm = ct_mm - fit.ct_from_reference * reference_mm;
  fit.fre_rms_mm = std::sqrt(SumOfSquares(fit) / static_cast<double>(ct_mm.cols()));
  return fit;
}

double FleFromFreMm(double fre_rms_mm, int num_markers) {
  ACUS_ASSERT(num_markers >= 3);
  return fre_rms_mm * std::sqrt(num_markers / (num_markers - 2.0));
}

TreEstimate ExpectedTre(const transforms::Markers& markers_mm, double fle_rms_mm,
                        const Vector3d& target_mm) {
  const transforms::Markers centred = Centred(markers_mm);
  const auto n = static_cast<double>(centred.cols());
  const Matrix3d scatter = centred * centred.transpose() / n;
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(scatter);
  const Vector3d squared_spread = solver.eigenvalues().cwiseMax(0.0);
  ACUS_ASSERT(!IsDegenerate(squared_spread.cwiseSqrt().reverse()));
  // Per coordinate, a marker errs with variance s2. Then the translation errs by s2/n on each axis
  // and the rotation about principal axis k by s2/(n f_k^2); the lever is the target's position.
  const double s2 = fle_rms_mm * fle_rms_mm / 3.0;
  Matrix3d rotation_variance = Matrix3d::Zero();
  for (int k = 0; k < 3; ++k) {
    const double f2 = squared_spread.sum() - squared_spread[k];
    rotation_variance(k, k) = s2 / (n * f2);
  }
  const Vector3d lever =
      solver.eigenvectors().transpose() * (target_mm - markers_mm.rowwise().mean());
  Matrix3d cross;
  cross << 0, -lever.z(), lever.y(), lever.z(), 0, -lever.x(), -lever.y(), lever.x(), 0;
  const Matrix3d covariance =
      s2 / n * Matrix3d::Identity() + cross * rotation_variance * cross.transpose();
  TreEstimate tre;
  tre.covariance_mm2 = solver.eigenvectors() * covariance * solver.eigenvectors().transpose();
  tre.rms_mm = std::sqrt(covariance.trace());
  return tre;
}

std::vector<std::optional<LeaveOneOut>> LeaveEachOut(const transforms::Markers& reference_mm,
                                                     const transforms::Markers& ct_mm) {
  const Index n = ct_mm.cols();
  ACUS_ASSERT(n >= 4);
  const double all = SumOfSquares(FitMarkers(reference_mm, ct_mm));
  std::vector<std::optional<LeaveOneOut>> results(static_cast<std::size_t>(n));
  for (Index i = 0; i < n; ++i) {
    const transforms::Markers rest_reference_mm = WithoutColumn(reference_mm, i);
    const transforms::Markers rest_ct_mm = WithoutColumn(ct_mm, i);
    if (IsDegenerate(SpreadMm(rest_reference_mm)) || IsDegenerate(SpreadMm(rest_ct_mm))) continue;
    const MarkerFit fit = FitMarkers(rest_reference_mm, rest_ct_mm);
    LeaveOneOut& result = results[static_cast<std::size_t>(i)].emplace();
    result.predicted_error_mm =
        (ct_mm.col(i) - fit.ct_from_reference * Vector3d(reference_mm.col(i))).norm();
    result.fre_without_mm = fit.fre_rms_mm;
    if (result.predicted_error_mm < kFitRoundingMm) continue;
    const double rest = SumOfSquares(fit);
    const double freedom = 3.0 * static_cast<double>(n) - 9.0;
    const double f = std::max(0.0, all - rest) / 3.0 / (rest / freedom);  // Infinite if rest is 0.
    result.p_value = std::min(1.0, static_cast<double>(n) * math::FUpperTail(f, 3.0, freedom));
  }
  return results;
}

std::vector<Outlier> FindOutliers(const transforms::Markers& reference_mm,
                                  const transforms::Markers& ct_mm, double significance) {
  transforms::Markers rest_reference_mm = reference_mm;
  transforms::Markers rest_ct_mm = ct_mm;
  std::vector<Index> rows(static_cast<std::size_t>(ct_mm.cols()));
  for (std::size_t i = 0; i < rows.size(); ++i) rows[i] = static_cast<Index>(i);
  std::vector<Outlier> outliers;
  while (rows.size() >= 4) {
    const auto results = LeaveEachOut(rest_reference_mm, rest_ct_mm);
    std::size_t worst = results.size();
    for (std::size_t i = 0; i < results.size(); ++i) {
      if (!results[i]) continue;
      // The smallest sum of squares, not the smallest p: that may have run into 0 for several.
      if (worst == results.size() || results[i]->fre_without_mm < results[worst]->fre_without_mm) {
        worst = i;
      }
    }
    if (worst == results.size() || results[worst]->p_value >= significance) break;
    outliers.push_back({rows[worst], *results[worst]});
    rows.erase(rows.begin() + static_cast<std::ptrdiff_t>(worst));
    rest_reference_mm = WithoutColumn(rest_reference_mm, static_cast<Index>(worst));
    rest_ct_mm = WithoutColumn(rest_ct_mm, static_cast<Index>(worst));
  }
  return outliers;
}

namespace {

/// How much smaller an error must become before a mistake is named.
constexpr double kMuchBetterFit = 0.2;

constexpr double kLeastMirrorShare = 0.02;  ///< FRE of a mirror image, of the points' spread.
constexpr double kOtherUnit = 5.0;          ///< No body differs so much in size from its image.

constexpr const char* kMirrored =
    "one set of points is the mirror image of the other; is the sign of one axis wrong in one of "
    "the files?";

bool IsMirrored(const transforms::MarkerPairs& pairs, double fre_mm) {
  if (pairs.ct_mm.cols() < 4) return false;
  transforms::Markers mirrored_mm = pairs.reference_mm;
  mirrored_mm.row(0) *= -1.0;
  return FitMarkers(mirrored_mm, pairs.ct_mm).fre_rms_mm < kMuchBetterFit * fre_mm;
}

double ScaleOf(const transforms::MarkerPairs& pairs) {
  return SpreadMm(pairs.ct_mm).norm() / SpreadMm(pairs.reference_mm).norm();
}

void AddScale(const transforms::MarkerPairs& pairs, double fre_mm,
              std::vector<std::string>& mistakes) {
  const double scale = ScaleOf(pairs);
  const transforms::Markers scaled_mm = scale * pairs.reference_mm;
  if (std::abs(scale - 1.0) < 0.02) return;
  if (FitMarkers(scaled_mm, pairs.ct_mm).fre_rms_mm >= kMuchBetterFit * fre_mm) return;
  mistakes.push_back(Message("distances in the CT are ", scale,
                             " times those in the reference frame; are both files in mm?"));
}

void AddExchange(const transforms::MarkerPairs& pairs, double fre_mm,
                 std::vector<std::string>& mistakes) {
  const Index n = pairs.ct_mm.cols();
  double best_mm = kMuchBetterFit * fre_mm;
  std::string best;
  for (Index i = 0; i < n; ++i) {
    for (Index j = i + 1; j < n; ++j) {
      transforms::Markers exchanged_mm = pairs.ct_mm;
      exchanged_mm.col(i).swap(exchanged_mm.col(j));
      const double exchanged_fre_mm = FitMarkers(pairs.reference_mm, exchanged_mm).fre_rms_mm;
      if (exchanged_fre_mm >= best_mm) continue;
      best_mm = exchanged_fre_mm;
      best = Message("'", pairs.names[static_cast<std::size_t>(i)], "' and '",
                     pairs.names[static_cast<std::size_t>(j)],
                     "' seem to be exchanged: with their names swapped, FRE would be ",
                     exchanged_fre_mm, " mm");
    }
  }
  if (!best.empty()) mistakes.push_back(best);
}

void AddOrder(const transforms::MarkerPairs& pairs, std::vector<std::string>& mistakes) {
  const auto order = BetterOrder(pairs.reference_mm, pairs.ct_mm);
  if (!order) return;
  std::vector<std::string> moved;
  for (std::size_t i = 0; i < order->ct_of.size(); ++i) {
    if (order->ct_of[i] != static_cast<Index>(i)) moved.push_back(pairs.names[i]);
  }
  const std::string what =
      moved.size() == 2 ? Message("'", moved[0], "' and '", moved[1],
                                  "' seem to be exchanged: with their names swapped, FRE would be ")
                        : Message("the points seem to be in another order (",
                                  DescribeOrder(*order, pairs.names), "): then FRE would be ");
  mistakes.push_back(
      Message(what, order->fre_rms_mm, " mm; put the names right, or let --find-order do it"));
}

}  // namespace

std::vector<std::string> CommonMistakes(const transforms::MarkerPairs& pairs) {
  constexpr Index kMostToExchange = 60;  // The search is cubic in the number of points.
  const double fre_mm = FitMarkers(pairs.reference_mm, pairs.ct_mm).fre_rms_mm;
  std::vector<std::string> mistakes;
  if (fre_mm < kFitRoundingMm) return mistakes;
  AddScale(pairs, fre_mm, mistakes);
  if (IsMirrored(pairs, fre_mm)) mistakes.emplace_back(kMirrored);
  if (pairs.ct_mm.cols() <= kMostToOrder) {
    AddOrder(pairs, mistakes);
  } else if (pairs.ct_mm.cols() <= kMostToExchange) {
    AddExchange(pairs, fre_mm, mistakes);
  }
  return mistakes;
}

void RequireSameShape(const transforms::MarkerPairs& pairs) {
  const double fre_mm = FitMarkers(pairs.reference_mm, pairs.ct_mm).fre_rms_mm;
  const double scale = ScaleOf(pairs);
  ACUS_REQUIRE(scale < kOtherUnit && scale > 1.0 / kOtherUnit,
               "distances between the points in CT are ", scale,
               " times those in the other frame: one of the files is not in mm (1000: it is in "
               "metres)");
  const bool is_mirrored =
      fre_mm > kLeastMirrorShare * SpreadMm(pairs.ct_mm).norm() && IsMirrored(pairs, fre_mm);
  if (is_mirrored) throw NoAnswerError(Message(kMirrored, " FRE is ", fre_mm, " mm"));
}

}  // namespace acus::registration
