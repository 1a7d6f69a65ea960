#pragma once

#include "acus/scene/effects/effect.h"

namespace acus::effects {

/// Fluid through the needle: docs/models/fluid.md.
const Effect& FluidThroughNeedle();

}  // namespace acus::effects
