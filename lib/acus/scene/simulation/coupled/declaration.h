// Functions that the declarations of coupled effects share.
#pragma once

#include <string>
#include <vector>

#include "acus/scene/effects/ports.h"
#include "acus/scene/simulation/declared_stages.h"

namespace acus::simulation::coupled {

namespace ports = effects::ports;
using Ports = std::vector<effects::PortRef>;

void Add(Ports& reads, const Ports& more);

PlannedStage StepStage(std::string_view name, Ports reads, Ports writes);
PlannedStage ImageStage(std::string_view name, Ports reads, Ports writes);

/// A file that the scenario names.
DeclaredInput File(effects::PortRef port, const std::filesystem::path& file,
                   const std::string& where);

/// True if the deformed tissue gives the force on the needle.
bool IsFeltFromTissue(const scenario::Scenario& scenario);

/// True if tissues are identified by the HU of the CT, with the table of needle_force, as there is
/// no label map.
bool AreTissuesByHu(const scenario::Scenario& scenario);

/// The same for springs that hold the needle, with the table of tissue.
bool AreSpringsByHu(const scenario::Scenario& scenario);

/// True if the images show tissue elsewhere than the CT does.
bool ShowsDeformation(const scenario::Scenario& scenario);

/// True if an effect of the list writes the port at every sample.
bool IsWrittenByListed(const scenario::Scenario& scenario, effects::PortRef port);

/// True if an effect of the list moves tissue, independently of the tools.
bool IsTissueMoved(const scenario::Scenario& scenario);

/// True if there is an image of the probe: B-mode or a CT slice.
bool HasProbeImage(const scenario::Scenario& scenario);

/// Adds the ports that move the tissue under a tool.
void AddMotion(const scenario::Scenario& scenario, Ports& reads);

/// The inputs of an image of the probe besides the patient: the probe, and the needle and the
/// deformation if the image shows them.
Ports ImageInputs(const scenario::Scenario& scenario, bool needle, Ports patient);

}  // namespace acus::simulation::coupled
