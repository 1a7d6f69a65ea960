// Effect: arteries that pulsate. Needle and probe feel it, and all images show it.
#pragma once

#include "acus/scene/effects/effect.h"

namespace acus::effects {

const Effect& PulsatingVessels();

}  // namespace acus::effects
