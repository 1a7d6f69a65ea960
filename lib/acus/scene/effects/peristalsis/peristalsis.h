// Effect peristalsis: bowel whose wall contracts in waves that travel along it.
#pragma once

#include "acus/scene/effects/effect.h"

namespace acus::effects {

const Effect& Peristalsis();

}  // namespace acus::effects
