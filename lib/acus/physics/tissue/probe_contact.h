// An ultrasound probe that presses the skin: nodes under its face cannot be inside it.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "acus/physics/tissue/contact_mesh.h"
#include "acus/physics/tissue/contact_system.h"

namespace acus::tissue {

/// The face of a probe, in its frame: x along the face, z across, +y into the body; the origin is
/// the middle of the face.
struct ProbeFace {
  double length_mm = 60.0;  ///< Along x.
  double width_mm = 12.0;   ///< Along z.
  double radius_mm = 0.0;   ///< Of a convex face, about an axis along z; 0: flat.

  /// y of the face at x; falls behind the origin on a convex face.
  double SurfaceMm(double x_mm) const noexcept;
  /// dy/dx of it.
  double Slope(double x_mm) const noexcept;
};

/// What the probe feels: the force and torque that do the work which the tissue stores, for any
/// small motion of the probe. Along the face's normal in each node: there is no friction.
struct ProbeForce {
  Eigen::Vector3d force_in_ct_n = Eigen::Vector3d::Zero();  ///< On the probe.
  /// On the probe, about the middle of its face.
  Eigen::Vector3d torque_in_ct_n_mm = Eigen::Vector3d::Zero();
  int num_nodes = 0;        ///< That press on it.
  double deepest_mm = 0.0;  ///< Of the skin at rest inside the face, along its normal.
};

/// Which nodes are in which slots. A plain value.
struct ProbeState {
  std::vector<int> node_of_slot;   ///< Index of the surface node, -1: slot is free.
  std::vector<double> cleared_mm;  ///< Of each slot: how far its node must move.
  /// How that grows with the probe's motion: its gradient by translation, and by turning about the
  /// middle of the face, mm/rad.
  std::vector<Eigen::Vector3d> by_motion, by_turn_mm;
  std::vector<std::uint8_t> has_slot;  ///< Of each surface node.
  std::int64_t num_without_slot = 0;   ///< Nodes, summed over steps, that found all slots taken.
};

/// Frictionless, unilateral: the force on a node is along the skin's inner normal at rest, in
/// [0, kLargestNodeN], and the node's displacement along it at least what clears the face.
/// The direction belongs to the node, so turning the probe changes demands only, never a factor.
class ProbeContact {
 public:
  static constexpr double kLargestNodeN = 20.0;

  /// @param first_slot, num_slots  of the contact system, for the nodes under the face.
  ProbeContact(std::vector<SurfaceNode> surface, const ProbeFace& face, int first_slot,
               int num_slots);

  ProbeState NewState() const;

  /// Takes nodes under the face into slots, at most kMostNewNodes per call so that a step stays
  /// short, and sets their demands. Allocates nothing.
  void Place(const ContactSystem& system, ContactState& contact, ProbeState& state,
             const Eigen::Isometry3d& ct_from_probe) const noexcept;

  /// Lets go of all nodes.
  void Lift(const ContactSystem& system, ContactState& contact, ProbeState& state) const noexcept;

  /// After a solve: minus the sum over the nodes of their force times the gradients of what is
  /// demanded of them.
  ProbeForce ForceOf(const ContactState& contact, const ProbeState& state) const noexcept;

  const SurfaceNode& node(int index) const { return surface_[static_cast<std::size_t>(index)]; }
  int first_slot() const { return first_slot_; }

 private:
  static constexpr int kMostNewNodes = 8;
  struct Demand;
  Demand DemandOf(const SurfaceNode& node, const Eigen::Isometry3d& ct_from_probe) const noexcept;
  static void Keep(ProbeState& state, int slot, const Demand& demand) noexcept;

  std::vector<SurfaceNode> surface_;
  ProbeFace face_;
  int first_slot_;
  int num_slots_;
};

}  // namespace acus::tissue
