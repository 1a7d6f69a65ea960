#include "acus/patient/registration/temporal.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <optional>
#include <span>

#include "acus/base/core/error.h"
#include "acus/base/math/distributions.h"
#include "acus/base/math/statistics.h"

namespace acus::registration {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kFeatures = 13;  // 1, position, rotation matrix.
constexpr std::size_t kLeastSamples = 40;
constexpr std::size_t kMostSamples = 2000;
constexpr std::size_t kLeastCycles = 6;
constexpr double kNanosecondsPerS = 1e9;
/// Another peak that leaves less than this times the residual variance is as good.
constexpr double kAmbiguousRatio = 1.5;

Eigen::Matrix<double, kFeatures, 1> FeaturesOf(const Eigen::Isometry3d& pose) {
  Eigen::Matrix<double, kFeatures, 1> features;
  features << 1.0, pose.translation(), pose.linear().reshaped();
  return features;
}

double MedianIntervalS(std::span<const std::int64_t> time_ns) {
  std::vector<double> intervals_s;
  for (std::size_t i = 1; i < time_ns.size(); ++i) {
    intervals_s.push_back(static_cast<double>(time_ns[i] - time_ns[i - 1]) / kNanosecondsPerS);
  }
  return math::Median(intervals_s);
}

/// The samples of the signal that the tracker covers at every lag of the search.
MotionSignal Covered(const session::PoseStream& tracker, const MotionSignal& signal,
                     double max_lag_s) {
  const auto margin_ns = static_cast<std::int64_t>(max_lag_s * kNanosecondsPerS);
  std::vector<Eigen::Index> rows;
  for (std::size_t i = 0; i < signal.time_ns.size(); ++i) {
    const bool covered = signal.time_ns[i] - margin_ns >= tracker.front().time_ns &&
                         signal.time_ns[i] + margin_ns <= tracker.back().time_ns;
    if (covered) rows.push_back(static_cast<Eigen::Index>(i));
  }
  ACUS_REQUIRE(rows.size() >= kLeastSamples, "only ", rows.size(),
               " samples of the second recording have poses of the first within ", max_lag_s,
               " s before and after; at least ", kLeastSamples,
               " are needed: record longer, search less (--max-lag-s), or give the rough "
               "difference of the clocks (--delay-s)");
  const std::size_t step = (rows.size() + kMostSamples - 1) / kMostSamples;
  MotionSignal out;
  for (std::size_t i = 0; i < rows.size(); i += step) {
    out.time_ns.push_back(signal.time_ns[static_cast<std::size_t>(rows[i])]);
  }
  out.values.resize(static_cast<Eigen::Index>(out.time_ns.size()), signal.values.cols());
  for (Eigen::Index i = 0; i < out.values.rows(); ++i) {
    out.values.row(i) = signal.values.row(rows[static_cast<std::size_t>(i) * step]);
  }
  return out;
}

/// Predicts the signal from the motion at one lag.
class Predictor {
 public:
  Predictor(const session::PoseStream& tracker, const MotionSignal& signal)
      : tracker_(tracker), signal_(signal) {}

  struct Prediction {
    double share = 0.0;  ///< Of the variance that is explained.
    MatrixXd features;   ///< One row per sample; 0 where the pose is not valid.
    MatrixXd weights;    ///< Of the features.
    MatrixXd values;     ///< features * weights.
    MatrixXd residual;   ///< Signal less values.
    std::size_t num_used = 0;
  };

  Prediction At(double lag_s) const {
    Prediction out;
    out.features = Features(lag_s);
    MatrixXd target = signal_.values;
    for (Eigen::Index i = 0; i < target.rows(); ++i) {
      if (out.features(i, 0) == 0.0) target.row(i).setZero();
    }
    out.num_used = static_cast<std::size_t>(std::lround(out.features.col(0).sum()));
    if (out.num_used < kLeastSamples) return out;
    const auto count = static_cast<double>(out.num_used);
    const Eigen::RowVectorXd mean = target.colwise().sum() / count;
    target -= out.features.col(0) * mean;
    out.weights = Normal(out.features).ldlt().solve(out.features.transpose() * target);
    out.values = out.features * out.weights;
    out.residual = target - out.values;
    const double total = target.squaredNorm();
    out.share = total > 0.0 ? 1.0 - out.residual.squaredNorm() / total : 0.0;
    return out;
  }

