// The force on an ultrasound probe after Vidal-2008, section 3.3.1: a proxy on the skin, and bone
// found in the CT on the line from the proxy to the device. docs/models/forces_vidal.md.
#pragma once

#include <Eigen/Geometry>

#include "forces/force_table.h"
#include "forces/hu_field.h"
#include "forces/sample_gate.h"
#include "forces/surface_proxy.h"

namespace acus::forces {

struct ProbeInput {
  double time_s = 0.0;
  Eigen::Isometry3d ct_from_probe = Eigen::Isometry3d::Identity();  ///< Origin: middle of the face.
  bool valid = true;
};

struct ProbeForce {
  Eigen::Vector3d force_in_ct_n = Eigen::Vector3d::Zero();  ///< On the probe.
  bool on_skin = false;
  bool on_bone = false;
  double skin_mm = 0.0;  ///< From the device back to the proxy on the skin.
  double bone_mm = 0.0;  ///< To the proxy on bone.
};

/// A plain value: copy it to save, assign it to restore.
struct VidalProbeState : SampleGate {
  SurfaceProxy skin;
  SurfaceProxy bone;
  Eigen::Vector3d place_in_ct_mm = Eigen::Vector3d::Zero();  ///< Of the last valid sample.
  double held_back = 0.0;  ///< Share of the force that is still held back after a sudden rise.
  double model_n = 0.0;    ///< Size of the last force before that.
  ProbeForce last;
};

/// Const after construction: any number of states may step side by side.
class VidalProbe {
 public:
  /// Keeps a reference to `field`, which must outlive this.
  VidalProbe(const ForceTable& table, const HuField& field);

  /// Takes in the next sample. Bad samples: as NeedleForceModel::Step. The magnitude of the force
  /// never exceeds the probe's largest_force_n.
  ProbeForce Step(VidalProbeState& state, const ProbeInput& input) const noexcept;

 private:
  void MeetSkin(VidalProbeState& state, const Eigen::Vector3d& place, bool first) const noexcept;
  void MeetBone(VidalProbeState& state, const Eigen::Vector3d& place) const noexcept;
  double ShareToGive(VidalProbeState& state, double force_n, double travel_mm,
                     double dt_s) const noexcept;

  ForceSettings settings_;
  VidalSettings::Probe law_;
  const HuField& field_;
};

}  // namespace acus::forces
