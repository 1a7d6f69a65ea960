#include "acus/patient/registration/outlier_search.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "acus/base/core/error.h"
#include "acus/base/math/distributions.h"

namespace acus::registration {
namespace {

using Eigen::Index;
using Eigen::Vector3d;
using Set = std::vector<Index>;

constexpr double kMostSets = 50000.0;
constexpr double kOutlierRoundingMm = 1e-6;  ///< Sums of squares below its square are rounding.
constexpr double kLineRatio = 1e-3;
constexpr double kFarInFle = 5.0;

double Binomial(Index n, Index k) {
  double value = 1.0;
  for (Index i = 1; i <= k; ++i) value *= static_cast<double>(n - k + i) / static_cast<double>(i);
  return value;
}

Set Others(Index count, const Set& out) {
  Set rest;
  for (Index i = 0; i < count; ++i) {
    if (std::ranges::find(out, i) == out.end()) rest.push_back(i);
  }
  return rest;
}

struct Pairs {
  const transforms::Markers& reference_mm;
  const transforms::Markers& ct_mm;

  bool Determined(const Set& kept) const {
    if (kept.size() < 3) return false;
    for (const transforms::Markers* markers_mm : {&reference_mm, &ct_mm}) {
      const Vector3d spread_mm = SpreadMm((*markers_mm)(Eigen::all, kept));
      if (spread_mm[1] < 0.1 || spread_mm[1] < kLineRatio * spread_mm[0]) return false;
    }
    return true;
  }
  MarkerFit Fit(const Set& kept) const {
    return FitMarkers(reference_mm(Eigen::all, kept), ct_mm(Eigen::all, kept));
  }
  /// Sum of squares without `out`; infinite if the others do not determine a pose.
  double Sum(const Set& out) const {
    const Set kept = Others(ct_mm.cols(), out);
    if (!Determined(kept)) return std::numeric_limits<double>::infinity();
    return Fit(kept).residual_mm.squaredNorm();
  }
};

/// The best set of each size and the best that shares not all its members.
struct Best {
  Set out;
  double sum = std::numeric_limits<double>::infinity();
  Set second;
  double second_sum = std::numeric_limits<double>::infinity();

  void Offer(const Set& candidate, double value) {
    if (value < sum) {
      second = std::exchange(out, candidate);
      second_sum = std::exchange(sum, value);
    } else if (value < second_sum) {
      second = candidate;
      second_sum = value;
    }
  }
};

Best BestOfSize(const Pairs& pairs, Index size) {
  const Index n = pairs.ct_mm.cols();
  Best best;
  Set chosen(static_cast<std::size_t>(size));
  for (Index i = 0; i < size; ++i) chosen[static_cast<std::size_t>(i)] = i;
  while (true) {
    best.Offer(chosen, pairs.Sum(chosen));
    Index at = size - 1;
    while (at >= 0 && chosen[static_cast<std::size_t>(at)] == n - size + at) --at;
    if (at < 0) return best;
    ++chosen[static_cast<std::size_t>(at)];
    for (Index i = at + 1; i < size; ++i) {
      chosen[static_cast<std::size_t>(i)] = chosen[static_cast<std::size_t>(i - 1)] + 1;
    }
  }
}

/// Holds the improvement by omitting `removed` more markers against what remains.
class Judge {
 public:
  Judge(Index count, std::optional<double> fle_rms_mm) : count_(count), fle_rms_mm_(fle_rms_mm) {}

  double P(double sum_with, double sum_without, Index out_before, Index out_after) const {
    const double removed = 3.0 * static_cast<double>(out_after - out_before);
    const double gain = std::max(0.0, sum_with - sum_without);
    if (gain < kOutlierRoundingMm * kOutlierRoundingMm) return 1.0;
    if (fle_rms_mm_) {
      return math::ChiSquareUpperTail(gain / (*fle_rms_mm_ * *fle_rms_mm_ / 3.0), removed);
    }
    const double freedom = 3.0 * static_cast<double>(count_ - out_after) - 6.0;
    const double rest = std::max(sum_without, kOutlierRoundingMm * kOutlierRoundingMm * 1e-6);
    return math::FUpperTail(gain / removed / (rest / freedom), removed, freedom);
  }

