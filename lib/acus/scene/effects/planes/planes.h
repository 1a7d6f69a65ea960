// Effect: slices and slabs of the CT through the needle's tip. Shown live, and a film in replays.
#pragma once

#include "acus/scene/effects/effect.h"

namespace acus::effects {

const Effect& Planes();

}  // namespace acus::effects
