// The mechanical model of a whole recording, by the names that the fits use: one law, fitted here
// and felt in the simulation.
#pragma once

#include "acus/physics/forces/models/mechanical_model.h"

namespace acus::fitting {

using forces::ContactStrain;
using forces::InternalPuncture;
using forces::MechanicalModel;
using forces::MechanicalState;
using forces::Release;
using forces::Replay;
using forces::ResistanceProfile;
using forces::Slip;

}  // namespace acus::fitting
