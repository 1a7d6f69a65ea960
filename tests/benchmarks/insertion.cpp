#include "benchmarks/insertion.h"

#include <cmath>
#include <numbers>

#include "acus/base/core/error.h"

namespace acus::benchmarks {

std::vector<tissue::ToolSample> ScriptedInsertion() {
  constexpr double kStepS = 1e-3;
  constexpr double kAboveMm = 3.0;
  constexpr double kDeepMm = 50.0;
  constexpr double kInMmPerS = 20.0;
  constexpr double kOutMmPerS = 40.0;
  constexpr double kAsideMm = 1.0;
  constexpr double kAsideS = 0.4;
  const double in_s = (kAboveMm + kDeepMm) / kInMmPerS;
  const double out_s = (kAboveMm + kDeepMm) / kOutMmPerS;
  const double tilt = 4.0 * std::numbers::pi / 180.0;
  const Eigen::Vector3d axis(std::sin(tilt), 0.0, -std::cos(tilt));
  const Eigen::Vector3d entry_mm(-1.3, 0.7, 0.0);
  std::vector<tissue::ToolSample> out;
  const int count = static_cast<int>((in_s + kAsideS + out_s) / kStepS);
  for (int n = 0; n <= count; ++n) {
    const double time_s = kStepS * n;
    double depth_mm = kDeepMm;
    double aside_mm = 0.0;
    if (time_s < in_s) {
      depth_mm = -kAboveMm + kInMmPerS * time_s;
    } else if (time_s < in_s + kAsideS) {
      const double s = std::sin(std::numbers::pi * (time_s - in_s) / kAsideS);
      aside_mm = kAsideMm * s * s;
    } else {
      depth_mm = kDeepMm - kOutMmPerS * (time_s - in_s - kAsideS);
    }
    tissue::ToolSample sample;
    sample.time_s = time_s;
    sample.axis_in_ct = axis;
    sample.tip_in_ct_mm = entry_mm + depth_mm * axis + Eigen::Vector3d(0.0, aside_mm, 0.0);
    out.push_back(sample);
  }
  return out;
}

double RmsDifferenceN(const InsertionRun& a, const InsertionRun& b) {
  ACUS_ASSERT(a.force_n.size() == b.force_n.size() && !a.force_n.empty());
  double sum = 0.0;
  for (std::size_t n = 0; n < a.force_n.size(); ++n) {
    sum += (a.force_n[n] - b.force_n[n]).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(a.force_n.size()));
}

std::string WhyUnusable(const InsertionRun& run, const std::vector<tissue::ToolSample>& samples,
                        double largest_n) {
  double most_n = 0.0;
  double work_n_mm = 0.0;
  for (std::size_t n = 0; n < run.force_n.size(); ++n) {
    if (!run.force_n[n].allFinite()) return Message("the force of sample ", n, " is not finite");
    most_n = std::max(most_n, run.force_n[n].norm());
    if (n == 0) continue;
    const Eigen::Vector3d way_mm = samples[n].tip_in_ct_mm - samples[n - 1].tip_in_ct_mm;
    work_n_mm -= 0.5 * (run.force_n[n] + run.force_n[n - 1]).dot(way_mm);
  }
  if (most_n > largest_n * (1.0 + 1e-12)) {
    return Message("a force of ", most_n, " N is above the largest allowed, ", largest_n);
  }
  if (most_n < 1e-3) return Message("the largest force is ", most_n, " N: nothing was touched");
  if (run.force_n.back().norm() > 1e-9) return "a force is left when the needle is out";
  if (!(work_n_mm > 0.0)) {
    return Message("the tissue gave ", -work_n_mm, " N mm more than it was given");
  }
  return {};
}

}  // namespace acus::benchmarks
