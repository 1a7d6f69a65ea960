// From a mesh with a hundred thousand unknowns to the compliance of the nodes that tools can reach.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "acus/base/core/run_context.h"
#include "acus/data/mesh/tetra_mesh.h"
#include "acus/physics/mechanics/condensation/compliance.h"
#include "acus/physics/mechanics/elements/elasticity_table.h"
#include "acus/physics/mechanics/elements/stiffness.h"
#include "acus/physics/mechanics/elements/supported_nodes.h"

namespace acus::mechanics {

/// What it took. CPU time of one thread.
struct CondensationCost {
  double assemble_s = 0.0;
  double factor_s = 0.0;  ///< Ordering, factorisation and inversion of the last block.
  double factor_mib = 0.0;
};

inline constexpr double kDefaultMemoryMib = 12000.0;

/// The stiffness matrix of the free nodes is factored once, with the reachable ones last; the
/// inverse of the factor's last block is their compliance, exact except for rounding.
/// Method, times and memory: docs/models/tissue_condensation.md.
class Condensation {
 public:
  /// @param free  Of the same mesh.
  /// @param reachable  Mesh nodes that are free, ascending, each once, at least one.
  /// @param max_memory_mib  What the factor may take.
  /// @throws InputError if a node of `reachable` is not free, or as AssembleStiffness.
  /// @throws NoAnswerError if the factor takes more memory, or the stiffness is not positive
  ///     definite.
  Condensation(const mesh::TetraMesh& mesh, const FreeNodes& free,
               const ElasticityTable& elasticity, ElementKind element, std::vector<int> reachable,
               double max_memory_mib, const RunContext& context);
  ~Condensation();
  Condensation(Condensation&&) noexcept;
  Condensation& operator=(Condensation&&) noexcept;

  /// Mesh node of each row, ascending.
  std::span<const int> nodes() const { return nodes_; }

  /// 3 nodes().size() displacements, mm, by 1 N on a degree of freedom of the compliance.
  std::span<const double> ColumnMmPerN(int dof) const;

  /// A copy that does not need this object.
  mechanics::Compliance Compliance(Storage storage) const;

  /// Chooses for which mesh nodes ImageColumns gives displacements. @pre they are free.
  void SetVisible(std::span<const int> mesh_nodes);

  /// Displacements, mm, of the visible nodes (x, y, z of each) by 1 N on degrees of freedom first
  /// .. first + count of the compliance, one column after the other. About 100 at a time are best.
  void ImageColumns(int first, int count, float* out);

  const CondensationCost& cost() const { return cost_; }

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
  std::vector<int> nodes_;
  CondensationCost cost_;
};

}  // namespace acus::mechanics
