#include "acus/patient/fitting/mechanical_model.h"

#include <algorithm>
#include <cmath>

#include "acus/base/core/error.h"

namespace acus::fitting {
namespace {

constexpr double kPlayMm =
    0.005;  // Jitter of an encoder: without it bristles would creep in a hold.

double Share(const MechanicalModel& model, std::size_t branch) {
  return branch == 0 ? 1.0 - model.relaxing_share[0] - model.relaxing_share[1]
                     : model.relaxing_share[branch - 1];
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
    const bool cut =
        deepest_mm > depth_mm + kPlayMm && deepest_mm > puncture.contact_mm + puncture.puncture_mm;
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
  double strain = Share(*this, 0);
  for (std::size_t k = 1; k < 3; ++k) {
    strain += Share(*this, k) * rate / (rate + 1.0 / relaxation_s[k - 1]);
  }
  return strain;
}

double MechanicalState::Advance(const MechanicalModel& model, double at_s,
                                double drive_mm) noexcept {
  if (!started) {
    *this = {true, at_s, drive_mm, drive_mm, {}};
  }
  const double dt_s = at_s - time_s;
  if (dt_s > 0.0) {
    double travel_mm = drive_mm - depth_mm;
    travel_mm -= std::clamp(travel_mm, -kPlayMm, kPlayMm);
    depth_mm += travel_mm;
    deepest_mm = std::max(deepest_mm, depth_mm);
    time_s = at_s;
    const double slid = travel_mm / (travel_mm > 0.0 ? model.buildup_in_mm : model.buildup_out_mm);
    for (std::size_t k = 0; k < 3; ++k) {
      const double decay = k == 0 ? 0.0 : dt_s / model.relaxation_s[k - 1];
      const double total = std::abs(slid) + decay;
      if (!(total > 0.0)) continue;
      const double limit = slid / total;
      strain[k] = limit + (strain[k] - limit) * std::exp(-total);
    }
  }
  double sum = 0.0;
  for (std::size_t k = 0; k < 3; ++k) sum += Share(model, k) * strain[k];
  return sum / model.SteadyStrain(sum > 0.0);
}

std::vector<double> Replay(const MechanicalModel& model, std::span<const double> time_s,
                           std::span<const double> depth_mm) {
  ACUS_ASSERT(time_s.size() == depth_mm.size());
  MechanicalState state;
  std::vector<double> force(time_s.size());
  for (std::size_t i = 0; i < time_s.size(); ++i) {
    const double strain = state.Advance(model, time_s[i], depth_mm[i]);
    const double resistance = strain > 0.0 ? model.ResistanceInN(depth_mm[i], state.deepest_mm)
                                           : model.ResistanceOutN(depth_mm[i]);
    force[i] =
        model.offset_n + model.drift_n_per_s * (time_s[i] - model.start_s) + strain * resistance;
  }
  return force;
}

}  // namespace acus::fitting
