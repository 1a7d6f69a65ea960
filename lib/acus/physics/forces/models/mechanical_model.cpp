#include "acus/physics/forces/models/mechanical_model.h"

#include <algorithm>
#include <cmath>

#include "acus/base/core/error.h"

namespace acus::forces {
namespace {

/// Jitter of an encoder: without it bristles would creep in a hold.
constexpr double kContactPlayMm = 0.005;

constexpr double kRoundingMm = 1e-9;

double BranchShare(const MechanicalModel& model, std::size_t branch) {
  if (branch > 0) return model.relaxing_share[branch - 1];
  double rest = 1.0;
  for (const double share : model.relaxing_share) rest -= share;
  return rest;
}

/// One branch over a step of constant speed. @param decay  1 / tau times the step's duration.
double StrainedBranch(const MechanicalModel& model, double strain, double travel_mm,
                      double decay) noexcept {
  double left = 1.0;  // Of the step.
  for (int piece = 0; piece < 2; ++piece) {
    // A spring at rest is strained by whatever comes next.
    const bool inwards = strain != 0.0 ? strain > 0.0 : travel_mm > 0.0;
    const double slid = travel_mm / (inwards ? model.buildup_in_mm : model.buildup_out_mm);
    const double total = std::abs(slid) + decay;
    if (!(total > 0.0)) return strain;
    const double limit = slid / total;
    const bool turns = strain * limit < 0.0;
    const double end = limit + (strain - limit) * std::exp(-total * left);
    if (!turns || end * strain > 0.0) return end;
    // It is at rest within the step; from there the other spring is strained.
    left -= std::min(left, std::log1p(-strain / limit) / total);
    strain = 0.0;
  }
  return strain;
}

}  // namespace

double ResistanceProfile::ForceN(double depth) const noexcept {
  const std::size_t n = depth_mm.size();
  const auto above = std::upper_bound(depth_mm.begin(), depth_mm.end(), depth);
  const std::size_t k =
      std::clamp<std::size_t>(static_cast<std::size_t>(above - depth_mm.begin()), 1, n - 1);
  const double along = (depth - depth_mm[k - 1]) / (depth_mm[k] - depth_mm[k - 1]);
  return std::max(0.0, force_n[k - 1] + along * (force_n[k] - force_n[k - 1]));
}

double InternalPuncture::ForceN(double depth_mm) const noexcept {
  const double x = depth_mm - contact_mm;
  if (x <= 0.0) return 0.0;
  if (x <= puncture_mm) return (a1_n_per_mm + a2_n_per_mm2 * x) * x;
  return step_n + (PeakN() - step_n) * std::exp(-(x - puncture_mm) / recovery_mm);
}

double Release::ForceN(double depth_mm) const noexcept {
  return step_n / (1.0 + std::exp(std::clamp((at_mm - depth_mm) / width_mm, -50.0, 50.0)));
}

double MechanicalModel::ResistanceInN(double depth_mm, double deepest_mm) const noexcept {
  if (depth_mm <= surface_mm) return 0.0;
  double force = in.ForceN(depth_mm);
  for (const InternalPuncture& puncture : punctures) {
    const bool cut = deepest_mm > depth_mm + kContactPlayMm &&
                     deepest_mm > puncture.contact_mm + puncture.puncture_mm;
    if (!cut) {
      force += puncture.ForceN(depth_mm);
    } else if (depth_mm > puncture.contact_mm) {
      force += puncture.step_n;
    }
  }
  return std::max(0.0, force);
}

double MechanicalModel::ResistanceOutN(double depth_mm) const noexcept {
  if (depth_mm <= surface_mm) return 0.0;
  double force = out.ForceN(depth_mm);
  for (const Release& release : releases) force += release.ForceN(depth_mm);
  return std::max(0.0, force);
}

double MechanicalModel::SteadyStrain(bool inwards) const noexcept {
  const double rate = reference_mm_per_s / (inwards ? buildup_in_mm : buildup_out_mm);
  double strain = BranchShare(*this, 0);
  for (std::size_t k = 0; k < kMostBranches; ++k) {
    if (relaxing_share[k] > 0.0)
      strain += relaxing_share[k] * rate / (rate + 1.0 / relaxation_s[k]);
  }
  return strain;
}

ContactStrain MechanicalState::Advance(const MechanicalModel& model, double at_s,
                                       double drive_mm) noexcept {
  if (!started) {
    *this = {true, at_s, drive_mm, 0.0, drive_mm, {}};
  }
  const double dt_s = at_s - time_s;
  if (dt_s > 0.0) {
    double travel_mm = drive_mm - depth_mm;
    travel_mm -= std::clamp(travel_mm, -kContactPlayMm, kContactPlayMm);
    if (std::abs(travel_mm) < kRoundingMm) travel_mm = 0.0;  // Else a rest would never begin.
    depth_mm += travel_mm;
    deepest_mm = std::max(deepest_mm, depth_mm);
    time_s = at_s;
    for (std::size_t k = 0; k < strain.size(); ++k) {
      if (k > 0 && !(model.relaxing_share[k - 1] > 0.0)) continue;
      const double decay = k == 0 ? 0.0 : dt_s / model.relaxation_s[k - 1];
      strain[k] = StrainedBranch(model, strain[k], travel_mm, decay);
    }
    const double rested_s = rest_s;
    rest_s = travel_mm == 0.0 ? rest_s + dt_s : 0.0;
    for (const Slip& slip : model.slips) {
      // At rest every branch decays by itself: when in the step it slips does not matter.
      if (!(rested_s < slip.after_s && slip.after_s <= rest_s)) continue;
      for (double& s : strain) s *= 1.0 - slip.share;
    }
  }
  ContactStrain sum;
  for (std::size_t k = 0; k < strain.size(); ++k) {
    (strain[k] > 0.0 ? sum.in : sum.out) += BranchShare(model, k) * strain[k];
  }
  sum.in /= model.SteadyStrain(true);
  sum.out /= model.SteadyStrain(false);
  return sum;
}

double MechanicalState::ForceN(const MechanicalModel& model, const ContactStrain& sum,
                               double drive_mm) const noexcept {
  double force_n = 0.0;
  if (sum.in > 0.0) force_n += sum.in * model.ResistanceInN(drive_mm, deepest_mm);
  if (sum.out < 0.0) force_n += sum.out * model.ResistanceOutN(drive_mm);
  return force_n;
}

std::vector<double> Replay(const MechanicalModel& model, std::span<const double> time_s,
                           std::span<const double> depth_mm) {
  ACUS_ASSERT(time_s.size() == depth_mm.size());
  MechanicalState state;
  std::vector<double> force(time_s.size());
  for (std::size_t i = 0; i < time_s.size(); ++i) {
    const ContactStrain strain = state.Advance(model, time_s[i], depth_mm[i]);
    force[i] = model.offset_n + model.drift_n_per_s * (time_s[i] - model.start_s) +
               state.ForceN(model, strain, depth_mm[i]);
  }
  return force;
}

}  // namespace acus::forces
