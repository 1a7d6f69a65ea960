// Force-depth recordings of needle insertions: reading, writing, and curves with known parameters.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace acus::forces {

/// One recording. Time increases strictly; depth is that of the drive along the needle, + into the
/// tissue; force is what the drive feels, + pushes the needle out. All three have the same length.
struct ForceCurve {
  std::string name;
  std::vector<double> time_s;
  std::vector<double> depth_mm;
  std::vector<double> force_n;
  std::vector<double> hu;                  ///< Of the CT at the tip; empty if not known.
  std::vector<double> hu_gradient_per_mm;  ///< Magnitude of the CT's gradient there; or empty.
  std::string how_read;  ///< What was taken from a file in another form than the plain one.

  std::size_t size() const { return time_s.size(); }
};

/// Which column of a machine's export holds what.
struct ForceColumn {
  std::string column;  ///< Its name or number from 1; empty: found by its name.
  std::string unit;    ///< In lower case; empty: as the file says.
  double sign = 1.0;   ///< -1: the file counts the other way.
};
struct ForceColumns {
  ForceColumn time, depth, force;
};

/// Reads either
///  - a CSV with columns time_s, depth_mm, force_n, and hu and hu_gradient_per_mm if there are. All
///    forms of tables and units that CsvTable reads; "load", "displacement", "extension" and the
///    like are found by their names, or all by a mapping; or
///  - a folder with the headerless time_displacement.csv (s, mm) and time_force.csv (s, N). Their
///    clocks may differ: the depth is interpolated linearly at the times of the force, and force
///    samples outside the depth's time span are omitted.
/// The name is the file's stem or the folder's name. Rows with an empty cell are omitted; samples
/// of one stamp (a coarse clock) are averaged; both are counted in how_read.
/// @throws InputError with file:row if a value is not finite or beyond 2 m or 1 kN, time goes
///     back, or fewer than 20 samples are left; and if the depth looks like
///     metres: all of it within 1 mm over more than 2 s, with forces that differ by 0.05 N or more;
///     and if the largest force is above 100 N, unless `as_it_is`.
ForceCurve ReadForceCurve(const std::filesystem::path& path, const ForceColumns& columns = {},
                          bool as_it_is = false);

/// Writes the CSV form, whole or not at all.
void WriteForceCurve(const std::filesystem::path& path, const ForceCurve& curve);

/// What an insertion with one puncture looks like (docs/models/force_fit.md). With x the depth
/// since contact:
///   before contact   0
///   pre-puncture     a1 x + a2 x^2                     (Alamilla-2021 eq. 2)
///   plateau          plateau + slope (x - puncture)    (Vidal-2008 fig. 5)
///   hold             F_end (1 - r (1 - exp(-t / tau)))
///   retraction       -friction x, reached from the hold's force over `reversal_mm`
/// and everything plus `offset_n`, the sensor's zero error.
struct CurveParameters {
  double contact_depth_mm = 5.0;    ///< Drive depth at which the tip touches.
  double a1_n_per_mm = 0.048;       ///< Alamilla-2021 after eq. 2.
  double a2_n_per_mm2 = 0.0052;     ///< Alamilla-2021 after eq. 2.
  double puncture_depth_mm = 12.0;  ///< Since contact.
  double plateau_n = 0.6;           ///< Just after the puncture.
  double plateau_slope_n_per_mm = 0.012;
  double friction_n_per_mm = 0.015;  ///< Per mm of buried shaft, on retraction.
  double relaxation_fraction = 0.4;  ///< Of the force, lost during a long hold; in [0, 1].
  double relaxation_time_s = 2.0;
  double reversal_mm = 0.5;  ///< Travel over which the sign of the force turns.
  double offset_n = 0.0;

  /// Force while advancing, without offset. @param depth_mm  of the drive.
  double AdvanceForceN(double depth_mm) const;
  /// Force at the puncture, just before the drop, without offset.
  double PunctureForceN() const;
};

/// How the drive moves: rest, in at constant speed, hold, out to depth 0, rest.
struct DrivePlan {
  double rate_hz = 1000.0;
  double rest_s = 1.0;
  double advance_mm_per_s = 5.0;
  double end_depth_mm = 60.0;
  double hold_s = 10.0;
  double retract_mm_per_s = 5.0;
};

/// A recording of `truth` with white noise of standard deviation `noise_n`. The same arguments give
/// the same bits; another `seed` gives other noise.
/// @throws InputError if a parameter makes no sense (a negative rate, a puncture past the end...).
ForceCurve SynthesizeForceCurve(const CurveParameters& truth, const DrivePlan& plan, double noise_n,
                                std::uint64_t seed, const std::string& name);

}  // namespace acus::forces
