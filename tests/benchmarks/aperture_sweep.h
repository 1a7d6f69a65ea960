// What accuracy costs in images through a finite aperture: rays, planes, lines, samples, effects.
#pragma once

#include "benchmarks/sweep.h"

namespace acus::benchmarks {

/// The sweep "aperture": the scene of the sweep "image", rendered by the model `aperture`. Errors
/// are against its most expensive setting. docs/accuracy-and-time.md.
Sweep ApertureSweep();

}  // namespace acus::benchmarks
