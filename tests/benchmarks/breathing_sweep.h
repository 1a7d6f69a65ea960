// What accuracy costs in breathing: the field's resolution, iterations of the inverse, key frames,
// the model.
#pragma once

#include "benchmarks/sweep.h"

namespace acus::benchmarks {

/// The sweep "breathing": a body whose motion is known in closed form, as a 4D CT would show it,
/// through every motion model. Errors are against that motion, or against fifty iterations.
/// docs/accuracy-and-time.md.
Sweep BreathingSweep();

}  // namespace acus::benchmarks
