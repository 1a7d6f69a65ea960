#include "tradeoff/sweep.h"

#include "core/error.h"
#include "tradeoff/breathing_sweep.h"
#include "tradeoff/forces_sweep.h"
#include "tradeoff/image_sweep.h"
#include "tradeoff/needle_sweep.h"
#include "tradeoff/probe_sweep.h"
#include "tradeoff/registration_sweep.h"
#include "tradeoff/tissue_sweep.h"
#include "tradeoff/views_sweep.h"

namespace acus::tradeoff {

const std::vector<Sweep>& Sweeps() {
  static const std::vector<Sweep> sweeps = {TissueSweep(), NeedleSweep(),      ForcesSweep(),
                                            ImageSweep(),  BreathingSweep(),   ProbeSweep(),
                                            ViewsSweep(),  RegistrationSweep()};
  return sweeps;
}

const Sweep& SweepNamed(std::string_view name) {
  std::string names;
  for (const Sweep& sweep : Sweeps()) {
    if (sweep.name == name) return sweep;
    names += (names.empty() ? "" : ", ") + std::string(sweep.name);
  }
  throw InputError(Message("there is no sweep '", name, "'; there are: ", names));
}

}  // namespace acus::tradeoff
