#include "benchmarks/sampled_run.h"

#include <algorithm>
#include <numbers>

#include "acus/base/core/error.h"

namespace acus::benchmarks {
namespace {

struct Knot {
  double time_s;
  double depth_mm;
};
constexpr Knot kKnots[] = {{0.0, -3.0}, {2.5, 46.0}, {3.5, 46.0}, {4.2, 24.0},
                           {5.2, 44.0}, {5.7, 44.0}, {7.3, -4.0}, {kSmoothInsertionS, -4.0}};
constexpr double kAsideFromS = 2.6;
constexpr double kAsideS = 0.8;
constexpr double kAsideMm = 1.0;
constexpr double kLeanRad = 3.0 * std::numbers::pi / 180.0;
constexpr double kTiltRad = 4.0 * std::numbers::pi / 180.0;

double DepthMm(double time_s) {
  double depth_mm = kKnots[0].depth_mm;
  for (std::size_t i = 1; i < std::size(kKnots); ++i) {
    const double s = std::clamp(
        (time_s - kKnots[i - 1].time_s) / (kKnots[i].time_s - kKnots[i - 1].time_s), 0.0, 1.0);
    const double share = s * s * s * (10.0 + s * (-15.0 + 6.0 * s));
    depth_mm += share * (kKnots[i].depth_mm - kKnots[i - 1].depth_mm);
  }
  return depth_mm;
}

}  // namespace

tissue::ToolSample SmoothInsertion(double time_s) {
  const double s = std::clamp((time_s - kAsideFromS) / kAsideS, 0.0, 1.0);
  const double sine = std::sin(std::numbers::pi * s);
  const double aside = sine * sine * sine * sine;
  const Eigen::Vector3d along(std::sin(kTiltRad), 0.0, -std::cos(kTiltRad));
  const Eigen::Vector3d entry_mm(-1.3, 0.7, 0.0);
  tissue::ToolSample sample;
  sample.time_s = time_s;
  sample.tip_in_ct_mm =
      entry_mm + DepthMm(time_s) * along + kAsideMm * aside * Eigen::Vector3d::UnitY();
  sample.axis_in_ct = Eigen::AngleAxisd(kLeanRad * aside, Eigen::Vector3d::UnitX()) * along;
  return sample;
}

std::vector<tissue::ToolSample> SamplesEvery(double step_ms) {
  const double per_common = 1e3 * kCommonStepS / step_ms;
  ACUS_REQUIRE(step_ms > 0.0 && std::abs(per_common - std::round(per_common)) < 1e-6, "steps of ",
               step_ms, " ms do not divide the ", 1e3 * kCommonStepS,
               " ms at which forces are compared");
  const auto count = static_cast<int>(std::lround(kSmoothInsertionS / kCommonStepS * per_common));
  std::vector<tissue::ToolSample> samples;
  samples.reserve(static_cast<std::size_t>(count) + 1);
  for (int n = 0; n <= count; ++n) samples.push_back(SmoothInsertion(1e-3 * step_ms * n));
  return samples;
}

ForceDifference Difference(const SampledRun& run, const SampledRun& reference, double step_ms) {
  ACUS_ASSERT(run.force_n.size() == reference.force_n.size() && !run.force_n.empty());
  ForceDifference out;
  double sum = 0.0;
  int count = 0;
  for (std::size_t n = 0; n < run.force_n.size(); ++n) {
    const double time_s = kCommonStepS * static_cast<double>(n);
    const bool at_event = std::ranges::any_of(reference.event_s, [&](double event_s) {
      return std::abs(time_s - event_s) <= 2e-3 * step_ms + 1e-9;
    });
    if (at_event) continue;
    const double off_n = (run.force_n[n] - reference.force_n[n]).norm();
    sum += off_n * off_n;
    ++count;
    out.largest_n = std::max(out.largest_n, off_n);
  }
  out.rms_n = std::sqrt(sum / std::max(1, count));
  return out;
}

std::string WhyUnusable(const SampledRun& run, double largest_n) {
  double most_n = 0.0;
  for (const Eigen::Vector3d& force_n : run.force_n) {
    if (!force_n.allFinite()) return "a force is not finite";
    most_n = std::max(most_n, force_n.norm());
  }
  if (most_n > largest_n * (1.0 + 1e-12)) {
    return Message("a force of ", most_n, " N is above the largest allowed, ", largest_n);
  }
  if (most_n < 1e-3) return Message("the largest force is ", most_n, " N: nothing was touched");
  return {};
}

}  // namespace acus::benchmarks
