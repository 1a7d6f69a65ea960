// Forces of a step as rows of CSV: the same text from a replay and from a live session.
#pragma once

#include <string>

#include "acus/scene/simulation/scene.h"
#include "acus/scene/simulation/simulation.h"

namespace acus::replay {

/// Name of a label: in the scene's label map, or the standard one if there is none.
std::string TissueName(const simulation::Scene& scene, volume::Label label);

/// Headers of forces.csv and probe_forces.csv, without line ends.
std::string ForceHeader(const simulation::Scene& scene);
std::string ProbeForceHeader();

/// Header of an effect's file.
std::string EffectHeader(const simulation::ListedEffect& other);
void AppendEffectRow(std::string& text, const simulation::StepOutput& step,
                     const simulation::ListedEffect& other);

/// Appends one row with its line end. Forces are those on the needle; force_axial_n is + where it
/// pushes the needle out. @throws InputError if a number is not finite.
void AppendForceRow(std::string& text, const simulation::StepOutput& step,
                    const simulation::Scene& scene);
/// The force on the probe or the fingertip, in CT axes.
void AppendProbeForceRow(std::string& text, const simulation::StepOutput& step,
                         const simulation::Scene& scene);

}  // namespace acus::replay
