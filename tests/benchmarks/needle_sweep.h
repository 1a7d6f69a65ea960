// What accuracy costs in the bendable needle: nodes, tolerance, step size,
// iterations.
#pragma once

#include "benchmarks/sweep.h"

namespace acus::benchmarks {

/// The sweep "needle": a 16-gauge needle driven in and out of tissue by a hand
/// that strays and leans, and a cantilever. Errors are against 401 nodes solved
/// to the last digits, and against the elastica. docs/models/needle_rod.md.
Sweep NeedleSweep();

}  // namespace acus::benchmarks
