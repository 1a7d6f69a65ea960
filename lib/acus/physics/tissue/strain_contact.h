// Contact with tissue that stiffens: a region of finite strain around the needle inside the linear
// condensed body. Equations and limits: docs/models/tissue_finite_strain.md.
//
// The linear body moves as the other one if forces g act on the region's nodes, with
//   g = f_linear(u) - f_law(u),   u = C (f_tools(g) + g),
// where the tools' forces solve the same contact problem as ever, for demands less C g. So factors
// of the contact stay as they are. The equations for g are solved by a multi-secant method
// (Anderson 1965, J. ACM 12(4):547-560; Fang and Saad 2009, Numer. Linear Algebra Appl.
// 16(3):197-221) with the compliance as the metric, a few iterations in every step, each from what
// the last step left.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "acus/data/mesh/tetra_mesh.h"
#include "acus/physics/mechanics/elements/strain_region.h"
#include "acus/physics/tissue/contact_system.h"

namespace acus::tissue {

struct StrainSettings {
  mechanics::ElementKind element = mechanics::ElementKind::kAveragedDilatation;
  mechanics::Capsule corridor{};  ///< The needle's way; patches within its radius may stiffen.
  static constexpr int kMostNodes = 400;
  int max_nodes = 160;         ///< Of the region, nearest to the corridor first; 4 to kMostNodes.
  int iterations = 3;          ///< At most, per step; 1 to 50.
  double tolerance_mm = 1e-5;  ///< Done when displacements are out by no more; > 0.
};

/// All that the method remembers. A plain value: a copy continues with the same bits. Made by
/// StrainContact::NewState().
struct StrainState {
  /// A place in the iteration; 3 values per node of the region.
  struct Iterate {
    std::vector<double> force_n;      ///< g.
    std::vector<double> moved_mm;     ///< C g.
    std::vector<double> residual_n;   ///< f_linear(u) - f_law(u) - g.
    std::vector<double> residual_mm;  ///< C times it.
    double error2 = 0.0;              ///< Product of the two, N mm.
  };
  static constexpr int kMostSecants = 6;
  Iterate best, next;
  std::vector<Iterate> secants;  ///< Differences of iterates at equal demands.
  int num_secants = 0;
  int oldest = 0;
  double mixing = 0.5;

  std::int64_t num_unsettled = 0;  ///< Steps that ended above the tolerance.
  std::int64_t num_fresh = 0;      ///< Times that starting again was better.
  double error_mm = 0.0;           ///< Of the last step: largest residual_mm.

  // Work space.
  Eigen::Matrix3Xd u_mm, target_n;
  mechanics::StrainRegion::Scratch scratch;
  std::vector<double> lateral_mm, demand_mm;
  std::vector<double> tool_n;
  std::vector<int> loaded;
};

/// Const after construction: any number of states may step side by side.
class StrainContact {
 public:
  /// @throws InputError if a setting is out of range or no patch is in reach of the corridor.
  StrainContact(const mesh::TetraMesh& mesh, const mechanics::ElasticityTable& table,
                const mechanics::Compliance& compliance, const StrainSettings& settings);

  StrainState NewState() const;

  /// In place of ContactSystem::Solve: forces for the demands in `contact`, which keep their
  /// values. Allocates nothing.
  void Solve(const ContactSystem& system, ContactState& contact, StrainState& state) const noexcept;

  /// As if no tool had touched.
  void Forget(StrainState& state) const noexcept;

  /// Displacement of a place by the region's own forces g, CT axes, mm: what the contact does not
  /// see of its displacement.
  Eigen::Vector3d MovedMm(const StrainState& state, const ContactPlace& place) const noexcept;

  /// g of a node of the region, CT axes, N: with the tools' forces, what moves the linear body.
  Eigen::Vector3d ForceN(const StrainState& state, int node) const noexcept {
    return Eigen::Map<const Eigen::Vector3d>(state.best.force_n.data() + 3 * node);
  }
  const Eigen::Vector3d& NodeMm(int node) const {
    return (*node_mm_)[static_cast<std::size_t>(node)];
  }

  const mechanics::StrainRegion& region() const { return *region_; }

 private:
  void Evaluate(const ContactSystem& system, ContactState& contact, StrainState& state,
                StrainState::Iterate& at) const noexcept;
  void SolveTools(const ContactSystem& system, ContactState& contact, StrainState& state,
                  const StrainState::Iterate& at) const noexcept;
  void Advance(StrainState& state) const noexcept;
  void Remember(StrainState& state) const noexcept;
  void Shorten(StrainState& state) const noexcept;
  bool Judge(StrainState& state) const noexcept;
  void TryAnew(const ContactSystem& system, ContactState& contact,
               StrainState& state) const noexcept;
  void AddMoved(int row, const double* force_n, double* moved_mm) const noexcept;
  Eigen::Vector3d NodeMovedMm(const StrainState::Iterate& at, int row) const noexcept;
  Eigen::Vector3d PlaceMovedMm(const StrainState::Iterate& at,
                               const ContactPlace& place) const noexcept;

  StrainSettings settings_;
  std::shared_ptr<const mechanics::StrainRegion> region_;
  std::shared_ptr<const std::vector<Eigen::Vector3d>> node_mm_;  ///< At rest, CT space.
  int size_ = 0;                                                 ///< 3 nodes of the region.
  int stride_ = 0;                                               ///< Of a row of columns_.
  int num_dofs_ = 0;                                             ///< Of the compliance.
  std::shared_ptr<const std::vector<float>>
      columns_;  ///< num_dofs_ rows: what a force on that dof does to the region.
};

}  // namespace acus::tissue
