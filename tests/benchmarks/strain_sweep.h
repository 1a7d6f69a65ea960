// What accuracy costs in tissue at large strain: law, nodes of its region, iterations, elements.
#pragma once

#include "benchmarks/sweep.h"

namespace acus::benchmarks {

/// The sweep "strain": the insertion of the sweep "tissue", in 3D finite elements that stiffen near
/// the needle. Errors of forces, N, are against the most nodes and iterations.
/// docs/accuracy-and-time.md.
Sweep StrainSweep();

}  // namespace acus::benchmarks
