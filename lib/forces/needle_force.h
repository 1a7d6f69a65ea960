// The force on a needle from where its tip is and which tissue is there: one step per sample.
//
// The model is one-dimensional along the path that the needle makes when it pierces the skin
// (docs/models/needle_forces.md): membranes indented and punctured (Alamilla-2021 eq. 2), cutting
// by a tracking wall (eq. 3), friction along the buried shaft with bristles (eq. 4-6 without the
// velocity terms), bone as a proxy (Vidal-2008 eq. 7), and across the path a beam on a soft
// foundation (Augmented-2010, section II.D). Tissue does not deform in this model: the tip of the
// device is the tip of the needle, except on bone.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string_view>

#include "forces/force_laws.h"
#include "forces/force_table.h"
#include "forces/needle_path.h"

namespace acus::forces {

struct NeedleInput {
  double time_s = 0.0;
  Eigen::Vector3d tip_in_ct_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d axis_in_ct = Eigen::Vector3d::UnitZ();  ///< Insertion direction; any length > 0.
  volume::Label tissue_at_tip = 0;                        ///< 0 outside the body.
  bool valid = true;                                      ///< False: the tracker lost the needle.
};

/// At most one per step; the first of this order that applies: bone contact, puncture, contact,
/// interface, bone release, withdrawal.
enum class NeedleEvent : std::uint8_t {
  kNone,
  kContact,    ///< The tip touches the skin.
  kPuncture,   ///< A membrane gave way.
  kInterface,  ///< The tip reached another tissue.
  kBoneContact,
  kBoneRelease,
  kWithdrawal,  ///< The needle left the body.
};
std::string_view NameOf(NeedleEvent event) noexcept;

/// Along the path, + pushes the needle out; the four parts add up to the axial force.
struct NeedleForce {
  double puncture_n = 0.0;  ///< What a membrane adds while it is indented.
  double cutting_n = 0.0;
  double friction_n = 0.0;
  double bone_n = 0.0;
  double lateral_n = 0.0;                                   ///< Across the path, magnitude.
  Eigen::Vector3d force_in_ct_n = Eigen::Vector3d::Zero();  ///< Total, on the needle.
  double depth_mm = 0.0;             ///< Of the needle's tip along the path since the skin.
  double bone_penetration_mm = 0.0;  ///< How far the device is beyond the tip, held by bone.
  NeedleEvent event = NeedleEvent::kNone;

  double AxialN() const { return puncture_n + cutting_n + friction_n + bone_n; }
};

/// All that the model remembers. A plain value: copy it to save, assign it to restore.
struct NeedleForceState {
  bool started = false;
  double time_s = 0.0;        ///< Of the last sample taken in.
  double valid_time_s = 0.0;  ///< Of the last valid one.
  Eigen::Vector3d tip_in_ct_mm = Eigen::Vector3d::Zero();
  volume::Label tissue_at_tip = 0;
  NeedleForce held;                ///< The last force computed from a valid sample.
  std::int64_t num_rejected = 0;   ///< Samples with a value that is not finite or no axis.
  std::int64_t num_time_back = 0;  ///< Samples not later than the one before.

  bool in_body = false;     ///< There is a path: the tip has touched the skin.
  NeedlePath path;          ///< Segments are what the tip has met so far.
  bool pierced = false;     ///< The skin has given way; from then on the path guides the needle.
  double device_mm = 0.0;   ///< Depth of the device's tip.
  double depth_mm = 0.0;    ///< Depth of the needle's tip.
  double channel_mm = 0.0;  ///< Depth to which tissue is cut.
  volume::Label cut_tissue = 0;  ///< What the tip cuts, or would if it advanced.
  TrackingWall wall;
  BristleFriction bristle;

  bool pressing = false;  ///< On the membrane of `membrane_of`, at rest at `membrane_mm`.
  double membrane_mm = 0.0;
  volume::Label membrane_of = 0;
  bool has_candidate = false;  ///< Another tissue was seen, but not yet for long enough.
  volume::Label candidate = 0;
  double candidate_mm = 0.0;

  bool on_bone = false;
  double bone_mm = 0.0;        ///< Depth of the bone's surface.
  double bone_first_mm = 0.0;  ///< The same when it was first touched.
  Eigen::Vector3d bone_deviation_mm = Eigen::Vector3d::Zero();

  bool redirecting = false;  ///< Drawn back far enough to be turned to a new path.
  double lowest_mm = 0.0;    ///< Least depth since then.

  bool seen_outside = false;  ///< Unpierced, and the tip was seen off the skin at `outside_at_mm`.
  Eigen::Vector3d outside_at_mm = Eigen::Vector3d::Zero();
};

/// The model of one needle. Const after construction: any number of states may step side by side.
class NeedleForceModel {
 public:
  /// The table is scaled to the needle's diameter.
  NeedleForceModel(const ForceTable& table, const NeedleProperties& needle);

  /// Takes in the next sample. Cost O(tissues met on the path); under 1 us.
  ///  - a value that is not finite, or an axis of length 0: zero force, counted, state kept;
  ///  - time not later than before: the held force, counted, state kept;
  ///  - invalid: the held force, which falls to zero after the table's tracking_loss times.
  /// The magnitude of the force never exceeds the table's largest_force_n.
  NeedleForce Step(NeedleForceState& state, const NeedleInput& input) const noexcept;

  const ForceTable& table() const { return table_; }
  const NeedleProperties& needle() const { return needle_; }

  /// Stiffness across the path at this depth: the free part of the shaft as a cantilever, in
  /// series with the tissue around the buried part. N/mm.
  double LateralStiffnessNPerMm(double depth_mm) const noexcept;

 private:
  struct Motion;
  struct Membrane;
  NeedleForce HeldForce(const NeedleForceState& state) const noexcept;
  void TouchSkin(NeedleForceState& state, const Motion& motion) const noexcept;
  NeedleForce InBody(NeedleForceState& state, const Motion& motion, bool touched) const noexcept;
  bool HasLeft(NeedleForceState& state, const Motion& motion) const noexcept;
  void Guide(NeedleForceState& state, const Motion& motion) const noexcept;
  void Redirect(NeedleForceState& state, const Motion& motion) const noexcept;
  NeedleEvent MeetBone(NeedleForceState& state, const Motion& motion,
                       double device_mm) const noexcept;
  NeedleEvent MeetTissue(NeedleForceState& state, volume::Label label,
                         double previous_mm) const noexcept;
  bool HasMembrane(volume::Label from, volume::Label to) const noexcept;
  Membrane ActiveMembrane(const NeedleForceState& state) const noexcept;
  bool TryPuncture(NeedleForceState& state, const Motion& motion, double bone_n) const noexcept;
  void TipForces(NeedleForceState& state, NeedleForce& out) const noexcept;
  void Finish(const NeedleForceState& state, const Motion& motion, NeedleForce& out) const noexcept;

  ForceTable table_;
  NeedleProperties needle_;
};

}  // namespace acus::forces
