// One smooth motion of a needle, sampled at any step size, through any force model: what forces at
// different steps are compared on.
#pragma once

#include <Eigen/Dense>
#include <cmath>
#include <string>
#include <vector>

#include "acus/base/core/cpu_time.h"
#include "acus/physics/forces/path/needle_sample.h"
#include "acus/physics/tissue/tool_sample.h"

namespace acus::benchmarks {

/// The needle at a moment: in through the layers of TissueBlock to 46 mm, askew by 4 degrees; there
/// aside by 1 mm and leaning by 3 degrees more, and back; half way out, in again, and out. Two
/// times differentiable, so that samples at any rate are of one motion.
tissue::ToolSample SmoothInsertion(double time_s);
constexpr double kSmoothInsertionS = 7.5;

/// Forces are kept at moments that all step sizes have in common.
constexpr double kCommonStepS = 0.01;

struct SampledRun {
  std::vector<Eigen::Vector3d> force_n;  ///< On the needle, CT axes, every kCommonStepS.
  std::vector<double> event_s;           ///< When the model told an event.
  std::vector<double> step_us;           ///< CPU time of a step, means over `steps_per_timing`.
};

/// @param step_ms  a divisor of kCommonStepS.
/// @return samples of SmoothInsertion. @throws InputError if it does not divide it.
std::vector<tissue::ToolSample> SamplesEvery(double step_ms);

/// Steps `model` through all samples.
/// @param steps_per_timing  reading the clock takes 0.2 us: for cheap models time several at once.
template <typename Model>
SampledRun RunSampled(const Model& model, const std::vector<tissue::ToolSample>& samples,
                      int steps_per_timing) {
  SampledRun run;
  auto state = model.NewState();
  const double step_s = samples[1].time_s - samples[0].time_s;
  const auto every = static_cast<std::size_t>(std::lround(kCommonStepS / step_s));
  double before_s = ThreadCpuSeconds();
  int timed = 0;
  for (std::size_t n = 0; n < samples.size(); ++n) {
    const forces::NeedleForce force = model.Step(state, samples[n]);
    if (++timed == steps_per_timing) {
      const double now_s = ThreadCpuSeconds();
      run.step_us.push_back(1e6 * (now_s - before_s) / timed);
      timed = 0;
      before_s = ThreadCpuSeconds();
    }
    if (n % every == 0) run.force_n.push_back(force.force_in_ct_n);
    if (force.event != forces::NeedleEvent::kNone) run.event_s.push_back(samples[n].time_s);
  }
  return run;
}

/// How far the forces of two runs are apart, at all common moments but those within two steps of an
/// event of the reference: where a force jumps, a coarse sample comes a step later, and finite
/// elements take one more to spring back.
struct ForceDifference {
  double rms_n = 0.0;
  double largest_n = 0.0;
};
ForceDifference Difference(const SampledRun& run, const SampledRun& reference, double step_ms);

/// Empty, or why the run must not be used: not finite, above `largest_n`, or nothing was felt.
std::string WhyUnusable(const SampledRun& run, double largest_n);

}  // namespace acus::benchmarks
