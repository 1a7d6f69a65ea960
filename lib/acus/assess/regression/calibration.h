// The current speed of this machine, for comparisons of times with those of another.
#pragma once

namespace acus::regression {

/// CPU time of a fixed task like that of a replay: interpolation at scattered points of a volume,
/// and arithmetic on small matrices. The smallest of three trials, so that other load on the
/// machine has little influence. Approximately 0.1 s in total.
double CalibrationSeconds();

}  // namespace acus::regression
