// Forces between tools and elastic tissue at the places where they touch, from the compliance of
// the tissue: the numerics of contact, independent of needles.
//
// Two kinds of unknown (docs/models/tissue_contact.md):
//  - points of a needle: two lateral forces, bilateral (the displacement across the needle is
//    prescribed), and one axial force within bounds. Points are last-in-first-out;
//  - slots: one force along one direction within bounds (the needle's tip, nodes under a probe), in
//    any order.
// With A the compliance between them, the lateral unknowns l are eliminated by A_ll = U^T U and
// W = U^-T A_lb, which leaves S = A_bb - W^T W for the bounded ones. U and W only ever change at
// their end, and S is kept as sums over the rows of W from the first to the last, with copies every
// few points to go back to. So nothing is ever updated downwards: whatever was appended and dropped
// before, U, W and S are bit for bit what a fresh start gives, and there is no drift.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include "acus/physics/mechanics/condensation/compliance.h"
#include "acus/physics/mechanics/elements/relaxation.h"
#include "acus/physics/tissue/box_solver.h"
#include "acus/physics/tissue/triangular_factor.h"

namespace acus::tissue {

/// A place in the tissue at rest: weights of rows of the compliance. Nodes that do not move or
/// cannot be reached have no row, so the weights may add up to less than 1.
struct ContactPlace {
  static constexpr int kMostRows = 160;
  std::array<int, kMostRows> row{};
  std::array<double, kMostRows> weight{};
  int num_rows = 0;
};

/// What the mesh cannot resolve around a point: added to the diagonal of the compliance, mm/N.
struct LocalCompliance {
  double lateral_mm_per_n = 0.0;
  double axial_mm_per_n = 0.0;
};

class ContactSystem;

/// Which places are in contact, the factors, the forces. A plain value: a copy continues with the
/// same bits. Made by ContactSystem::NewState(), which takes all the memory that it will ever need.
class ContactState {
 public:
  int num_points() const { return num_points_; }
  bool slot_in_use(int slot) const { return slot_used_[slot] != 0; }
  const ContactPlace& point_place(int point) const { return point_place_[point]; }
  const LocalCompliance& point_local(int point) const { return point_local_[point]; }
  const Eigen::Matrix3d& frame() const { return frame_; }
  int num_slots() const { return num_slots_; }
  const ContactPlace& slot_place(int slot) const { return slot_place_[slot]; }
  const Eigen::Vector3d& slot_direction(int slot) const { return slot_direction_[slot]; }
  double slot_local_mm_per_n(int slot) const { return slot_local_[slot]; }

  /// The input of the next Solve(). Lateral displacement along the frame's first two columns.
  void SetLateral(int point, double first_mm, double second_mm) {
    lateral_mm_[2 * point] = first_mm;
    lateral_mm_[2 * point + 1] = second_mm;
  }
  void SetPointAxial(int point, double displacement_mm, double low_n, double high_n) {
    SetBounded(num_slots_ + point, displacement_mm, low_n, high_n);
  }
  void SetSlotDemand(int slot, double displacement_mm, double low_n, double high_n) {
    SetBounded(slot, displacement_mm, low_n, high_n);
  }

  /// Sets the demand of a column (slots, then points); its bounds stay.
  void SetDemand(int column, double displacement_mm) { demand_mm_[column] = displacement_mm; }

  /// What was requested: of points' two lateral displacements; of columns (slots, then points).
  double LateralMm(int row) const { return lateral_mm_[row]; }
  double DemandMm(int column) const { return demand_mm_[column]; }
  double LowN(int column) const { return low_n_[column]; }
  double HighN(int column) const { return high_n_[column]; }
  ContactStatus Status(int column) const { return solver_.status(column); }

  /// A force beside the compliance that presses the tissue at a slot and relaxes with the slot's:
  /// bounds hold for both together. Elastic, 0 when a slot is taken into use.
  void SetSlotExtra(int slot, double elastic_n) { slot_extra_n_[slot] = elastic_n; }