  /// d values / d lag, less what a change of the weights takes back.
  MatrixXd Slope(const Prediction& at, double lag_s, double step_s) const {
    const MatrixXd before = Features(lag_s - step_s), after = Features(lag_s + step_s);
    MatrixXd slope = (after - before) * at.weights / (2.0 * step_s);
    for (Eigen::Index i = 0; i < slope.rows(); ++i) {
      if (before(i, 0) == 0.0 || after(i, 0) == 0.0) slope.row(i).setZero();
    }
    return slope - at.features * Normal(at.features).ldlt().solve(at.features.transpose() * slope);
  }

 private:
  MatrixXd Features(double lag_s) const {
    const auto lag_ns = static_cast<std::int64_t>(std::llround(lag_s * kNanosecondsPerS));
    MatrixXd features = MatrixXd::Zero(signal_.values.rows(), kFeatures);
    for (Eigen::Index i = 0; i < features.rows(); ++i) {
      const auto pose =
          session::PoseAt(tracker_, signal_.time_ns[static_cast<std::size_t>(i)] + lag_ns);
      if (!pose.valid) continue;
      features.row(i) = FeaturesOf(pose.reference_from_tool.isometry()).transpose();
    }
    Centre(features, std::max(1.0, features.col(0).sum()));
    return features;
  }

  static MatrixXd Normal(const MatrixXd& features) {
    MatrixXd normal = features.transpose() * features;
    normal.diagonal().array() += 1e-9 * features.col(0).sum();
    return normal;
  }

  /// Columns of zero mean and unit variance; those that do not vary become 0.
  static void Centre(MatrixXd& features, double count) {
    const VectorXd used = features.col(0);
    for (Eigen::Index c = 1; c < features.cols(); ++c) {
      features.col(c) -= features.col(c).sum() / count * used;
      const double sd = std::sqrt(features.col(c).squaredNorm() / count);
      features.col(c) *= sd > 1e-9 ? 1.0 / sd : 0.0;
    }
  }

  const session::PoseStream& tracker_;
  const MotionSignal& signal_;
};

/// Largest value of the parabola through the points near the best one.
double ParabolaPeak(const std::vector<double>& x, const std::vector<double>& y, std::size_t best,
                    std::size_t reach) {
  const std::size_t first = best - std::min(best, reach);
  const std::size_t last = std::min(x.size() - 1, best + reach);
  const auto count = static_cast<Eigen::Index>(last - first + 1);
  MatrixXd terms(count, 3);
  VectorXd values(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const double offset = x[first + static_cast<std::size_t>(i)] - x[best];
    terms.row(i) << 1.0, offset, offset * offset;
    values[i] = y[first + static_cast<std::size_t>(i)];
  }
  const VectorXd fit = terms.colPivHouseholderQr().solve(values);
  if (!(fit[2] < 0.0)) return x[best];
  const double offset = -0.5 * fit[1] / fit[2];
  return x[best] + std::clamp(offset, x[first] - x[best], x[last] - x[best]);
}

void RequireAnswer(const TemporalCalibration& found, std::size_t best,
                   const TemporalSettings& settings) {
  const auto& share = found.searched_share;
  if (share[best] < settings.least_share) {
    throw NoAnswerError(Message(
        "the motion of the first recording explains ", std::lround(100.0 * share[best]),
        " % of the second at best, at least ", std::lround(100.0 * settings.least_share),
        " % are needed: are both of the same body in the same minute? Move it by more than the "
        "tracker's noise, back and forth at changing speed; --max-lag-s searches further"));
  }
  if (best == 0 || best + 1 == share.size()) {
    throw NoAnswerError(Message("the best lag, ", found.searched_lag_s[best],
                                " s, is at the end of the search; extend it with --max-lag-s, or "
                                "give the rough difference of the clocks (--delay-s)"));
  }
  for (std::size_t i = 1; i + 1 < share.size(); ++i) {
    const bool is_peak = share[i] > share[i - 1] && share[i] >= share[i + 1];
    const bool is_apart =
        *std::min_element(share.begin() + static_cast<std::ptrdiff_t>(std::min(i, best)),
                          share.begin() + static_cast<std::ptrdiff_t>(std::max(i, best))) <
        0.5 * share[best];
    if (i != best && is_peak && is_apart &&
        1.0 - share[i] < kAmbiguousRatio * (1.0 - share[best])) {
      throw NoAnswerError(Message("a lag of ", found.searched_lag_s[i],
                                  " s explains the motion as "
                                  "well as one of ",
                                  found.searched_lag_s[best],
                                  " s: it repeats itself; move at changing speed, or search less "
                                  "(--max-lag-s)"));
    }
  }
}

}  // namespace

