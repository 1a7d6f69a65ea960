// Where a needle pierces the layers of the tissue block, by the size of its elements.
#pragma once

#include <vector>

#include "benchmarks/tissue_block.h"

namespace acus::benchmarks {

struct Puncture {
  double depth_mm;  ///< Of the tip, below the skin at rest.
  double force_n;   ///< Of membrane and cutting.
};

/// Of the scripted insertion into condensed finite elements.
/// @param memory_mib  Most that condensing may take.
/// @throws InputError if it would take more.
std::vector<Puncture> PuncturesWith(double element_mm, const TissueBlockTables& tables,
                                    double memory_mib);

}  // namespace acus::benchmarks
