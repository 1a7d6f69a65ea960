// A bendable needle: an inextensible, unshearable elastic rod at rest under what acts on it.
//
// The rod is cut into elements of equal length and constant curvature and twist; these strains are
// the unknowns, so that its length is exact and any rotation is, however large. Solve minimises
//   E(u) = sum_i h/2 (u_i - u0)^T B (u_i - u0) + tissue springs - work of the loads,
// B = diag(EI, EI, GJ), by Newton's method. The Newton system couples all strains through the
// positions; a sweep from tip to base with 6 x 6 blocks (the Riccati recursion of the linear
// quadratic control problem, i.e. block elimination of the state form) solves it in O(nodes).
// See docs/models/needle_rod.md.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "acus/physics/needle/arc.h"

namespace acus::needle {

struct RodProperties {
  double length_mm = 0.0;
  double bending_n_mm2 = 0.0;  ///< E I, the same in all directions.
  double twist_n_mm2 = 0.0;    ///< G J
  /// Curvature (x, y) and twist (z) without load, in the rod's own frame, 1/mm.
  Eigen::Vector3d rest_curvature_per_mm = Eigen::Vector3d::Zero();
};

struct RodOptions {
  int num_nodes = 25;          ///< >= 2; elements are one fewer.
  int max_contacts = 0;        ///< Contacts and loads together; 0: 2 num_nodes + 8.
  double tolerance_mm = 1e-3;  ///< What the unbalanced moments may still move the free tip by.
  int max_iterations = 20;     ///< Newton steps in one Solve.
};

/// A spring from the needle at `arc_mm` from its base to a point in the tissue.
struct RodContact {
  double arc_mm = 0.0;  ///< In [0, length]; values beyond are taken as the end.
  Eigen::Vector3d anchor_mm = Eigen::Vector3d::Zero();
  /// The spring does not act along it (the channel lets the shaft slide); any length. Zero: acts
  /// in 3D.
  Eigen::Vector3d free_axis = Eigen::Vector3d::Zero();
  double stiffness_n_per_mm = 0.0;  ///< >= 0
};

/// A force that keeps its direction.
struct RodLoad {
  double arc_mm = 0.0;
  Eigen::Vector3d force_n = Eigen::Vector3d::Zero();
};

/// How the hub is held. The rod's frame has +z along the needle, to the tip.
struct RodBase {
  Eigen::Vector3d position_mm = Eigen::Vector3d::Zero();
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();  ///< Any length > 0.
  /// False: clamped. True: springs draw the hub's position and orientation to those above.
  bool sprung = false;
  double stiffness_n_per_mm = 0.0;      ///< > 0 if sprung
  double stiffness_n_mm_per_rad = 0.0;  ///< > 0 if sprung
};

struct RodInput {
  RodBase base;
  std::span<const RodContact> contacts;  ///< Any order; the order does not change a bit.
  std::span<const RodLoad> loads;
};

enum class RodStatus : std::uint8_t {
  kConverged,
  kIterationLimit,  ///< The best shape so far; the next call continues from it.
  kStalled,         ///< No step lowers the energy further, though moments are not balanced.
  kRejected,        ///< An input is not finite, negative, beyond 100 m, 1e9 N/mm or 1e6 N, or too
                    ///< many: nothing was changed.
};
std::string_view NameOf(RodStatus status) noexcept;

struct RodResult {
  RodStatus status = RodStatus::kConverged;
  int iterations = 0;
  double energy_n_mm = 0.0;  ///< E: elastic energy of needle and springs less the loads' work.
  double moment_residual_n_mm = 0.0;  ///< Largest unbalanced moment of an element.
  Eigen::Vector3d base_force_n = Eigen::Vector3d::Zero();      ///< On the hand.
  Eigen::Vector3d base_torque_n_mm = Eigen::Vector3d::Zero();  ///< On the hand, about the base.
  bool converged() const { return status == RodStatus::kConverged; }
};

/// A node and the element from it to the next one.
struct RodPoint {
  Eigen::Vector3d position_mm = Eigen::Vector3d::Zero();
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d curvature_per_mm = Eigen::Vector3d::Zero();  ///< u of the element, in its frame.
  Eigen::Vector3d tangent = Eigen::Vector3d::UnitZ();
  Eigen::Vector3d chord_mm = Eigen::Vector3d::Zero();
  ArcTerms arc;
};

/// What acts at a place inside an element, with the place's position for one shape.
struct RodAction {
  double arc_mm = 0.0;
  int element = 0;
  double stiffness_n_per_mm = 0.0;
  Eigen::Vector3d anchor_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d free_axis = Eigen::Vector3d::Zero();
  Eigen::Vector3d load_n = Eigen::Vector3d::Zero();

