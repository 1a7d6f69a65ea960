// Pieces of what coupled effects declare.
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

/// True if the needle feels the deformed tissue.
bool IsFeltFromTissue(const scenario::Scenario& scenario);

/// Without a label map tissues are identified by the HU of the CT, as the table of needle_force
/// says.
bool AreTissuesByHu(const scenario::Scenario& scenario);

/// The same for springs that hold the needle, as the table of tissue says.
bool AreSpringsByHu(const scenario::Scenario& scenario);

/// True if the images show tissue elsewhere than the CT does.
bool ShowsDeformation(const scenario::Scenario& scenario);

/// True if an effect of the list writes the port at every sample.
bool IsWrittenByListed(const scenario::Scenario& scenario, effects::PortRef port);

/// True if an effect of the list moves tissue, whatever the tools do.
bool IsTissueMoved(const scenario::Scenario& scenario);

/// True if there is an image of the probe: B-mode or a CT slice.
bool HasProbeImage(const scenario::Scenario& scenario);

/// What moves the tissue under a tool.
void AddMotion(const scenario::Scenario& scenario, Ports& reads);

/// What an image of the probe reads besides the patient: the probe, the needle and the deformation
/// if they show.
Ports ImageInputs(const scenario::Scenario& scenario, bool needle, Ports patient);

}  // namespace acus::simulation::coupled
