// The compliance of boxes of elastic tissue, to test contact on.
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "acus/physics/mechanics/condensation/compliance.h"
#include "acus/physics/mechanics/condensation/condensation.h"
#include "acus/physics/mechanics/elements/stiffness.h"
#include "acus/physics/mechanics/sparse/sparse_factor.h"
#include "support/box_mesh.h"

namespace acus::testing_support {

/// Constants for the labels of a test.
inline mechanics::ElasticityTable ElasticLabels(
    const std::vector<std::pair<int, mechanics::ElasticTissue>>& rows) {
  mechanics::ElasticityTable table;
  table.file = "test";
  for (const auto& [label, tissue] : rows) {
    table.tissue[static_cast<std::size_t>(label)] = tissue;
    table.named.set(static_cast<std::size_t>(label));
  }
  return table;
}

/// One column per degree of freedom of the free nodes that `is_reachable` says yes to.
template <class IsReachable>
mechanics::Compliance ComplianceOf(
    const mesh::TetraMesh& mesh, const mechanics::ElasticityTable& table,
    mechanics::Storage storage, const IsReachable& is_reachable,
    mechanics::ElementKind element = mechanics::ElementKind::kLinear) {
  const mechanics::FreeNodes free = mechanics::FindFreeNodes(mesh);
  const mechanics::SparseFactor factor(mechanics::FreeStiffness(
      mechanics::AssembleStiffness(mesh, table, element, free.is_left_out), free));
  std::vector<int> nodes;
  std::vector<int> rows;
  for (std::size_t r = 0; r < free.mesh_node.size(); ++r) {
    if (!is_reachable(Eigen::Vector3d(mesh.nodes_mm.col(free.mesh_node[r])))) continue;
    nodes.push_back(free.mesh_node[r]);
    rows.push_back(static_cast<int>(r));
  }
  const Eigen::Index size = 3 * static_cast<Eigen::Index>(rows.size());
  Eigen::MatrixXd compliance(size, size);
  for (Eigen::Index c = 0; c < size; c += 3) {
    Eigen::MatrixXd load = Eigen::MatrixXd::Zero(free.num_dofs(), 3);
    load.middleRows<3>(3 * rows[static_cast<std::size_t>(c / 3)]).setIdentity();
    const Eigen::MatrixXd moved = factor.Solve(load);
    for (std::size_t r = 0; r < rows.size(); ++r) {
      compliance.block<3, 3>(3 * static_cast<Eigen::Index>(r), c) =
          moved.middleRows<3>(3 * rows[r]);
    }
  }
  const Eigen::MatrixXd symmetric = 0.5 * (compliance + compliance.transpose());
  return mechanics::Compliance::FromMatrix(nodes, symmetric, storage);
}

/// The same by condensation: for many nodes.
template <class IsReachable>
mechanics::Compliance CondensedOf(const mesh::TetraMesh& mesh,
                                  const mechanics::ElasticityTable& table,
                                  const IsReachable& is_reachable) {
  const mechanics::FreeNodes free = mechanics::FindFreeNodes(mesh);
  std::vector<int> nodes;
  for (const int node : free.mesh_node) {
    if (is_reachable(Eigen::Vector3d(mesh.nodes_mm.col(node)))) nodes.push_back(node);
  }
  const mechanics::Condensation condensation(mesh, free, table,
                                             mechanics::ElementKind::kAveragedDilatation, nodes,
                                             mechanics::kDefaultMemoryMib, RunContext{});
  return condensation.Compliance(mechanics::Storage::kDouble);
}

}  // namespace acus::testing_support
