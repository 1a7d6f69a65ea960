// The axial force on a needle from how it moved: resistance by depth, elastic build-up, relaxation,
// internal punctures. What a recording is fitted with and replayed through, and the law of
// MeasuredModel. Equations: docs/models/force_fit.md.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace acus::forces {

/// Resistance against sliding, a magnitude, linear between knots of the drive's depth and beyond
/// the ends as in the last interval; not below 0.
struct ResistanceProfile {
  std::vector<double> depth_mm;  ///< Increasing, at least two.
  std::vector<double> force_n;   ///< As many.

  double ForceN(double depth_mm) const noexcept;
};

/// A membrane or vessel wall inside the tissue, met while advancing: with x = depth - contact,
///   a1 x + a2 x^2                                   up to the puncture (Alamilla-2021 eq. 2)
///   step + (peak - step) exp(-(x - x_p) / recovery)  after it
/// added to the resistance. `step` is the change of resistance that stays.
struct InternalPuncture {
  double contact_mm = 0.0;    ///< Drive depth.
  double puncture_mm = 1.0;   ///< Since contact, x_p > 0.
  double a1_n_per_mm = 0.0;   ///< >= 0.
  double a2_n_per_mm2 = 0.0;  ///< >= 0.
  double recovery_mm = 0.5;   ///< Travel in which the tissue springs back, > 0.
  double step_n = 0.0;

  double PeakN() const noexcept { return (a1_n_per_mm + a2_n_per_mm2 * puncture_mm) * puncture_mm; }
  double ForceN(double depth_mm) const noexcept;
};

/// During withdrawal the resistance changes by `step_n` where the tip leaves what had gripped it:
/// step / (1 + exp((at - depth) / width)), more resistance deeper than `at`.
struct Release {
  double at_mm = 0.0;  ///< Drive depth.
  double width_mm = 0.2;
  double step_n = 0.0;

  double ForceN(double depth_mm) const noexcept;
};

/// Tissue that yields by itself while the needle rests: after resting for `after_s` the strain
/// falls by `share` of itself.
struct Slip {
  double after_s = 0.0;
  double share = 0.0;  ///< In [0, 1]: a slip takes energy from the contact, never gives any.
};

/// How far the contact is strained, 1 or -1 when it slides steadily at the reference speed: what
/// resists going in, and what resists going out.
struct ContactStrain {
  double in = 0.0;   ///< >= 0; times the resistance in.
  double out = 0.0;  ///< <= 0; times the resistance out.

  double Sum() const noexcept { return in + out; }
};

/// F = offset + drift t + S_in R_in(depth) + S_out R_out(depth). The contact is an elastic and up
/// to three Maxwell branches side by side, each with
///   ds/dt = v / b - (|v| / b + 1 / tau) s
/// (Dahl; LuGre without its velocity terms, Alamilla-2021 eq. 4; tau is infinite in the elastic
/// branch). A branch with s > 0 has the build-up travel and the resistance of the insertion, one
/// with s < 0 those of the withdrawal: both springs are at rest where they change over, so that a
/// branch in a place of constant resistance never gives back more than it took. S_in and S_out are
/// the shares' sums over either kind, divided by what that sum is when sliding steadily at the
/// reference speed: there R is the force.
struct MechanicalModel {
  static constexpr std::size_t kMostBranches = 3;

  ResistanceProfile in;
  ResistanceProfile out;
  double surface_mm = -1e9;                            ///< Drive depth; no resistance before it.
  double buildup_in_mm = 1.0;                          ///< > 0.
  double buildup_out_mm = 1.0;                         ///< > 0.
  double reference_mm_per_s = 5.0;                     ///< > 0.
  std::array<double, kMostBranches> relaxing_share{};  ///< Of the branches, >= 0, sum <= 1.
  std::array<double, kMostBranches> relaxation_s{1.0, 10.0,
                                                 100.0};  ///< > 0 where there is a share.
  std::vector<InternalPuncture> punctures;
  std::vector<Release> releases;
  std::vector<Slip> slips;  ///< By time; met in every rest that lasts so long.
  double offset_n = 0.0;
  double drift_n_per_s = 0.0;  ///< Since `start_s`.
  double start_s = 0.0;

  /// Resistance of the path ahead, if `deepest_mm` is not beyond `depth_mm`; else of the path that
  /// is cut: there are no membranes any more, only what they left.
  double ResistanceInN(double depth_mm, double deepest_mm) const noexcept;
  double ResistanceOutN(double depth_mm) const noexcept;
  /// The sum of the branches when sliding steadily at the reference speed.
  double SteadyStrain(bool inwards) const noexcept;
};

/// A state of the model: a value that can be copied and gone on from.
struct MechanicalState {
  bool started = false;
  double time_s = 0.0;
  double depth_mm = 0.0;  ///< Behind the drive by up to the play, so that its jitter is no motion.
  double rest_s = 0.0;    ///< Since the last motion beyond the play.
  double deepest_mm = 0.0;  ///< Punctures lie only ahead of it.
  std::array<double, MechanicalModel::kMostBranches + 1> strain{};  ///< s by branch, in [-1, 1].

  /// The strain after moving to `depth_mm` at `time_s`, exact for constant speed over the step: the
  /// same for a motion however it is cut into steps. A time that is not later changes nothing.
  ContactStrain Advance(const MechanicalModel& model, double time_s, double depth_mm) noexcept;

  /// The force of a strain where the needle is, without offset and drift.
  double ForceN(const MechanicalModel& model, const ContactStrain& strain,
                double drive_mm) const noexcept;
};

/// Force at each sample of a motion; it begins unstrained.
std::vector<double> Replay(const MechanicalModel& model, std::span<const double> time_s,
                           std::span<const double> depth_mm);

}  // namespace acus::forces
