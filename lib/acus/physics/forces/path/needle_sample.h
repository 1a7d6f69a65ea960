// What every force model takes in and gives out: one sample of the needle, one force on it.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string_view>

#include "acus/data/volume/volume.h"

namespace acus::forces {

struct NeedleInput {
  double time_s = 0.0;
  Eigen::Vector3d tip_in_ct_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d axis_in_ct = Eigen::Vector3d::UnitZ();  ///< Insertion direction; any length > 0.
  volume::Label tissue_at_tip = 0;                        ///< 0 outside the body.
  bool valid = true;                                      ///< False: the tracker lost the needle.
};

/// At most one per step; the first of this order that applies: bone contact, puncture, contact,
/// interface, bone release, withdrawal, channel interface.
enum class NeedleEvent : std::uint8_t {
  kNone,
  kContact,    ///< The tip touches the skin.
  kPuncture,   ///< A membrane yielded.
  kInterface,  ///< The tip reached another tissue, which it had not cut before.
  kBoneContact,
  kBoneRelease,
  kWithdrawal,        ///< The needle left the body.
  kChannelInterface,  ///< In the channel that is cut already, out or in again, to another tissue.
};
std::string_view NameOf(NeedleEvent event) noexcept;

/// Along the path, + pushes the needle out; the parts add up to the axial force. Below 0 each
/// of them pulls the needle in, as friction does while it is withdrawn.
struct NeedleForce {
  double puncture_n = 0.0;  ///< What a membrane adds while it is indented.
  double cutting_n = 0.0;
  double friction_n = 0.0;
  double bone_n = 0.0;
  double added_n = 0.0;    ///< By other effects of a scene: along the needle, of their forces.
  double lateral_n = 0.0;  ///< Across the path, magnitude.
  Eigen::Vector3d force_in_ct_n = Eigen::Vector3d::Zero();  ///< Total, on the needle.
  double depth_mm = 0.0;             ///< Of the needle's tip along the path since the skin.
  double bone_penetration_mm = 0.0;  ///< How far the device is beyond the tip, held by bone.
  NeedleEvent event = NeedleEvent::kNone;
  /// On the needle, about its tip; zero in models that do not clamp the needle's direction.
  Eigen::Vector3d torque_in_ct_n_mm = Eigen::Vector3d::Zero();

  double AxialN() const { return puncture_n + cutting_n + friction_n + bone_n + added_n; }
};

/// The one of two events of a step that is reported.
NeedleEvent FirstOf(NeedleEvent a, NeedleEvent b) noexcept;

/// All parts of the force and its torque times `share`; the event and lengths stay.
void Scale(NeedleForce& force, double share) noexcept;

/// Scales the force down so that its magnitude is at most `largest_n`.
void LimitTo(NeedleForce& force, double largest_n) noexcept;

}  // namespace acus::forces