  /// Forces on the tissue after Solve(): lateral, lateral, axial, in the frame.
  Eigen::Vector3d PointForceN(int point) const {
    const Eigen::Vector3d elastic_n = ElasticPointN(point);
    if (relaxation_.num_terms == 0) return elastic_n;
    const int column = num_slots_ + point;
    return alpha_ * elastic_n - Eigen::Vector3d(held_lateral_n_[2 * point],
                                                held_lateral_n_[2 * point + 1], held_n_[column]);
  }
  /// With what was set as extra.
  double SlotForceN(int slot) const {
    const double elastic_n = bounded_n_[slot] + slot_extra_n_[slot];
    return relaxation_.num_terms == 0 ? elastic_n : alpha_ * elastic_n - held_n_[slot];
  }

  /// Those that would deform elastic tissue as it is deformed now; without extras.
  Eigen::Vector3d ElasticPointN(int point) const {
    return {lateral_n_[2 * point], lateral_n_[2 * point + 1], bounded_n_[num_slots_ + point]};
  }
  double ElasticSlotN(int slot) const { return bounded_n_[slot]; }
  /// Displacement less what was requested; 0 while a point sticks.
  double PointExcessMm(int point) const { return solver_.Excess(num_slots_ + point); }
  double SlotExcessMm(int slot) const { return solver_.Excess(slot); }
  ContactStatus PointStatus(int point) const { return solver_.status(num_slots_ + point); }
  ContactStatus SlotStatus(int slot) const { return solver_.status(slot); }

  const BoxCounts& counts() const { return solver_.counts(); }
  std::int64_t num_refactors() const { return num_refactors_; }
  std::int64_t num_checks() const { return num_checks_; }
  double largest_residual_mm() const { return largest_residual_mm_; }

  /// For tests of the residual monitor: spoils the factor where all points depend on it.
  void SpoilFactorForTest(double factor) {
    for (int j = 1; j < 2 * num_points_; ++j) lateral_factor_.Row(0)[j] *= factor;
  }
  /// For tests of bits: the solve begins with this status.
  void CopyStatusForTest(int column, ContactStatus status) { solver_.SetStatus(column, status); }

 private:
  friend class ContactSystem;
  void SetBounded(int column, double displacement_mm, double low_n, double high_n) {
    demand_mm_[column] = displacement_mm;
    const double extra_n = column < num_slots_ ? slot_extra_n_[column] : 0.0;
    const double held_n = relaxation_.num_terms == 0 ? 0.0 : held_n_[column];
    low_n_[column] = (low_n + held_n) / alpha_ - extra_n;
    high_n_[column] = (high_n + held_n) / alpha_ - extra_n;
  }
  double* W(int row) { return w_.data() + row * stride_; }
  const double* W(int row) const { return w_.data() + row * stride_; }
  double* S(int row) { return s_.data() + row * stride_; }
  double* Birth(int point) { return birth_.data() + point * stride_; }

  int num_slots_ = 0;
  int num_points_ = 0;
  std::ptrdiff_t stride_ = 0;
  Eigen::Matrix3d frame_ = Eigen::Matrix3d::Identity();
  std::vector<ContactPlace> point_place_;
  std::vector<LocalCompliance> point_local_;
  std::vector<ContactPlace> slot_place_;
  std::vector<Eigen::Vector3d> slot_direction_;
  std::vector<double> slot_local_;
  std::vector<std::uint8_t> slot_used_;

  TriangularFactor lateral_factor_;  ///< U of A_ll.
  std::vector<double> w_;            ///< W, two rows per point; columns are slots, then points.
  std::vector<double> s_;            ///< Lower triangle of S.
  std::vector<double> birth_;        ///< Row of S of each point when it was the last one.
  std::vector<double> copies_;       ///< S after every kPointsPerCopy points, packed.
  BoxSolver solver_;

  std::vector<double> lateral_mm_, demand_mm_, low_n_, high_n_;
  std::vector<double> lateral_n_, bounded_n_, slot_extra_n_;  ///< Elastic.

