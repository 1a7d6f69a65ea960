// How fast a shaft slides and how long it rested: what friction by rate and by dwell depends on.
// Equations: docs/models/needle_forces.md, "Time".
#pragma once

#include "acus/physics/forces/laws/tissue_time.h"

namespace acus::forces {

/// A plain value, of a whole shaft.
struct FrictionPace {
  double ahead_mm = 0.0;        ///< Of the shaft before what counts as motion, within the play.
  double speed_mm_per_s = 0.0;  ///< Filtered.
  double age_s = 0.0;           ///< Of the contact: at rest it grows as time, sliding loses it.
};

/// Motion of a shaft in one step or piece of a step. Its speed is that of its travel: where tissue
/// that sticks yields, a speed of sliding would make friction chatter.
struct ShaftMove {
  double travel_mm = 0.0;
  double slid_mm = 0.0;  ///< In the tissue, which may stick and go along.
  double dt_s = 0.0;     ///< > 0.
};

/// Logarithms of speed and age against those of steady sliding at the reference speed.
struct PaceLogs {
  double rate = 0.0;
  double dwell = 0.0;
};

/// Takes a travel into the play of 5 um, within which there is neither speed nor sliding.
/// @return what is motion of it.
double MovedMm(FrictionPace& pace, double travel_mm) noexcept;

/// Pieces of at most 5 ms and a quarter of the slip, 64 at most, that a motion is to be cut into;
/// 1 at rest. @param dt_s  > 0.
int PiecesOf(const FrictionTime& settings, double moved_mm, double dt_s) noexcept;

/// Filters the speed and ages the contact over one piece. @return logarithms of its middle.
PaceLogs AdvancePace(FrictionPace& pace, const FrictionTime& settings,
                     const ShaftMove& move) noexcept;

/// The same over all pieces of a step, of which the play takes its part. @return logarithms of the
/// middle of the last one.
PaceLogs StepPace(FrictionPace& pace, const FrictionTime& settings, const ShaftMove& move) noexcept;

/// g: by how much more than in steady sliding at the reference speed friction can hold.
double FrictionShare(const TissueTime& time, const PaceLogs& logs) noexcept;

/// A bristle's strain after one piece: ds/dt = v / b - s / tau, held in [-limit, limit] by sliding.
/// A strain beyond a limit that has fallen is taken off over a travel of b.
/// @param strained  travel over b.  @param decay  duration over tau; 0: it does not relax.
double StrainAfter(double strain, double strained, double decay, double limit) noexcept;

}  // namespace acus::forces
