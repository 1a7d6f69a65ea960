// What accuracy costs in the image: lines, samples, planes, point spread, warp, and the models.
#pragma once

#include "benchmarks/sweep.h"

namespace acus::benchmarks {

/// The sweep "image": a labelled block with a lesion, a vessel and a rib, pressed in around a
/// needle. Errors are against the most expensive setting of the beams. docs/accuracy-and-time.md.
Sweep ImageSweep();

}  // namespace acus::benchmarks
