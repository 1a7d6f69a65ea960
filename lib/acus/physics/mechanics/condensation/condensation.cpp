#include "acus/physics/mechanics/condensation/condensation.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "acus/base/core/cpu_time.h"
#include "acus/physics/mechanics/condensation/condensed_factor.h"
#include "acus/physics/mechanics/sparse/back_substitution.h"

namespace acus::mechanics {
namespace {

/// Rows of the stiffness matrix of free nodes.
std::vector<int> RowsOf(std::span<const int> mesh_nodes, const std::vector<int>& row_of_node) {
  std::vector<int> rows;
  rows.reserve(mesh_nodes.size());
  for (const int node : mesh_nodes) {
    ACUS_REQUIRE(node >= 0 && node < static_cast<int>(row_of_node.size()), "node ", node,
                 " is not one of the mesh's ", row_of_node.size());
    const int row = row_of_node[static_cast<std::size_t>(node)];
    ACUS_REQUIRE(row >= 0, "node ", node, " is held in place, so that no tool can move it");
    rows.push_back(row);
  }
  return rows;
}

Eigen::SparseMatrix<double> Stiffness(const mesh::TetraMesh& mesh, const FreeNodes& free,
                                      const ElasticityTable& elasticity, ElementKind element) {
  return FreeStiffness(AssembleStiffness(mesh, elasticity, element, free.is_left_out), free);
}

}  // namespace

struct Condensation::Impl {
  std::vector<int> row_of_node;
  CondensedFactor factor;
  std::optional<BackSubstitution> visible;
};

Condensation::Condensation(const mesh::TetraMesh& mesh, const FreeNodes& free,
                           const ElasticityTable& elasticity, ElementKind element,
                           std::vector<int> reachable, double max_memory_mib,
                           const RunContext& context)
    : nodes_(std::move(reachable)) {
  ACUS_REQUIRE(!nodes_.empty(), "there is no node to condense to; choose a corridor in the body");
  ACUS_ASSERT(std::ranges::is_sorted(nodes_));
  const std::vector<int> last = RowsOf(nodes_, free.row_of_node);
  context.Checkpoint("assembling the stiffness", 0.0);
  const double begin_s = ThreadCpuSeconds();
  Eigen::SparseMatrix<double> stiffness = Stiffness(mesh, free, elasticity, element);
  const double assembled_s = ThreadCpuSeconds();
  CondensedFactor factor(std::move(stiffness), last, max_memory_mib, context);
  cost_ = {assembled_s - begin_s, ThreadCpuSeconds() - assembled_s,
           factor.num_values() * sizeof(double) / (1024.0 * 1024.0)};
  impl_.reset(new Impl{free.row_of_node, std::move(factor), std::nullopt});
}

Condensation::~Condensation() = default;
Condensation::Condensation(Condensation&&) noexcept = default;
Condensation& Condensation::operator=(Condensation&&) noexcept = default;

std::span<const double> Condensation::ColumnMmPerN(int dof) const {
  const auto matrix = impl_->factor.ComplianceMmPerN();
  return {matrix.col(dof).data(), static_cast<std::size_t>(matrix.rows())};
}

Compliance Condensation::Compliance(Storage storage) const {
  return Compliance::FromMatrix(nodes_, impl_->factor.ComplianceMmPerN(), storage);
}

void Condensation::SetVisible(std::span<const int> mesh_nodes) {
  impl_->visible.emplace(impl_->factor, RowsOf(mesh_nodes, impl_->row_of_node));
}

void Condensation::ImageColumns(int first, int count, float* out) {
  ACUS_ASSERT(impl_->visible.has_value());
  impl_->visible->Columns(first, count, out);
}

}  // namespace acus::mechanics
