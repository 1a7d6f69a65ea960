#include "acus/patient/registration/temporal.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <span>

#include "acus/base/core/error.h"
#include "acus/base/math/statistics.h"

namespace acus::registration {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kFeatures = 13;  // 1, position, rotation matrix.
constexpr std::size_t kLeastSamples = 40;
constexpr std::size_t kMostSamples = 2000;
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
    double share = 0.0;      ///< Of the variance that is explained.
    double residual2 = 0.0;  ///< Sum of squares.
    MatrixXd values;         ///< One row per sample; 0 where the pose is not valid.
    std::size_t num_used = 0;
  };

  Prediction At(double lag_s) const {
    const auto lag_ns = static_cast<std::int64_t>(std::llround(lag_s * kNanosecondsPerS));
    MatrixXd features = MatrixXd::Zero(signal_.values.rows(), kFeatures);
    MatrixXd target = MatrixXd::Zero(signal_.values.rows(), signal_.values.cols());
    Prediction out;
    for (Eigen::Index i = 0; i < features.rows(); ++i) {
      const auto pose =
          session::PoseAt(tracker_, signal_.time_ns[static_cast<std::size_t>(i)] + lag_ns);
      if (!pose.valid) continue;
      features.row(i) = FeaturesOf(pose.reference_from_tool.isometry()).transpose();
      target.row(i) = signal_.values.row(i);
      ++out.num_used;
    }
    if (out.num_used < kLeastSamples) return out;
    const auto count = static_cast<double>(out.num_used);
    Centre(features, count);
    const Eigen::RowVectorXd mean = target.colwise().sum() / count;
    for (Eigen::Index i = 0; i < target.rows(); ++i) {
      if (features(i, 0) != 0.0) target.row(i) -= mean;
    }
    MatrixXd normal = features.transpose() * features;
    normal.diagonal().array() += 1e-9 * count;
    const MatrixXd weights = normal.ldlt().solve(features.transpose() * target);
    out.values = features * weights;
    out.residual2 = (target - out.values).squaredNorm();
    const double total = target.squaredNorm();
    out.share = total > 0.0 ? 1.0 - out.residual2 / total : 0.0;
    return out;
  }

 private:
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

TemporalCalibration CalibrateTime(const session::PoseStream& tracker, const MotionSignal& signal,
                                  const TemporalSettings& settings) {
  ACUS_REQUIRE(settings.max_lag_s > 0.0, "max_lag_s is ", settings.max_lag_s, "; it must be > 0");
  ACUS_REQUIRE(tracker.size() >= kLeastSamples && signal.time_ns.size() >= kLeastSamples,
               "a temporal calibration needs at least ", kLeastSamples,
               " samples of each recording, got ", tracker.size(), " and ", signal.time_ns.size());
  const MotionSignal covered = Covered(tracker, signal, settings.max_lag_s);
  const Predictor predictor(tracker, covered);
  const double interval_s = MedianIntervalS(covered.time_ns);
  const double step_s =
      std::clamp(0.25 * interval_s, settings.max_lag_s / 500.0, settings.max_lag_s / 20.0);
  const int reach = static_cast<int>(std::floor(settings.max_lag_s / step_s));
  TemporalCalibration found;
  for (int i = -reach; i <= reach; ++i) {
    found.searched_lag_s.push_back(i * step_s);
    found.searched_share.push_back(predictor.At(i * step_s).share);
  }
  const auto best = static_cast<std::size_t>(std::ranges::max_element(found.searched_share) -
                                             found.searched_share.begin());
  RequireAnswer(found, best, settings);
  found.lag_s = ParabolaPeak(found.searched_lag_s, found.searched_share, best, 4);
  const auto at = predictor.At(found.lag_s);
  const MatrixXd slope =
      (predictor.At(found.lag_s + step_s).values - predictor.At(found.lag_s - step_s).values) /
      (2.0 * step_s);
  const auto count = static_cast<double>(at.num_used) * static_cast<double>(covered.values.cols());
  const double variance =
      at.residual2 / std::max(1.0, count - kFeatures * static_cast<double>(covered.values.cols()));
  found.sd_s = std::sqrt(variance / std::max(1e-300, slope.squaredNorm()));
  found.explained_share = at.share;
  found.num_samples = at.num_used;
  return found;
}

}  // namespace acus::registration
