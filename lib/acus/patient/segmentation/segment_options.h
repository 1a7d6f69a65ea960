// The options of acus-segment.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "acus/base/core/run_context.h"
#include "acus/patient/segmentation/import/lay_imports.h"
#include "acus/patient/segmentation/patient_segmentation.h"

namespace CLI {
class App;
}

namespace acus::segmentation {

struct SegmentOptions {
  std::filesystem::path ct, config, reference, folder;
  std::vector<std::filesystem::path> imports, mappings, atlases;
  std::string series, vertebra;
  bool list_series = false, certainty = false, accept_implausible = false, vessels = false;

  /// The file of settings: that of --config, or the preset.
  std::filesystem::path ConfigPath() const;
  /// @throws InputError if --vertebra is not understood.
  Examination ToExamine() const;
  /// The label maps of --import with what --mapping says of them; they become inputs of the run.
  ImportOptions ToImport(RunContext& context) const;
  /// That of --compare, likewise. @pre !reference.empty()
  ForeignLabels Reference(RunContext& context) const;
};

/// Adds the options to the program; they write into the result, which must outlive its parsing.
void AddSegmentOptions(CLI::App& app, SegmentOptions& options);

}  // namespace acus::segmentation
