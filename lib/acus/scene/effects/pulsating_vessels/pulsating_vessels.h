// Effect: arteries that pulsate. They move needle and probe, and show in all images.
#pragma once

#include "acus/scene/effects/effect.h"

namespace acus::effects {

const Effect& PulsatingVessels();

}  // namespace acus::effects