MotionSignal PositionsOf(const session::PoseStream& stream) {
  MotionSignal signal;
  std::vector<Eigen::Vector3d> positions;
  for (const session::PoseSample& sample : stream) {
    if (!sample.valid) continue;
    signal.time_ns.push_back(sample.time_ns);
    positions.push_back(sample.reference_from_tool.translation());
  }
  signal.values.resize(static_cast<Eigen::Index>(positions.size()), 3);
  for (std::size_t i = 0; i < positions.size(); ++i) {
    signal.values.row(static_cast<Eigen::Index>(i)) = positions[i].transpose();
  }
  return signal;
}

namespace {

/// The number of the motion's cycle that each sample is in: a cycle begins where the predicted
/// signal rises through its mean. With few of them, equal parts of the time.
std::vector<std::size_t> CyclesOf(const MatrixXd& predicted) {
  Eigen::Index widest = 0;
  predicted.colwise().squaredNorm().maxCoeff(&widest);
  std::vector<std::size_t> cycle;
  std::size_t number = 0;
  for (Eigen::Index i = 0; i < predicted.rows(); ++i) {
    if (i > 0 && predicted(i - 1, widest) < 0.0 && predicted(i, widest) >= 0.0) ++number;
    cycle.push_back(number);
  }
  if (number + 1 >= kLeastCycles) return cycle;
  for (std::size_t i = 0; i < cycle.size(); ++i) cycle[i] = i * kLeastCycles / cycle.size();
  return cycle;
}

/// The lag of one detector, and what each sample adds to it.
struct DetectorLag {
  TemporalCalibration found;
  VectorXd influence_s;
  MatrixXd predicted;
};

DetectorLag LagOf(const session::PoseStream& tracker, const MotionSignal& covered,
                  const TemporalSettings& settings) {
  const Predictor predictor(tracker, covered);
  const double interval_s = MedianIntervalS(covered.time_ns);
  const double step_s =
      std::clamp(0.25 * interval_s, settings.max_lag_s / 500.0, settings.max_lag_s / 20.0);
  const int reach = static_cast<int>(std::floor(settings.max_lag_s / step_s));
  DetectorLag lag;
  TemporalCalibration& found = lag.found;
  for (int i = -reach; i <= reach; ++i) {
    found.searched_lag_s.push_back(i * step_s);
    found.searched_share.push_back(predictor.At(i * step_s).share);
  }
  const auto best = static_cast<std::size_t>(std::ranges::max_element(found.searched_share) -
                                             found.searched_share.begin());
  RequireAnswer(found, best, settings);
  found.lag_s = ParabolaPeak(found.searched_lag_s, found.searched_share, best, 4);
  const auto at = predictor.At(found.lag_s);
  const MatrixXd slope = predictor.Slope(at, found.lag_s, step_s);
  lag.influence_s =
      at.residual.cwiseProduct(slope).rowwise().sum() / std::max(1e-300, slope.squaredNorm());
  lag.predicted = at.values;
  found.explained_share = at.share;
  found.num_samples = at.num_used;
  return lag;
}

/// Standard error and interval of the mean lag, from the scatter over cycles and over detectors.
void StateError(const std::vector<DetectorLag>& lags, TemporalCalibration& found) {
  const std::vector<std::size_t> cycle = CyclesOf(lags.front().predicted);
  const auto num_detectors = static_cast<double>(lags.size());
  std::vector<double> of_cycle(cycle.back() + 1, 0.0);
  for (const DetectorLag& lag : lags) {
    for (std::size_t i = 0; i < cycle.size(); ++i) {
      of_cycle[cycle[i]] += lag.influence_s[static_cast<Eigen::Index>(i)] / num_detectors;
    }
  }
  const auto num_cycles = static_cast<double>(of_cycle.size());
  double over_cycles_s2 = 0.0;
  for (const double part : of_cycle) over_cycles_s2 += part * part;
  over_cycles_s2 *= num_cycles / (num_cycles - 1.0);
  double over_detectors_s2 = 0.0;
  if (lags.size() > 1) {
    const double sd_s = math::StandardDeviation(found.detector_lag_s);
    over_detectors_s2 = sd_s * sd_s / num_detectors;
  }
  const double variance_s2 = over_cycles_s2 + over_detectors_s2;
  // Welch & Satterthwaite: degrees of freedom of the sum.
  double inverse = over_cycles_s2 * over_cycles_s2 / (num_cycles - 1.0);
  if (lags.size() > 1) inverse += over_detectors_s2 * over_detectors_s2 / (num_detectors - 1.0);
  const double freedom = inverse > 0.0 ? std::max(1.0, variance_s2 * variance_s2 / inverse) : 1.0;
  found.num_cycles = static_cast<int>(of_cycle.size());
  found.sd_s = std::sqrt(variance_s2);
  found.half_width_s = math::StudentQuantile(0.975, freedom) * found.sd_s;
}

}  // namespace

