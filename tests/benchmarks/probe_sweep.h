// What accuracy costs in the force on a probe or a finger: how many proxies on its surface.
#pragma once

#include "benchmarks/sweep.h"

namespace acus::benchmarks {

/// The sweep "probe": tools pressed into bodies whose force is known as an integral over the tool's
/// surface (pressed_tool.h). docs/accuracy-and-time.md.
Sweep ProbeSweep();

}  // namespace acus::benchmarks
