// Labelled images of many patients, split by patient: docs/reference/formats_labelled.md.
#pragma once

#include <filesystem>
#include <string>

#include "acus/assess/dataset/dataset_config.h"
#include "acus/base/core/run_context.h"
#include "acus/run/replay/label_format.h"

namespace acus::dataset {

/// The plan for the config and the seed, as text: a line for each split and each sequence.
std::string PlanText(const DatasetConfig& config, std::uint64_t seed);

/// Makes all sequences, several at a time, and writes the folder, whole or not at all. The same
/// config, seed and patients give the same bytes with any number of threads, except for
/// provenance.json, which has the command line.
/// @returns a few lines for the terminal.
/// @throws InputError if a patient, scenario or preset is not usable.
std::string WriteDataset(const DatasetConfig& config, replay::LabelFormat format,
                         const std::filesystem::path& folder, RunContext& context);

}  // namespace acus::dataset