TemporalCalibration CalibrateTime(const session::PoseStream& tracker, const MotionSignal& signal,
                                  const TemporalSettings& settings) {
  return CalibrateTime(tracker, std::span(&signal, 1), settings);
}

TemporalCalibration CalibrateTime(const session::PoseStream& tracker,
                                  std::span<const MotionSignal> detectors,
                                  const TemporalSettings& settings) {
  ACUS_ASSERT(!detectors.empty());
  ACUS_REQUIRE(settings.max_lag_s > 0.0, "max_lag_s is ", settings.max_lag_s, "; it must be > 0");
  const std::size_t num_samples = detectors.front().time_ns.size();
  ACUS_REQUIRE(tracker.size() >= kLeastSamples && num_samples >= kLeastSamples,
               "a temporal calibration needs at least ", kLeastSamples,
               " samples of each recording, got ", tracker.size(), " and ", num_samples);
  std::vector<DetectorLag> lags;
  std::optional<NoAnswerError> refused;
  for (const MotionSignal& detector : detectors) {
    try {
      lags.push_back(LagOf(tracker, Covered(tracker, detector, settings.max_lag_s), settings));
    } catch (const NoAnswerError& error) {
      if (!refused) refused = error;
    }
  }
  if (lags.empty()) throw NoAnswerError(*refused);
  TemporalCalibration found = lags.front().found;
  found.lag_s = 0.0;
  for (const DetectorLag& lag : lags) {
    found.detector_lag_s.push_back(lag.found.lag_s);
    found.lag_s += lag.found.lag_s / static_cast<double>(lags.size());
    found.explained_share = std::min(found.explained_share, lag.found.explained_share);
  }
  StateError(lags, found);
  return found;
}

}  // namespace acus::registration
