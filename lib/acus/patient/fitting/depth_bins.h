// Recordings thinned to what a fit needs: means over steps of depth or of time.
#pragma once

#include <vector>

#include "acus/patient/fitting/curve_phases.h"

namespace acus::fitting {

/// Means over steps of depth, in order of depth; steps without a sample are omitted.
struct DepthBins {
  std::vector<double> depth_mm;
  std::vector<double> force_n;
  std::vector<double> count;  ///< Samples in the step.
};

/// @param step_mm  > 0; wider if there would be more than `most` steps.
DepthBins BinByDepth(const ForceCurve& curve, const SampleRange& range, double step_mm,
                     std::size_t most);

/// Every sample in `range`, joined to means over `step_s`.
ForceCurve Thinned(const ForceCurve& curve, const SampleRange& range, double step_s);

}  // namespace acus::fitting
