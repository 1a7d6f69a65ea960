// Every force model in the same block of tissue, ready to be stepped at any rate.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "acus/base/core/run_context.h"
#include "benchmarks/sampled_run.h"

namespace acus::benchmarks {

/// A force model with its constants in TissueBlock. The tables are those that are shipped for it.
struct ForceModelCase {
  std::string name;  ///< "layered", "alamilla", "vidal", "springs", "fe_3d", "bendable needle".
  std::string full_name;  ///< For the report.
  /// Steps a fresh needle through the samples.
  std::function<SampledRun(const std::vector<tissue::ToolSample>&)> run;
  /// A fresh needle: each call takes it to its next sample. It must not outlive this.
  std::function<std::function<forces::NeedleForce(const tissue::ToolSample&)>()> begin;
  double largest_n = 0.0;      ///< Bound that its forces keep.
  double preparation_s = 0.0;  ///< CPU time.
  double memory_mb = 0.0;      ///< What steps read: compliance, or model and state.
};

struct ForceModelOptions {
  double element_mm = 4.0;  ///< Of fe_3d.
  int num_nodes = 25;       ///< Of the bendable needle.
};

/// All of them. "bendable needle" is the layered model along the needle with the elastic rod across
/// it: its hub in springs of the hand, its shaft in the tissue's.
/// @throws InputError if a preset is not there; Cancelled.
std::vector<ForceModelCase> ForceModelCases(const ForceModelOptions& options,
                                            const RunContext& context);

}  // namespace acus::benchmarks
