// What accuracy costs in forces: step size, the integration of friction, the model.
#pragma once

#include "benchmarks/sweep.h"

namespace acus::benchmarks {

/// The sweep "forces": LuGre friction by four methods against its own law, and every force model at
/// steps of 0.1 to 10 ms against itself at 1/16 ms. docs/accuracy-and-time.md.
Sweep ForcesSweep();

}  // namespace acus::benchmarks
