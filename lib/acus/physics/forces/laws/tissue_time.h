// What the force of a tissue remembers of time: relaxation in a hold, friction by rate and rest.
// Equations: docs/models/needle_forces.md, "Time".
#pragma once

#include <array>

namespace acus::forces {

/// Shares of an elastic force that fade while nothing moves, each with its time: a Prony series.
struct ForceRelaxation {
  static constexpr int kMostTerms = 3;
  std::array<double, kMostTerms> share{};                ///< >= 0, below 1 together.
  std::array<double, kMostTerms> time_s{1.0, 1.0, 1.0};  ///< > 0.
  int num_terms = 0;                                     ///< 0: the force of a hold stays.

  double ElasticShare() const noexcept;
  bool operator==(const ForceRelaxation&) const = default;
};

/// Dependence on time of one tissue. All zero: its force does not depend on time.
struct TissueTime {
  ForceRelaxation relaxation;
  double friction_rate = 0.0;  ///< Share by which friction grows with each factor e of speed, >= 0.
  double friction_dwell = 0.0;  ///< The same with each factor e of rest, >= 0.

  bool operator==(const TissueTime&) const = default;
};

/// What speed and rest are compared with, for all tissues of a table.
struct FrictionTime {
  double reference_mm_per_s = 5.0;  ///< Friction of the rows is that of steady sliding at it; > 0.
  double least_mm_per_s = 0.1;      ///< Below it friction no longer depends on speed, > 0.
  double least_dwell_s = 1.0;       ///< Shorter rests change nothing, > 0.
  double slip_mm = 1.0;             ///< Sliding in which a rest is forgotten, to 1/e; > 0.

  /// ln((v + least) / (reference + least)). @param speed_mm_per_s  of either sign.
  double RateLog(double speed_mm_per_s) const noexcept;
  /// The same of the contact's age against that of steady sliding at the reference speed.
  double DwellLog(double age_s) const noexcept;
};

/// The tip from one place on its path to the next, at constant speed.
struct TipMove {
  double from_mm = 0.0;
  double to_mm = 0.0;
  double dt_s = 0.0;  ///< > 0.
};

/// A spring and a dashpot in series ahead of the tip, which can only push (a Maxwell branch of the
/// contact). While it pushes, its rest creeps after the tip; off the tip it returns to `home_mm`.
/// Exact for constant speed; where it returns to a tip that comes back, to second order in dt/time.
/// @param rest_mm  where the spring was at rest, >= home_mm.  @return where it is now.
double CreptMm(double rest_mm, const TipMove& move, double home_mm, double time_s) noexcept;

}  // namespace acus::forces
