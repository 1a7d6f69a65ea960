#include "acus/physics/tissue/probe_contact.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace acus::tissue {
namespace {

constexpr double kMarginMm = 1.0;         // A node is let go when it is this far off the face.
constexpr double kDeepestMm = 60.0;       // Deeper in the probe: it is on another side of the body.
constexpr double kLeastFaceCosine = 0.3;  // Skin steeper than this to the face is beside it.

}  // namespace

double ProbeFace::SurfaceMm(double x_mm) const noexcept {
  if (radius_mm <= 0.0) return 0.0;
  const double x = std::min(std::abs(x_mm), radius_mm);
  return std::sqrt(radius_mm * radius_mm - x * x) - radius_mm;
}

double ProbeFace::Slope(double x_mm) const noexcept {
  if (radius_mm <= 0.0) return 0.0;
  const double x = std::clamp(x_mm, -0.99 * radius_mm, 0.99 * radius_mm);
  return -x / std::sqrt(radius_mm * radius_mm - x * x);
}

/// How far along its normal a node must move to clear the face, and how that grows with the
/// probe's motion. -infinity: it is not under it.
struct ProbeContact::Demand {
  double needed_mm = -std::numeric_limits<double>::infinity();
  Eigen::Vector3d by_motion = Eigen::Vector3d::Zero();
  Eigen::Vector3d by_turn_mm = Eigen::Vector3d::Zero();
};

ProbeContact::ProbeContact(std::vector<SurfaceNode> surface, const ProbeFace& face, int first_slot,
                           int num_slots)
    : surface_(std::move(surface)), face_(face), first_slot_(first_slot), num_slots_(num_slots) {}

ProbeState ProbeContact::NewState() const {
  ProbeState state;
  state.node_of_slot.assign(static_cast<std::size_t>(num_slots_), -1);
  state.cleared_mm.assign(static_cast<std::size_t>(num_slots_), 0.0);
  state.by_motion.assign(static_cast<std::size_t>(num_slots_), Eigen::Vector3d::Zero());
  state.by_turn_mm = state.by_motion;
  state.has_slot.assign(surface_.size(), 0);
  return state;
}

ProbeContact::Demand ProbeContact::DemandOf(const SurfaceNode& node,
                                            const Eigen::Isometry3d& ct_from_probe) const noexcept {
  const Eigen::Vector3d from_middle = node.rest_in_ct_mm - ct_from_probe.translation();
  const Eigen::Vector3d at = ct_from_probe.linear().transpose() * from_middle;
  if (!(std::abs(at.x()) <= 0.5 * face_.length_mm && std::abs(at.z()) <= 0.5 * face_.width_mm)) {
    return {};
  }
  const Eigen::Vector3d beam = ct_from_probe.linear().col(1);
  const double cosine = beam.dot(node.inward_in_ct);
  const double inside_mm = face_.SurfaceMm(at.x()) - at.y();
  if (cosine < kLeastFaceCosine || inside_mm > kDeepestMm) return {};
  const Eigen::Vector3d by_motion =
      (beam - face_.Slope(at.x()) * ct_from_probe.linear().col(0)) / cosine;
  return {
      inside_mm / cosine, by_motion,
      from_middle.cross(by_motion) - inside_mm / (cosine * cosine) * beam.cross(node.inward_in_ct)};
}

void ProbeContact::Keep(ProbeState& state, int slot, const Demand& demand) noexcept {
  const auto s = static_cast<std::size_t>(slot);
  state.cleared_mm[s] = demand.needed_mm;
  state.by_motion[s] = demand.by_motion;
  state.by_turn_mm[s] = demand.by_turn_mm;
}

void ProbeContact::Place(const ContactSystem& system, ContactState& contact, ProbeState& state,
                         const Eigen::Isometry3d& ct_from_probe) const noexcept {
  for (int s = 0; s < num_slots_; ++s) {
    int& node = state.node_of_slot[static_cast<std::size_t>(s)];
    if (node < 0) continue;
    const Demand demand = DemandOf(surface_[static_cast<std::size_t>(node)], ct_from_probe);
    if (demand.needed_mm < -kMarginMm) {
      system.ClearSlot(contact, first_slot_ + s);
      state.has_slot[static_cast<std::size_t>(node)] = 0;
      node = -1;
      continue;
    }
    contact.SetSlotDemand(first_slot_ + s, demand.needed_mm, 0.0, kLargestNodeN);
    Keep(state, s, demand);
  }
  int slot = 0;
  int num_new = 0;
  for (std::size_t n = 0; n < surface_.size() && num_new < kMostNewNodes; ++n) {
    if (state.has_slot[n] != 0) continue;
    const Demand demand = DemandOf(surface_[n], ct_from_probe);
    if (!(demand.needed_mm > 0.0)) continue;
    while (slot < num_slots_ && state.node_of_slot[static_cast<std::size_t>(slot)] >= 0) ++slot;
    if (slot == num_slots_) {
      ++state.num_without_slot;
      continue;
    }
    const ContactPlace place{{surface_[n].row}, {1.0}, 1};
    system.SetSlot(contact, first_slot_ + slot, place, surface_[n].inward_in_ct, 0.0);
    contact.SetSlotDemand(first_slot_ + slot, demand.needed_mm, 0.0, kLargestNodeN);
    Keep(state, slot, demand);
    state.node_of_slot[static_cast<std::size_t>(slot)] = static_cast<int>(n);
    state.has_slot[n] = 1;
    ++num_new;
  }
}

void ProbeContact::Lift(const ContactSystem& system, ContactState& contact,
                        ProbeState& state) const noexcept {
  for (int s = 0; s < num_slots_; ++s) {
    int& node = state.node_of_slot[static_cast<std::size_t>(s)];
    if (node < 0) continue;
    system.ClearSlot(contact, first_slot_ + s);
    state.has_slot[static_cast<std::size_t>(node)] = 0;
    node = -1;
  }
}

ProbeForce ProbeContact::ForceOf(const ContactState& contact,
                                 const ProbeState& state) const noexcept {
  ProbeForce out;
  for (int s = 0; s < num_slots_; ++s) {
    const int node = state.node_of_slot[static_cast<std::size_t>(s)];
    if (node < 0 || contact.SlotForceN(first_slot_ + s) <= 0.0) continue;
    const double force_n = contact.SlotForceN(first_slot_ + s);
    const auto of = static_cast<std::size_t>(s);
    out.force_in_ct_n -= force_n * state.by_motion[of];
    out.torque_in_ct_n_mm -= force_n * state.by_turn_mm[of];
    out.deepest_mm = std::max(out.deepest_mm, state.cleared_mm[of]);
    ++out.num_nodes;
  }
  return out;
}

}  // namespace acus::tissue
