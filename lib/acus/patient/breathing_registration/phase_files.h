// The phases of a 4D CT on disk, or displacement fields in their place.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "acus/base/core/run_context.h"
#include "acus/data/volume/volume.h"
#include "acus/physics/breathing/breath.h"
#include "acus/physics/breathing/recorded_breath.h"

namespace acus::breathing_registration {

/// One phase: where its image is, and the breath it was taken at.
struct PhaseFile {
  std::string name;  ///< For people: the file's name, or "phase 3".
  std::filesystem::path path;
  std::string series;  ///< Of a DICOM folder.
  breathing::Breath breath;
};

struct PhaseFiles {
  std::vector<PhaseFile> phases;    ///< In the order of the breath, from end inspiration.
  std::optional<PhaseFile> deeper;  ///< A scan beyond normal breath, to judge models by.
  std::string omitted;              ///< What else is there, such as a CT for planning.
};

/// Finds the phases in a folder:
///  - as phases.csv says, if there is one (file, cycle, level, level_per_s; use: phase or deeper);
///  - otherwise all volumes (NIfTI, NRRD, MetaImage) in the order of the numbers in their names;
///    a single NIfTI file, here or in place of the folder, holds all phases in their order;
///  - otherwise folders or series of DICOM in the order of their temporal position or description.
///    Where four or more state a percentage or number of a phase, series without one are omitted.
/// Without phases.csv the phases are taken to be evenly spread over one breath from end
/// inspiration; their levels and rates are the means of the recorded breaths there, or of a regular
/// breath.
/// @throws InputError if there are fewer than four phases, one is missing from the row of numbers
/// or
///     has none, or two have the same place in the breath.
PhaseFiles FindPhases(const std::filesystem::path& folder,
                      const std::optional<breathing::BreathSignal>& signal);

/// Reads the image of a phase. @throws InputError as ReadCt.
volume::CtVolume ReadPhase(const PhaseFile& phase, const RunContext& context);

}  // namespace acus::breathing_registration