  ArcTerms part;  ///< Of the element, from its start to the place.
  Eigen::Vector3d chord_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d gradient_n = Eigen::Vector3d::Zero();  ///< dE / d(place); minus force on the rod.
};

/// Terms of one Newton step, for each element.
struct RodSweep {
  Eigen::Vector3d force_n = Eigen::Vector3d::Zero();      ///< dE / d(position of the element's end)
  Eigen::Vector3d moment_n_mm = Eigen::Vector3d::Zero();  ///< dE / d(rotation of the element's end)
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();     ///< dE / d(curvature), N mm^2
  Eigen::Vector3d step_per_mm = Eigen::Vector3d::Zero();
  Eigen::Matrix3d by_position = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d by_rotation = Eigen::Matrix3d::Zero();
};

/// A value: copy it to save, assign it to restore; the same calls then give the same bits.
struct RodState {
  std::vector<RodPoint> point;  ///< The shape, base first; the last one has no element.
  bool started = false;
  Eigen::Vector3d target_mm = Eigen::Vector3d::Zero();  ///< Of the hub, in the last call.
  Eigen::Quaterniond target_orientation = Eigen::Quaterniond::Identity();
  RodResult last;

  std::int64_t num_rejected = 0;
  std::int64_t num_not_converged = 0;
  std::int64_t num_repaired = 0;  ///< Newton steps whose matrix had to be made positive definite.
  std::int64_t num_restarts = 0;  ///< Shapes given up for the straight needle after a jump.

  // Working space: no meaning between calls.
  std::vector<RodPoint> trial;
  std::vector<RodAction> action, trial_action;
  std::vector<RodSweep> sweep;
  int num_actions = 0;
};

/// Const after construction: any number of states may be solved side by side.
class RodModel {
 public:
  /// @throws InputError if a length or stiffness is not positive, or there are under 2 nodes.
  RodModel(const RodProperties& properties, const RodOptions& options);

  RodState NewState() const;

  /// The shape at rest, from the last shape. Allocates nothing. The energy never rises from one
  /// call to the next with the same input; with a converged state nothing changes at all.
  RodResult Solve(RodState& state, const RodInput& input) const noexcept;

  /// Position and unit tangent of the needle at `arc_mm` from its base.
  Eigen::Vector3d PositionMm(const RodState& state, double arc_mm) const noexcept;
  Eigen::Vector3d Tangent(const RodState& state, double arc_mm) const noexcept;

  const RodProperties& properties() const { return properties_; }
  const RodOptions& options() const { return options_; }
  int num_elements() const { return options_.num_nodes - 1; }
  double spacing_mm() const { return spacing_mm_; }
  int max_actions() const { return options_.max_contacts; }
  /// Moments below this are balanced: 2 EI tolerance / L^2.
  double moment_tolerance_n_mm() const { return moment_tolerance_n_mm_; }

 private:
  RodProperties properties_;
  RodOptions options_;
  double spacing_mm_ = 0.0;
  double moment_tolerance_n_mm_ = 0.0;
};

}  // namespace acus::needle
