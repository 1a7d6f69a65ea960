// What accuracy costs in the images besides ultrasound: fluoroscopy and volume rendering.
#pragma once

#include "benchmarks/sweep.h"

namespace acus::benchmarks {

/// The sweep "views": a trunk with ribs and backbone, whose ray sums are known in closed form
/// (trunk_body.h). docs/accuracy-and-time.md.
Sweep ViewsSweep();

}  // namespace acus::benchmarks
