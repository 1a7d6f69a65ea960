// Effect pain_reaction: the patient jerks away when the needle hurts.
#pragma once

#include "acus/scene/effects/effect.h"

namespace acus::effects {

const Effect& PainReaction();

}  // namespace acus::effects
