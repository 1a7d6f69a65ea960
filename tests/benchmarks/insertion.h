// One scripted insertion, the same for every tissue model, with its time and its sanity.
#pragma once

#include <Eigen/Dense>
#include <algorithm>
#include <string>
#include <vector>

#include "acus/base/core/cpu_time.h"
#include "acus/physics/forces/models/needle_force.h"
#include "acus/physics/tissue/tool_sample.h"

namespace acus::benchmarks {

/// At 1 kHz: from 3 mm above the skin 50 mm into the block at 20 mm/s, 4 degrees askew; there aside
/// by 1 mm and back; out again at 40 mm/s until it is 3 mm above the skin.
std::vector<tissue::ToolSample> ScriptedInsertion();

/// Of all samples.
struct InsertionRun {
  std::vector<Eigen::Vector3d> force_n;  ///< On the needle, CT axes.
  std::vector<double> step_us;           ///< CPU time of each step.
};

/// Steps `model` through all samples.
template <typename Model>
InsertionRun Insert(const Model& model, const std::vector<tissue::ToolSample>& samples) {
  InsertionRun out;
  out.force_n.reserve(samples.size());
  out.step_us.reserve(samples.size());
  auto state = model.NewState();
  for (const tissue::ToolSample& sample : samples) {
    const double before_s = ThreadCpuSeconds();
    const forces::NeedleForce force = model.Step(state, sample);
    out.step_us.push_back(1e6 * (ThreadCpuSeconds() - before_s));
    out.force_n.push_back(force.force_in_ct_n);
  }
  return out;
}

/// Root mean square over the samples of the length of the difference of forces, N. @pre same
/// length.
double RmsDifferenceN(const InsertionRun& a, const InsertionRun& b);

/// Empty if forces are finite and within `largest_n`, end at zero, are above noise at all, and if
/// the needle has put work into the tissue over the whole round: what it gets back is less than it
/// gave. Otherwise what is wrong.
std::string WhyUnusable(const InsertionRun& run, const std::vector<tissue::ToolSample>& samples,
                        double largest_n);

}  // namespace acus::benchmarks
