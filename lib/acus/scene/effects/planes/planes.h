// Effect: slices and slabs of the CT through the needle's tip, in the window and as a video of a
// replay.
#pragma once

#include "acus/scene/effects/effect.h"

namespace acus::effects {

const Effect& Planes();

}  // namespace acus::effects
