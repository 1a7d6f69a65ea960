// What accuracy costs in the fluid through a needle: step size and shells of the spread.
#pragma once

#include "benchmarks/sweep.h"

namespace acus::benchmarks {

/// The sweep "fluid": a loss of resistance, with saline and a bubble. Errors are against 32 shells
/// in steps of 0.02 ms. docs/models/fluid.md.
Sweep FluidSweep();

}  // namespace acus::benchmarks
