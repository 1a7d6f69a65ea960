// Which setting is enough for an accuracy, from the rows of a sweep.
#pragma once

#include <string>
#include <vector>

#include "benchmarks/sweep.h"

namespace acus::benchmarks {

/// One sentence for each knob that has errors in N: the cheapest of its settings that is at most
/// `limit_n` off what it was held against, with what it costs; or that none is, and the nearest.
/// The setting that the others are held against has no error of its own, and is not the answer.
/// Cheapest: the least CPU time for preparation and ten seconds of steps at 1 kHz.
std::string EnoughText(const std::vector<Row>& rows, double limit_n);

}  // namespace acus::benchmarks
