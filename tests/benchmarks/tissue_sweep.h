// What accuracy costs in tissue: element size and kind, corridor, storage, spacing of contacts,
// model.
#pragma once

#include "benchmarks/sweep.h"

namespace acus::benchmarks {

/// The sweep "tissue": one scripted insertion into a block of skin, fat, muscle and liver
/// (tissue_block.h). Errors of forces are against the finest elements, those of displacements
/// against Love's closed solution. docs/accuracy-and-time.md.
Sweep TissueSweep();

}  // namespace acus::benchmarks
