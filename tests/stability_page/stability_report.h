// A run of the stability suite as a page, as JSON, and as a table for the documentation.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "acus/base/core/provenance.h"
#include "stability_page/stability_run.h"

namespace acus::stability_page {

/// "AMD EPYC 7B13, 2 cores, 8 GB, Debian GNU/Linux 12 (bookworm)", as far as the system tells.
std::string MachineText();

/// Self-contained page: what fails first, then module by module, with plots.
std::string StabilityPage(const StabilityRun& run, const Provenance& provenance);

/// `acus-stability/1`: everything that is on the page but the plots.
nlohmann::json StabilityJson(const StabilityRun& run, const Provenance& provenance);

/// Markdown for docs/stability.md: the table alone.
std::string StabilityTable(const StabilityRun& run, const Provenance& provenance);

/// Writes stability.html and stability.json into `folder`, each whole or not at all.
void WriteStability(const std::filesystem::path& folder, const StabilityRun& run,
                    const Provenance& provenance);

}  // namespace acus::stability_page
