#include "acus/scene/simulation/hand_energy.h"

#include <algorithm>

namespace acus::simulation {
namespace {

using Eigen::Vector3d;

constexpr double kTinyNMm = 1e-6;   // 1 nJ.
constexpr double kCreditNMm = 0.1;  // Tolerance on the work of the hand beyond the stored energy.

Vector3d TurnRad(const Eigen::Quaterniond& from, const Eigen::Quaterniond& to) noexcept {
  const Eigen::AngleAxisd turn(to * from.conjugate());
  return turn.angle() * turn.axis();
}

}  // namespace

void HandEnergy::Follow(const Vector3d& new_tip_in_ct_mm,
                        const Eigen::Quaterniond& new_ct_from_hand) noexcept {
  tip_in_ct_mm = new_tip_in_ct_mm;
  ct_from_hand = new_ct_from_hand;
}

void HandEnergy::Return(const Vector3d& new_tip_in_ct_mm,
                        const Eigen::Quaterniond& new_ct_from_hand, const BendingEnergy& needle,
                        const forces::NeedleForce& before, forces::NeedleForce& across) noexcept {
  const Vector3d force_n = before.force_in_ct_n + share * across.force_in_ct_n;
  const Vector3d torque_n_mm = before.torque_in_ct_n_mm + share * across.torque_in_ct_n_mm;
  double paid = paid_n_mm - 0.5 * (force_n.dot(new_tip_in_ct_mm - tip_in_ct_mm) +
                                   torque_n_mm.dot(TurnRad(ct_from_hand, new_ct_from_hand)));
  paid += std::clamp(needle.stored_n_mm - paid, 0.0, needle.spent_n_mm);
  paid_n_mm = std::clamp(paid, 0.0, needle.stored_n_mm + kCreditNMm);
  share =
      needle.stored_n_mm > kTinyNMm ? std::clamp(paid_n_mm / needle.stored_n_mm, 0.0, 1.0) : 1.0;
  Follow(new_tip_in_ct_mm, new_ct_from_hand);
  forces::Scale(across, share);
}

}  // namespace acus::simulation
