// The folder that `acus-phantom warp` writes: a 4D CT whose motion is known exactly.
#pragma once

#include <filesystem>
#include <string>

#include "acus/base/core/run_context.h"
#include "acus/patient/phantom/breath/breathing_scan.h"

namespace acus::phantom {

struct BreathingFolderSettings {
  BreathingSettings motion;
  int num_phases = 10;
  double noise_sd_hu = 10.0;
  double deeper_level = 1.4;  ///< Of one more scan, beyond normal breath.
  double signal_s = 60.0;     ///< Length of the surrogate.
  double truth_spacing_mm = 4.0;
  int num_landmarks = 300;
};

/// Breath at phase n of num_phases: 0 is end inspiration, num_phases / 2 end expiration.
breathing::Breath BreathOfPhase(int n, const BreathingFolderSettings& settings);

/// Writes phase_00.nrrd ... and deeper.nrrd, phases.csv (file, use, cycle, level, level_per_s),
/// signal.csv (time_s, level), landmarks.csv (name, tissue, wall_mm, file, x_mm, y_mm, z_mm),
/// truth/ with the displacement fields from end expiration, cavity.seg.nrrd, motion_truth.json and
/// provenance.json into a new folder, whole or not at all.
/// @param ct      At end expiration; `labels` are its tissues.
/// @throws InputError if the labels lie on another grid, or hold no cavity.
void WriteBreathingPatient(const std::filesystem::path& folder, const volume::CtVolume& ct,
                           const volume::LabelMap& labels, const BreathingFolderSettings& settings,
                           const RunContext& context);

/// What such a folder holds, for people.
std::string BreathingFolderText(const BreathingFolderSettings& settings);

}  // namespace acus::phantom
