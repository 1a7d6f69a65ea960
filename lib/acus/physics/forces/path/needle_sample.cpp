#include "acus/physics/forces/path/needle_sample.h"

namespace acus::forces {

std::string_view NameOf(NeedleEvent event) noexcept {
  constexpr std::string_view kNames[] = {"none",       "contact",          "puncture",
                                         "interface",  "bone_contact",     "bone_release",
                                         "withdrawal", "channel_interface"};
  return kNames[static_cast<std::size_t>(event)];
}

NeedleEvent FirstOf(NeedleEvent a, NeedleEvent b) noexcept {
  using enum NeedleEvent;
  for (const NeedleEvent event : {kBoneContact, kPuncture, kContact, kInterface, kBoneRelease,
                                  kWithdrawal, kChannelInterface}) {
    if (a == event || b == event) return event;
  }
  return kNone;
}

void Scale(NeedleForce& force, double share) noexcept {
  force.puncture_n *= share;
  force.cutting_n *= share;
  force.friction_n *= share;
  force.bone_n *= share;
  force.added_n *= share;
  force.lateral_n *= share;
  force.force_in_ct_n *= share;
  force.torque_in_ct_n_mm *= share;
}

void LimitTo(NeedleForce& force, double largest_n) noexcept {
  const double size_n = force.force_in_ct_n.norm();
  if (size_n > largest_n) Scale(force, largest_n / size_n);
}

}  // namespace acus::forces
