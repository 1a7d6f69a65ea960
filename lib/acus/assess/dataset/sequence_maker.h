// One sequence of a data set: a virtual trainee's insertion, its images and their ground truth.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "acus/assess/dataset/sequence_plan.h"
#include "acus/base/core/run_context.h"
#include "acus/run/replay/frame_table.h"
#include "acus/run/replay/label_format.h"

namespace acus::dataset {

/// The manifest's data of a sequence.
struct MadeSequence {
  nlohmann::json entry;    ///< Its row in manifest.json.
  nlohmann::json classes;  ///< Values of its label images.
  replay::FrameTable table;
  std::map<std::string, std::string> files;         ///< As replay::ImageStack::Files.
  std::map<std::string, std::string> input_sha256;  ///< Hashes of the inputs, for provenance.
  std::vector<std::string> warnings;
};

/// Simulates and writes a sequence into `folder`, which is created; the bytes depend on its
/// arguments and the files that they name only. @param split  Split of the patient.
/// @throws InputError if the scenario has no ultrasound, or as trials::SimulateTrial's patient.
MadeSequence MakeSequence(const DatasetConfig& config, const SequencePlan& plan,
                          const std::string& split, replay::LabelFormat format,
                          const std::filesystem::path& folder, const RunContext& context);

}  // namespace acus::dataset
