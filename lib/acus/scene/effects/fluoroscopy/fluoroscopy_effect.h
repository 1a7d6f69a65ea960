// Effect: the X-ray images of a C-arm. They show the CT and the needle.
#pragma once

#include "acus/scene/effects/effect.h"

namespace acus::effects {

const Effect& Fluoroscopy();

}  // namespace acus::effects
