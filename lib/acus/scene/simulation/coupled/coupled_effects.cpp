#include "acus/scene/simulation/coupled/coupled_effect.h"

namespace acus::simulation {

std::vector<const CoupledEffect*> CoupledEffects() {
  return {&coupled::Breathing(),   &coupled::Tools(),      &coupled::NeedleForce(),
          &coupled::NeedleShape(), &coupled::ProbeForce(), &coupled::Tissue(),
          &coupled::CtSlice(),     &coupled::BMode()};
}

}  // namespace acus::simulation
