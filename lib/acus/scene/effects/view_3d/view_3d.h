// Effect: the patient in three dimensions, with the tools. A video in replays.
#pragma once

#include "acus/scene/effects/effect.h"

namespace acus::effects {

const Effect& View3d();

}  // namespace acus::effects
