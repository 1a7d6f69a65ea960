// The force on an ultrasound probe after Vidal-2008, section 3.3.1: a proxy on the skin, and bone
// found in the CT on the line from the proxy to the device. docs/models/forces_vidal.md.
#pragma once

#include <Eigen/Geometry>

#include "acus/physics/forces/laws/force_table.h"
#include "acus/physics/forces/laws/hu_field.h"
#include "acus/physics/forces/path/sample_gate.h"
#include "acus/physics/forces/probe/probe_sample.h"
#include "acus/physics/forces/probe/proxy_contact.h"
#include "acus/physics/forces/probe/surface_proxy.h"

namespace acus::forces {

/// A plain value: copy it to save, assign it to restore.
struct VidalProbeState : SampleGate {
  SurfaceProxy skin;
  SurfaceProxy bone;
  Eigen::Vector3d moved_n = Eigen::Vector3d::Zero();  ///< Left of the jump of a moved proxy.
  Eigen::Vector3d spring_n = Eigen::Vector3d::Zero();
  bool proxy_on_bone = false;
  Eigen::Vector3d place_in_ct_mm = Eigen::Vector3d::Zero();  ///< Of the last valid sample.
  SuddenRise rise;
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

  double largest_force_n() const { return law_.largest_force_n; }

 private:
  Eigen::Vector3d TwoSpringsN(VidalProbeState& state, const Eigen::Vector3d& before,
                              const Eigen::Vector3d& place, ProbeForce& out) const noexcept;
  Eigen::Vector3d MovedProxyN(VidalProbeState& state, const Eigen::Vector3d& place, double dt_s,
                              ProbeForce& out) const noexcept;

  ForceSettings settings_;
  VidalSettings::Probe law_;
  const HuField& field_;
  volume::Label bone_;
};

}  // namespace acus::forces
