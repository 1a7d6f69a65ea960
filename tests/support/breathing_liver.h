// The synthetic liver patient of acus-phantom, breathing by its known motion: what the figures of
// Fortmeier-2016 are repeated on, since no 4D CT is at hand.
#pragma once

#include <filesystem>

#include "acus/data/volume/volume_io.h"
#include "acus/patient/phantom/breathing_folder.h"
#include "acus/patient/phantom/breathing_scan.h"
#include "acus/physics/breathing/model_building.h"

namespace acus::testing_support {

struct BreathingLiver {
  static constexpr int kPhases = 10;
  static constexpr int kNodes = 64;

  volume::CtVolume ct;
  volume::LabelMap labels;
  phantom::BreathingFolderSettings settings;
  breathing::MotionPhases phases;  ///< The reference is end expiration.

  /// @param folder  Of `acus-phantom patient liver`.
  BreathingLiver(const std::filesystem::path& folder, const phantom::BreathingSettings& motion)
      : ct(volume::ReadCt(folder / "ct.nrrd", "", {})),
        labels(volume::ReadTissues(folder / "labels.seg.nrrd")) {
    settings.motion = motion;
    settings.num_phases = kPhases;
    const phantom::BreathingMotion exact(phantom::FindCavity(labels, {}), motion);
    phases.nodes = breathing::NodesOver(ct.geometry, kNodes);
    for (int n = 0; n < kPhases; ++n) {
      const breathing::Breath breath = phantom::BreathOfPhase(n, settings);
      phases.phases.push_back({.breath = breath, .displacement_in_ct_mm = {}});
      if (breath.level < 1e-9 && std::abs(breath.level_per_s) < 1e-9) continue;
      phases.phases.back().displacement_in_ct_mm =
          phantom::DisplacementsOn(phases.nodes, exact, breath, 2);
    }
  }

  breathing::MotionModel Model(breathing::MotionKind kind) const {
    return breathing::BuildModel(kind, phases);
  }
  /// Breath a share of the way through the cycle; depth 1.4 is deeper than any phase.
  breathing::Breath BreathAt(double cycle, double depth = 1.0) const {
    const double angle = 2.0 * M_PI * cycle;
    return {.cycle = cycle,
            .level = depth * (0.5 + 0.5 * std::cos(angle)),
            .level_per_s = -depth * M_PI / settings.motion.period_s * std::sin(angle)};
  }
};

}  // namespace acus::testing_support
