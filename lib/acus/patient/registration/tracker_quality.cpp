#include "acus/patient/registration/tracker_quality.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "acus/base/core/error.h"
#include "acus/base/math/rigid.h"
#include "acus/base/math/statistics.h"
#include "acus/patient/registration/rigid_registration.h"

namespace acus::registration {
namespace {

using Eigen::Vector3d;
using session::PoseSample;
using session::PoseStream;

constexpr double kWindowS = 0.1;
constexpr double kLeastS = 1.0;

double SecondsBetween(const PoseSample& a, const PoseSample& b) {
  return static_cast<double>(b.time_ns - a.time_ns) * 1e-9;
}

/// [first, last] of the stream, over windows.
struct Stretch {
  std::size_t first = 0;
  std::size_t last = 0;
};

struct Window {
  Stretch samples;
  Vector3d mean_mm;
};

std::vector<Window> Windows(const PoseStream& stream, const std::vector<std::size_t>& valid) {
  std::vector<Window> windows;
  std::size_t begin = 0;
  for (std::size_t i = 0; i < valid.size(); ++i) {
    const bool is_last = i + 1 == valid.size();
    if (!is_last && SecondsBetween(stream[valid[begin]], stream[valid[i + 1]]) < kWindowS) continue;
    Vector3d sum_mm = Vector3d::Zero();
    for (std::size_t j = begin; j <= i; ++j) {
      sum_mm += stream[valid[j]].reference_from_tool.translation();
    }
    windows.push_back({.samples = {valid[begin], valid[i]},
                       .mean_mm = sum_mm / static_cast<double>(i + 1 - begin)});
    begin = i + 1;
  }
  return windows;
}

Stretch LongestStill(const PoseStream& stream, const std::vector<Window>& windows,
                     double still_mm) {
  Stretch best = windows.front().samples;
  double best_s = -1.0;
  for (std::size_t begin = 0; begin < windows.size(); ++begin) {
    Eigen::AlignedBox3d box;
    std::size_t end = begin;
    while (end < windows.size()) {
      box.extend(windows[end].mean_mm);
      if (box.diagonal().norm() > still_mm) break;
      ++end;
    }
    const Stretch found{windows[begin].samples.first, windows[end - 1].samples.last};
    const double length_s = SecondsBetween(stream[found.first], stream[found.last]);
    if (length_s > best_s) {
      best = found;
      best_s = length_s;
    }
    if (end == windows.size()) break;  // Later beginnings are shorter.
  }
  return best;
}

void FillPositions(const std::vector<Vector3d>& positions_mm, Jitter& jitter) {
  const auto n = static_cast<double>(positions_mm.size());
  for (const Vector3d& p : positions_mm) jitter.mean_mm += p / n;
  std::vector<double> distances_mm;
  Vector3d slope_mm = Vector3d::Zero();
  double slope_weight = 0.0;
  for (std::size_t i = 0; i < positions_mm.size(); ++i) {
    const Vector3d off_mm = positions_mm[i] - jitter.mean_mm;
    jitter.sd_mm += off_mm.cwiseAbs2() / n;
    distances_mm.push_back(off_mm.norm());
    const double place = static_cast<double>(i) / (n - 1.0) - 0.5;
    slope_mm += place * off_mm;
    slope_weight += place * place;
  }
  jitter.sd_mm = jitter.sd_mm.cwiseSqrt();
  jitter.rms_mm = math::RootMeanSquare(distances_mm);
  jitter.p95_mm = math::Quantile(distances_mm, 0.95);
  jitter.largest_mm = *std::ranges::max_element(distances_mm);
  jitter.drift_mm = (slope_mm / slope_weight).norm();
  double second2 = 0.0;
  jitter.step_mm = std::numeric_limits<double>::infinity();
  for (std::size_t i = 2; i < positions_mm.size(); ++i) {
    // Independent errors of variance v give second differences of 6 v.
    second2 += (positions_mm[i] - 2.0 * positions_mm[i - 1] + positions_mm[i - 2]).squaredNorm() /
               (6.0 * (n - 2.0));
    const Vector3d step_mm = (positions_mm[i] - positions_mm[i - 1]).cwiseAbs();
    for (const double s : step_mm) {
      if (s > 1e-9) jitter.step_mm = std::min(jitter.step_mm, s);
    }
  }
  jitter.noise_mm = std::sqrt(second2);
  if (!std::isfinite(jitter.step_mm)) jitter.step_mm = 0.0;
}

void FillRotations(const std::vector<Eigen::Quaterniond>& rotations, Jitter& jitter) {
  // The mean quaternion with signs alike: right for jitter, which is small.
  Eigen::Vector4d sum = Eigen::Vector4d::Zero();
  for (const Eigen::Quaterniond& q : rotations) {
    sum += q.coeffs().dot(rotations.front().coeffs()) < 0.0 ? Eigen::Vector4d(-q.coeffs())
                                                            : Eigen::Vector4d(q.coeffs());
  }
  const Eigen::Quaterniond mean(Eigen::Vector4d(sum.normalized()));
  std::vector<double> angles_deg;
  for (const Eigen::Quaterniond& q : rotations) {
    angles_deg.push_back(q.angularDistance(mean) * 180.0 / std::numbers::pi);
  }
  jitter.rms_deg = math::RootMeanSquare(angles_deg);
}

}  // namespace

Jitter MeasureJitter(const PoseStream& reference_from_tool, const std::string& tool,
                     double still_mm) {
  ACUS_REQUIRE(still_mm > 0.0, "what counts as still must be above 0 mm, got ", still_mm);
  std::vector<std::size_t> valid;
  for (std::size_t i = 0; i < reference_from_tool.size(); ++i) {
    if (reference_from_tool[i].valid) valid.push_back(i);
  }
  ACUS_REQUIRE(valid.size() >= 10, tool, ": jitter needs at least 10 valid poses, there are ",
               valid.size());
  Jitter jitter;
  jitter.tool = tool;
  jitter.num_invalid = reference_from_tool.size() - valid.size();
  const Stretch still =
      LongestStill(reference_from_tool, Windows(reference_from_tool, valid), still_mm);
  jitter.first = still.first;
  jitter.last = still.last;
  jitter.whole_recording = still.first == valid.front() && still.last == valid.back();
  std::vector<Vector3d> positions_mm;
  std::vector<Eigen::Quaterniond> rotations;
  std::vector<double> intervals_s;
  const PoseSample* before = nullptr;
  for (std::size_t i = still.first; i <= still.last; ++i) {
    const PoseSample& sample = reference_from_tool[i];
    if (!sample.valid) continue;
    positions_mm.push_back(sample.reference_from_tool.translation());
    rotations.push_back(sample.reference_from_tool.quaternion());
    if (before != nullptr) {
      intervals_s.push_back(SecondsBetween(*before, sample));
      jitter.num_repeated += before->reference_from_tool == sample.reference_from_tool;
    }
    before = &sample;
  }
  jitter.num_samples = positions_mm.size();
  jitter.duration_s =
      SecondsBetween(reference_from_tool[still.first], reference_from_tool[still.last]);
  if (jitter.duration_s < kLeastS || jitter.num_samples < 10) {
    throw NoAnswerError(Message(tool, ": lay still (within ", still_mm, " mm) for only ",
                                jitter.duration_s, " s; fix it to a firm surface and record ",
                                kLeastS, " s or more"));
  }
  jitter.rate_hz = 1.0 / math::Median(intervals_s);
  FillPositions(positions_mm, jitter);
  FillRotations(rotations, jitter);
  return jitter;
}

PlaceAccuracy MeasureAccuracy(const transforms::MarkerPairs& pairs) {
  const Eigen::Index n = pairs.ct_mm.cols();
  ACUS_REQUIRE(n >= 2, "accuracy needs at least 2 places of known distance, got ", n);
  PlaceAccuracy accuracy;
  accuracy.names = pairs.names;
  std::vector<double> errors_mm;
  double products = 0.0, squares = 0.0;
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = i + 1; j < n; ++j) {
      const double true_mm = (pairs.ct_mm.col(i) - pairs.ct_mm.col(j)).norm();
      const double measured_mm = (pairs.reference_mm.col(i) - pairs.reference_mm.col(j)).norm();
      ACUS_REQUIRE(true_mm > 0.0, "'", pairs.names[static_cast<std::size_t>(i)], "' and '",
                   pairs.names[static_cast<std::size_t>(j)], "' are at the same true place");
      accuracy.distances.push_back(
          {.from = i, .to = j, .true_mm = true_mm, .error_mm = measured_mm - true_mm});
      errors_mm.push_back(measured_mm - true_mm);
      products += measured_mm * true_mm;
      squares += true_mm * true_mm;
    }
  }
  accuracy.rms_mm = math::RootMeanSquare(errors_mm);
  accuracy.mean_mm = math::Mean(errors_mm);
  accuracy.scale = products / squares;
  for (const double e : errors_mm) accuracy.largest_mm = std::max(accuracy.largest_mm, std::abs(e));
  const Vector3d spread_mm = SpreadMm(pairs.ct_mm);
  accuracy.has_places = n >= 3 && spread_mm[1] > 0.01 * spread_mm[0];
  if (accuracy.has_places) {
    const MarkerFit fit = FitMarkers(pairs.reference_mm, pairs.ct_mm);
    accuracy.place_error_mm = fit.residual_mm.colwise().norm().transpose();
    accuracy.place_rms_mm = fit.fre_rms_mm;
  }
  return accuracy;
}

}  // namespace acus::registration