  // Relaxation. A term's force q follows share * elastic; the tissue's force is elastic - sum of q.
  // In a step q = decay q + (1 - decay) share elastic, so the force is alpha elastic - held.
  mechanics::Relaxation relaxation_;
  double alpha_ = 1.0;
  std::array<double, mechanics::Relaxation::kMostTerms> decay_{};
  std::vector<double> held_lateral_n_, held_n_;  ///< Sum of decay q, of lateral rows and columns.
  std::vector<double> lost_lateral_n_, lost_n_;  ///< q of each term, one term after the other.
  std::vector<double> rhs_, reduced_mm_, first_, second_, third_;  ///< Work space.
  // What the slot that was set last does at nodes, mm/N: many points share a node.
  std::vector<Eigen::Vector3d> seen_mm_per_n_;
  std::vector<int> seen_when_;
  int seen_now_ = 0;
  int seen_slot_ = -1;

  int check_next_ = 0;
  std::int64_t num_solves_ = 0;
  std::int64_t num_refactors_ = 0;
  std::int64_t num_checks_ = 0;
  double largest_residual_mm_ = 0.0;
};

/// Const after construction: any number of states may step side by side. All methods that change a
/// state are noexcept and allocate nothing.
class ContactSystem {
 public:
  struct Capacity {
    int points = 96;
    int slots = 1;
  };

  /// @pre 1 <= points, 0 <= slots, 2 points + slots <= 1000.
  ContactSystem(mechanics::Compliance compliance, Capacity capacity,
                const mechanics::Relaxation& relaxation = {});

  ContactState NewState() const;

  /// Drops all points; later ones use this frame. @param frame  orthonormal columns: lateral,
  /// lateral, axial, in CT space.
  void Restart(ContactState& state, const Eigen::Matrix3d& frame) const noexcept;

  /// Adds a point at the end, free of force. @return its displacement by the present forces, in the
  /// frame. @pre there is room, see Capacity; both parts of `local` > 0.
  /// Cost O(n^2 + n * slots).
  Eigen::Vector3d AppendPoint(ContactState& state, const ContactPlace& place,
                              const LocalCompliance& local) const noexcept;

  /// Keeps the first `count` points.
  void TruncatePoints(ContactState& state, int count) const noexcept;

  /// Takes a slot into use or moves it. @param direction  unit length. Its force stays until the
  /// next Solve(). @pre the place has a row, or local_mm_per_n > 0.
  void SetSlot(ContactState& state, int slot, const ContactPlace& place,
               const Eigen::Vector3d& direction, double local_mm_per_n) const noexcept;
  void ClearSlot(ContactState& state, int slot) const noexcept;

  /// Time goes by, with the forces of the last Solve() at its end: before what is demanded of the
  /// next one is set. Nothing for elastic tissue. @param duration_s  >= 0.
  void Pass(ContactState& state, double duration_s) const noexcept;

  /// Finds all forces for what was asked by Set...(). Every few calls one point is held against the
  /// compliance itself; if the residual is above kLargestResidualMm, all is factored again, solved
  /// again and counted.
  /// @return false if the bounded part ran out of rounds; forces then keep to their bounds.
  bool Solve(ContactState& state) const noexcept;

  /// Builds U, W and S from the places. Same bits unless something spoiled them.
  void Refactor(ContactState& state) const noexcept;

  /// Displacement of a place by all forces of the last Solve(), CT space, mm; without local parts.
  Eigen::Vector3d DisplacementMm(const ContactState& state,
                                 const ContactPlace& place) const noexcept;

  /// What remains of the equations of one point, straight from the compliance, mm.
  double ResidualMm(const ContactState& state, int point) const noexcept;

  /// Compliance between two places, CT axes, mm/N.
  Eigen::Matrix3d Between(const ContactPlace& a, const ContactPlace& b) const noexcept;

  const mechanics::Compliance& compliance() const { return compliance_; }
  const Capacity& capacity() const { return capacity_; }

 private:
  void SolveOnce(ContactState& state, bool& solved) const noexcept;
  void Forget(ContactState& state, int column) const noexcept;
  void SaveCopy(ContactState& state, int index) const noexcept;
  std::ptrdiff_t CopyBegin(int index) const noexcept;
  double SlotBetween(const ContactState& state, int a, int b) const noexcept;
  Eigen::Vector3d SlotToNode(ContactState& state, int slot, int row) const noexcept;
  Eigen::Vector3d SlotToPoint(ContactState& state, int slot,
                              const ContactPlace& point) const noexcept;

  mechanics::Compliance compliance_;
  Capacity capacity_;
  mechanics::Relaxation relaxation_;
};

}  // namespace acus::tissue