  /// Whether two ways to omit as many are too alike to choose.
  bool AreAlike(double sum, double other, Index out) const {
    if (!std::isfinite(other)) return false;
    const double freedom = 3.0 * static_cast<double>(count_ - out) - 6.0;
    const double floor = kOutlierRoundingMm * kOutlierRoundingMm;
    if (fle_rms_mm_) return other - sum < 9.0 * *fle_rms_mm_ * *fle_rms_mm_ / 3.0;
    return math::FUpperTail(std::max(other, floor) / std::max(sum, floor), freedom, freedom) > 0.05;
  }

 private:
  Index count_;
  std::optional<double> fle_rms_mm_;
};

/// Whether every omitted marker lies far beyond the scatter of the others: markers on skin
/// or in tissue do not all scatter alike, which the F test takes for granted.
bool EachIsFar(const Pairs& pairs, const Best& best) {
  const Set kept = Others(pairs.ct_mm.cols(), best.out);
  const MarkerFit fit = pairs.Fit(kept);
  const double freedom = 3.0 * static_cast<double>(kept.size()) - 6.0;
  const double fle_mm = std::sqrt(3.0 * best.sum / freedom);
  return std::ranges::all_of(best.out, [&](Index i) {
    const Vector3d reference_mm = pairs.reference_mm.col(i), ct_mm = pairs.ct_mm.col(i);
    return (ct_mm - fit.ct_from_reference * reference_mm).norm() > kFarInFle * fle_mm;
  });
}

bool EachIsWrong(const Pairs& pairs, const Judge& judge, const Best& best, double significance) {
  const auto size = static_cast<Index>(best.out.size());
  const auto choices = static_cast<double>(pairs.ct_mm.cols() - size + 1);
  for (std::size_t i = 0; i < best.out.size(); ++i) {
    Set fewer = best.out;
    fewer.erase(fewer.begin() + static_cast<std::ptrdiff_t>(i));
    if (choices * judge.P(pairs.Sum(fewer), best.sum, size - 1, size) >= significance) return false;
  }
  return true;
}

void FillErrors(const Pairs& pairs, OutlierSearch& search) {
  const MarkerFit fit = pairs.Fit(Others(pairs.ct_mm.cols(), search.wrong));
  search.fre_without_mm = fit.fre_rms_mm;
  const Eigen::VectorXd error_mm =
      (pairs.ct_mm - fit.ct_from_reference * pairs.reference_mm).colwise().norm();
  search.error_mm.assign(error_mm.begin(), error_mm.end());
  std::ranges::sort(search.wrong, [&](Index a, Index b) { return error_mm[a] > error_mm[b]; });
}

/// One by one, for what exhaustive search cannot reach.
void GoOn(const Pairs& pairs, double significance, OutlierSearch& search) {
  const Set kept = Others(pairs.ct_mm.cols(), search.wrong);
  for (const Outlier& outlier : FindOutliers(pairs.reference_mm(Eigen::all, kept),
                                             pairs.ct_mm(Eigen::all, kept), significance)) {
    search.wrong.push_back(kept[static_cast<std::size_t>(outlier.marker)]);
  }
}

}  // namespace

int MostOutliers(Index num_markers) {
  if (num_markers < 4) return 0;
  return static_cast<int>(std::max<Index>(1, std::min(num_markers - 4, num_markers / 2 - 1)));
}

OutlierSearch SearchOutliers(const transforms::Markers& reference_mm,
                             const transforms::Markers& ct_mm, std::optional<double> fle_rms_mm,
                             double significance) {
  const Index n = ct_mm.cols();
  const Pairs pairs{reference_mm, ct_mm};
  const Judge judge(n, fle_rms_mm);
  const double all = pairs.Fit(Others(n, {})).residual_mm.squaredNorm();
  OutlierSearch search;
  const Index most = MostOutliers(n);
  double sets = 0.0;
  Index reached = 0;
  for (Index k = 1; k <= most; ++k) {
    sets += Binomial(n, k);
    if (sets > kMostSets) break;
    reached = k;
    const Best best = BestOfSize(pairs, k);
    const double p = std::min(1.0, Binomial(n, k) * judge.P(all, best.sum, 0, k));
    if (p >= significance || !EachIsWrong(pairs, judge, best, significance)) continue;
    if (!fle_rms_mm && !EachIsFar(pairs, best)) continue;
    search.wrong = best.out;
    search.p_value = p;
    search.instead.clear();
    if (judge.AreAlike(best.sum, best.second_sum, k)) search.instead = best.second;
  }
  if (reached < most && static_cast<Index>(search.wrong.size()) == reached) {
    GoOn(pairs, significance, search);
  }
  FillErrors(pairs, search);
  return search;
}

}  // namespace acus::registration
