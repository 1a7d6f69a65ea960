// What the renderers in beam space accept: volumes, tables and probes.
#pragma once

#include "acus/imaging/acoustics/probe.h"
#include "acus/imaging/ultrasound/beams/beam_options.h"

namespace acus::ultrasound {

/// @param model  Named in messages.
/// @throws InputError if volumes are missing, empty, too large or do not fit each other, or the
///     table is missing.
const BeamTissue& CheckedBeamTissue(const BeamTissue& tissue, const char* model);

/// @throws InputError naming the first size of the probe that is out of range.
const acoustics::Probe& CheckedBeamProbe(const acoustics::Probe& probe);

}  // namespace acus::ultrasound
