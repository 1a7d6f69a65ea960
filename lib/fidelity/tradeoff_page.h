// A sweep as one page that opens from disk.
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "core/run_context.h"
#include "fidelity/sweep_result.h"
#include "fidelity/tradeoff_plots.h"

namespace acus::fidelity {

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

}  // namespace acus::fidelity
