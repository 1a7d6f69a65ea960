#include "acus/scene/simulation/coupled/coupled_effect.h"

namespace acus::simulation {

std::vector<const CoupledEffect*> CoupledEffects() {
  return {&coupled::Breathing(),   &coupled::Tools(),       &coupled::Tissue(),
          &coupled::NeedleForce(), &coupled::NeedleShape(), &coupled::ProbeForce(),
          &coupled::CtSlice(),     &coupled::BMode()};
}

}  // namespace acus::simulation
