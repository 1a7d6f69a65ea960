// A sweep as one page that opens from disk.
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "acus/assess/tuning/sweep_result.h"
#include "acus/assess/tuning/tradeoff_plots.h"
#include "acus/base/core/run_context.h"

namespace acus::tuning {

/// What a page says beside the numbers.
struct PageContent {
  std::vector<std::string> answer;     ///< To the question that was asked; may be empty.
  std::vector<std::string> sentences;  ///< What each knob buys.
  std::vector<std::string> remarks;    ///< What was left out, and why.
  PlotRemarks plots;
};

/// Writes tradeoff.html into `folder`, with tables, plots, machine and provenance, and the plots of
/// all knobs together as force.svg, psnr.svg and ssim.svg, if there are such.
void WritePage(const std::filesystem::path& folder, const SweepResult& result,
               const PageContent& content, const RunContext& context);

}  // namespace acus::tuning
