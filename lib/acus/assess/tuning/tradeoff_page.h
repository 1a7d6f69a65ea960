// A sweep as one HTML page that opens from disk.
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "acus/assess/tuning/sweep_result.h"
#include "acus/assess/tuning/tradeoff_plots.h"
#include "acus/base/core/run_context.h"

namespace acus::tuning {

/// The texts of a page beside the numbers.
struct PageContent {
  std::vector<std::string> answer;   ///< Answer to the request; may be empty.
  std::vector<std::string> remarks;  ///< Omitted values, and the reasons.
  PlotRemarks plots;
};

/// Writes tradeoff.html into `folder`: savings and losses of settings (savings.svg as well), then
/// tables, plots, machine and provenance. Where all settings have one reference, their plots are
/// also in force.svg, psnr.svg and ssim.svg.
void WritePage(const std::filesystem::path& folder, const SweepResult& result,
               const PageContent& content, const RunContext& context);

}  // namespace acus::tuning
