#include "benchmarks/sweep.h"

#include "acus/base/core/error.h"
#include "benchmarks/aperture_sweep.h"
#include "benchmarks/breathing_sweep.h"
#include "benchmarks/fluid_sweep.h"
#include "benchmarks/forces_sweep.h"
#include "benchmarks/image_sweep.h"
#include "benchmarks/needle_sweep.h"
#include "benchmarks/probe_sweep.h"
#include "benchmarks/registration_sweep.h"
#include "benchmarks/strain_sweep.h"
#include "benchmarks/surfaces_sweep.h"
#include "benchmarks/tissue_sweep.h"
#include "benchmarks/views_sweep.h"

namespace acus::benchmarks {

const std::vector<Sweep>& Sweeps() {
  static const std::vector<Sweep> sweeps = {TissueSweep(),       StrainSweep(),   NeedleSweep(),
                                            ForcesSweep(),       ImageSweep(),    ApertureSweep(),
                                            BreathingSweep(),    ProbeSweep(),    ViewsSweep(),
                                            RegistrationSweep(), SurfacesSweep(), FluidSweep()};
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

}  // namespace acus::benchmarks
