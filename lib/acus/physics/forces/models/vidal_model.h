// The force on a needle after Vidal-2008, eq. 1 to 8: from the CT itself, not from labels.
//
// On the skin a proxy until it yields; then the resistance of a B-spline table by HU, larger
// where tissues meet, averaged; bone by a proxy; and a force that keeps the needle on its line.
// Equations and decisions: docs/models/forces_vidal.md.
#pragma once

#include "acus/physics/forces/laws/force_table.h"
#include "acus/physics/forces/laws/hu_field.h"
#include "acus/physics/forces/laws/window_average.h"
#include "acus/physics/forces/path/guidance.h"
#include "acus/physics/forces/path/needle_sample.h"
#include "acus/physics/forces/path/needle_track.h"
#include "acus/physics/forces/probe/surface_proxy.h"

namespace acus::forces {

/// The state of the model between steps. A plain value: copy it to save, assign it to restore.
struct VidalState : NeedleTrack {
  SurfaceProxy skin;                                             ///< Until the skin is pierced.
  Eigen::Vector3d resistance_in_ct_n = Eigen::Vector3d::Zero();  ///< F1, by the passive mean.
  double resistance_n_per_mm = 0.0;  ///< Its stiffness in the last step.
  WindowAverage resistance_mean;     ///< F1, by the mean as printed.
  GuidanceState guide;
  bool at_edge = false;
};

/// The model of one needle in one CT. Const after construction: any number of states may step side
/// by side.
class VidalModel {
 public:
  /// The table is scaled to the needle's diameter. Keeps a reference to `field`, which must outlive
  /// this.
  VidalModel(const ForceTable& table, const NeedleProperties& needle, const HuField& field,
             GuidanceKind guidance = GuidanceKind::kOwn);

  /// Takes in the next sample; its tissue_at_tip is not used. Bad samples and the bound on the
  /// force: as NeedleForceModel::Step. puncture_n is the skin's force, cutting_n the resistance
  /// while the needle advances, friction_n (below 0) while it is withdrawn; an interface is where
  /// the gradient passes the threshold.
  NeedleForce Step(VidalState& state, const NeedleInput& input) const noexcept;

  const ForceTable& table() const { return table_; }

  /// What the model distinguishes at a place: air, tissue, bone, each at an edge or not.
  /// @param before  at the place before: an edge ends at a smaller gradient than it begins.
  int KindAt(const Eigen::Vector3d& place_in_ct_mm, int before) const noexcept;
  /// How close to look so as to meet all of it, mm.
  double HalfVoxelMm() const noexcept { return 0.5 * field_.ResolutionMm(); }

 private:
  bool MeetSkin(VidalState& state, const NeedleMotion& motion) const noexcept;
  NeedleForce OnSkin(VidalState& state, const NeedleMotion& motion) const noexcept;
  NeedleForce InTissue(VidalState& state, NeedleMotion& motion) const noexcept;
  NeedleEvent SeeEdge(VidalState& state, const Eigen::Vector3d& tip_mm) const noexcept;
  void Resistance(VidalState& state, const NeedleMotion& motion, double hu,
                  NeedleForce& out) const noexcept;

  ForceTable table_;
  const HuField& field_;
  GuidanceKind guidance_;
  volume::Label bone_;
};

}  // namespace acus::forces
