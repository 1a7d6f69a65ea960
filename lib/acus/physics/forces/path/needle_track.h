// Where the needle is in the body: the skin that it touched, the channel that it cut, the tissues
// on it, the membrane or bone that it presses on. Shared by the models that go by tissue labels.
#pragma once

#include <Eigen/Core>
#include <array>

#include "acus/physics/forces/laws/force_table.h"
#include "acus/physics/forces/path/needle_path.h"
#include "acus/physics/forces/path/needle_sample.h"
#include "acus/physics/forces/path/sample_gate.h"

namespace acus::forces {

/// A membrane that the tip presses on: of which tissue, and where it is at rest; 0: none.
struct PressedMembrane {
  volume::Label tissue = 0;
  double at_mm = 0.0;

  bool operator==(const PressedMembrane&) const = default;
};

/// The base of a model's state. A plain value.
struct NeedleTrack : SampleGate {
  Eigen::Vector3d tip_in_ct_mm = Eigen::Vector3d::Zero();  ///< Of the last valid sample.
  volume::Label tissue_at_tip = 0;

  bool in_body = false;          ///< There is a path: the tip has touched the skin.
  NeedlePath path;               ///< Segments are what the tip has met so far.
  bool pierced = false;          ///< The skin has yielded; from then on the path guides the needle.
  double device_mm = 0.0;        ///< Depth of the device's tip.
  double depth_mm = 0.0;         ///< Depth of the needle's tip.
  double channel_mm = 0.0;       ///< Depth to which tissue is cut.
  volume::Label cut_tissue = 0;  ///< What the tip cuts, or would if it advanced.

  volume::Label around_tip =
      0;  ///< What holds the tip; unlike the map's label it does not flicker.

  bool pressing = false;  ///< On the membrane of `membrane_of`, at rest at `membrane_mm`.
  double membrane_mm = 0.0;
  volume::Label membrane_of = 0;
  PressedMembrane creeping;  ///< Whose relaxing springs these are:
  std::array<double, ForceRelaxation::kMostTerms> crept_mm{};  ///< where each is at rest.
  bool has_candidate = false;  ///< Another tissue was seen, but not yet for long enough.
  volume::Label candidate = 0;
  double candidate_mm = 0.0;

  bool on_bone = false;
  double bone_mm = 0.0;        ///< Depth of the bone's surface.
  double bone_first_mm = 0.0;  ///< The same when it was first touched.
  Eigen::Vector3d bone_deviation_mm = Eigen::Vector3d::Zero();

  bool seen_outside = false;  ///< Unpierced, and the tip was seen off the skin at `outside_at_mm`.
  Eigen::Vector3d outside_at_mm = Eigen::Vector3d::Zero();
};

/// One valid sample together with the one before.
struct NeedleMotion {
  double dt_s = 0.0;
  Eigen::Vector3d previous_mm;
  Eigen::Vector3d tip_mm;
  Eigen::Vector3d axis;  ///< Unit length.
  volume::Label previous_label = 0;
  volume::Label label = 0;
  bool has_previous = false;
};
/// @pre the gate's verdict on `input` was kStep.
NeedleMotion MotionOf(const NeedleTrack& track, const NeedleInput& input) noexcept;

/// Begins a path at the skin: half way between the last sample outside and this one. In the table's
/// nick there is no skin to press on.
void TouchSkin(const ForceTable& table, NeedleTrack& track, const NeedleMotion& motion) noexcept;

/// True if the needle is no longer in or on the body.
bool HasLeft(const ForceTable& table, NeedleTrack& track, const NeedleMotion& motion) noexcept;

/// Bone begins and ends to hold the tip. @param device_mm  depth of the device's tip now;
/// track.device_mm is still that of the sample before.
NeedleEvent MeetBone(const ForceTable& table, NeedleTrack& track, const NeedleMotion& motion,
                     double device_mm) noexcept;

/// Follows the tissues along the path. In the channel that is cut already there is nothing to meet.
/// @param previous_mm  track.depth_mm of the sample before.
NeedleEvent MeetTissue(const ForceTable& table, NeedleTrack& track, volume::Label label,
                       double previous_mm) noexcept;

/// The membrane that is pressed on; also one that was seen too shortly to be certain, so that its
/// force begins at zero.
PressedMembrane ActiveMembrane(const ForceTable& table, const NeedleTrack& track) noexcept;

/// Lets the relaxing springs of the membrane that is pressed on creep.
void CreepMembrane(const ForceTable& table, NeedleTrack& track, const TipMove& move) noexcept;

/// Force of that membrane; 0 without one.
double PressedN(const ForceTable& table, const NeedleTrack& track) noexcept;

/// Lets the membrane yield if it is pressed hard enough. On piercing the skin, the path takes
/// the needle's direction (Augmented-2010, section II.D).
/// @param bone_n  force of a bone right behind it, which presses too.
/// @return the force at which it yielded; 0 if it did not.
double TryPuncture(const ForceTable& table, NeedleTrack& track, const NeedleMotion& motion,
                   double bone_n) noexcept;

/// What holds the tip: also on its way out, and in again. A membrane that is only pressed has let
/// nothing of what is behind it through; a tremor at an interface is on one side of it.
/// @param before  what held it before.
volume::Label TissueAroundTip(const NeedleTrack& track, volume::Label before,
                              double hysteresis_mm) noexcept;

/// What happened on the path in one step.
struct TrackStep {
  bool left = false;         ///< The needle is out of the body; nothing else is set but event.
  bool was_pierced = false;  ///< Before this step: a shaft that has just come in has not slid.
  double previous_mm = 0.0;  ///< Depth of the needle's tip before.
  double device_speed_mm_per_s = 0.0;  ///< Along the path, + inwards.
  double bone_penetration_mm = 0.0;    ///< Of the device beyond the bone.
  double bone_n = 0.0;                 ///< By the table's BoneSpring.
  double punctured_n = 0.0;            ///< Force at which a membrane yielded; 0: none did.
  NeedleEvent event = NeedleEvent::kNone;
};

/// One step along the path: leaving, bone, tissues, puncture, in this order. @pre track.in_body.
/// @param touched  the skin was touched by this sample.
TrackStep FollowPath(const ForceTable& table, NeedleTrack& track, const NeedleMotion& motion,
                     bool touched) noexcept;

}  // namespace acus::forces
