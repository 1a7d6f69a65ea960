// Measures of the smoothness of a movement, from its speed.
#pragma once

#include <span>
#include <vector>

#include "acus/data/session/session.h"

namespace acus::training {

struct SmoothnessOptions {
  double cutoff_hz = 10.0;  ///< Highest frequency that is used. > 0
  double amplitude = 0.05;  ///< Amplitude relative to that at frequency 0: the last frequency above
                            ///< it ends the spectrum. In (0, 1).
  int padding_levels = 4;   ///< The speed is padded with zeros to 2^(levels + ceil(log2 n)).
};

/// Spectral arc length of a speed profile (Balasubramanian et al. 2015, eq. 1 and 2): minus the
/// length of the curve of the normalised amplitude spectrum over the normalised frequency.
/// Approximately -1.4 for one smooth movement; more negative with more jerks and stops. Independent
/// of the movement's size. 0 if the speed is zero throughout. Cost O(n log n); allocates.
/// @pre at least two values, rate_hz > 0.
double SpectralArcLength(std::span<const double> speed, double rate_hz,
                         const SmoothnessOptions& options = {});

/// Logarithm of the dimensionless jerk of a speed profile, negative: -ln(T^3 / v_max^2 x the
/// integral of (d2v/dt2)^2) (Balasubramanian et al. 2015, eq. 6). Closer to 0 is smoother. 0 if the
/// speed is linear in time. @pre at least three values, rate_hz > 0.
double LogDimensionlessJerk(std::span<const double> speed, double rate_hz);

/// Speed of a tool's origin [mm/s] at equal steps of time, from poses resampled at `rate_hz` and
/// the differences over one step; invalid samples are bridged. Empty for fewer than three steps.
std::vector<double> SpeedProfile(const session::PoseStream& stream, std::int64_t from_ns,
                                 std::int64_t to_ns, double rate_hz);

}  // namespace acus::training
