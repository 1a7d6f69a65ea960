// A tetrahedral mesh that can be cut, collapsed and flipped, with a material per tetrahedron.
#pragma once

#include <Eigen/Dense>
#include <array>
#include <cstdint>
#include <vector>

#include "acus/data/mesh/quality.h"

namespace acus::meshing {

/// Tetrahedra of all materials, also of 0 (outside), so that the body's surface is an interface
/// like any other. Numbers of nodes and tetrahedra stay valid while they live; Remove() frees a
/// number.
class TetraEditor {
 public:
  using Tetrahedron = std::array<int, 4>;  ///< Node numbers, positive volume.

  TetraEditor(const Eigen::Matrix3Xd& nodes_mm, const Eigen::Matrix4Xi& tetrahedra);

  int num_nodes() const { return static_cast<int>(nodes_.size()); }
  int num_slots() const { return static_cast<int>(tetrahedra_.size()); }  ///< Dead ones too.
  const Eigen::Vector3d& node(int n) const { return nodes_[n]; }
  void set_node(int n, const Eigen::Vector3d& x) { nodes_[n] = x; }
  bool is_alive(int t) const { return tetrahedra_[t][0] >= 0; }
  const Tetrahedron& tetrahedron(int t) const { return tetrahedra_[t]; }
  std::uint8_t material(int t) const { return material_[t]; }
  void set_material(int t, std::uint8_t material) { material_[t] = material; }
  const std::vector<int>& star(int n) const { return star_[n]; }  ///< Tetrahedra at node n.

  int AddNode(const Eigen::Vector3d& x);
  int Add(const Tetrahedron& corners, std::uint8_t material);
  void Remove(int t);

  mesh::Corners CornersOf(const Tetrahedron& corners) const;
  /// mesh::DihedralScore; outside the body any positive volume has the best score, 0.
  double Score(const Tetrahedron& corners, std::uint8_t material) const;
  double Score(int t) const { return Score(tetrahedra_[t], material_[t]); }
  double StarScore(int n) const;  ///< The least of the star.

  /// Tetrahedra with both nodes, in order of number.
  std::vector<int> AtEdge(int a, int b) const;
  /// The tetrahedron other than t at the face opposite corner c of t, or -1 on the hull.
  int Neighbour(int t, int c) const;
  bool Has(int t, int n) const;
  std::vector<int> NodesAround(int n) const;           ///< Joined to n by an edge; sorted.
  std::vector<std::uint8_t> MaterialsAt(int n) const;  ///< Of the star; sorted.

  /// Puts a node at x on the edge a-b and halves its tetrahedra. Returns the new node.
  int SplitEdge(int a, int b, const Eigen::Vector3d& x);

 private:
  std::vector<Eigen::Vector3d> nodes_;
  std::vector<Tetrahedron> tetrahedra_;  ///< First corner -1: dead.
  std::vector<std::uint8_t> material_;
  std::vector<std::vector<int>> star_;
  std::vector<int> free_;
};

}  // namespace acus::meshing
