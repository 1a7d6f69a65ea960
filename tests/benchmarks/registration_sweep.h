// What accuracy costs in finding a patient's breath in a 4D CT.
#pragma once

#include "acus/data/volume/volume.h"
#include "benchmarks/sweep.h"

namespace acus::benchmarks {

/// The body of the sweep "breathing" (breathing_body.h) as a CT scanner would see a part of it:
/// texture with structures of some 10 to 40 mm and noise of `noise_hu`; at rest, or at the end of
/// expiration.
/// @param seed_index  Of the noise: another one for each image.
volume::CtVolume BreathingBodyCt(double spacing_mm, bool expiration, double noise_hu,
                                 int seed_index);

/// The sweep "registration": end inspiration to end expiration, 20 mm, sliding along a wall. Errors
/// are against the exact motion. docs/accuracy-and-time.md.
Sweep RegistrationSweep();

}  // namespace acus::benchmarks
