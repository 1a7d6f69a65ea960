// How fast this machine is just now, so that times can be compared with those of another.
#pragma once

namespace acus::regression {

/// CPU time of a fixed piece of work like that of a replay: interpolation at scattered places of a
/// volume, and arithmetic on small matrices. The smallest of three goes, so that what a neighbour
/// on the machine does counts little. About 0.1 s in all.
double CalibrationSeconds();

}  // namespace acus::regression
