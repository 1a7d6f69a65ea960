// The compliance of the nodes that a tool can reach: their displacements by unit forces on them.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

namespace acus::mechanics {

/// How the numbers are stored. Sums over them are always made in double.
enum class Storage { kFloat, kDouble };

/// A symmetric matrix of 3n x 3n values in mm/N, row by row: degree of freedom 3r + axis of row r
/// is the displacement of mesh node nodes()[r] along x, y or z of CT space (LPS).
///
/// Copies share the numbers, which never change. Reading takes no lock and allocates nothing.
class Compliance {
 public:
  Compliance() = default;

  /// Keeps `matrix_mm_per_n`, rounded to `storage`, in memory.
  /// @param nodes  Mesh node of each row, ascending.
  /// @pre the matrix has 3 rows and columns per node.
  static Compliance FromMatrix(std::vector<int> nodes,
                               const Eigen::Ref<const Eigen::MatrixXd>& matrix_mm_per_n,
                               Storage storage);

  /// Wraps numbers of another owner, such as a mapped file, and keeps `owner` alive.
  Compliance(std::vector<int> nodes, Storage storage, const void* values,
             std::shared_ptr<const void> owner);

  int num_nodes() const { return static_cast<int>(nodes_.size()); }
  std::span<const int> nodes() const { return nodes_; }
  Storage storage() const { return storage_; }

  /// Row of a mesh node, or -1 if it cannot be reached. O(log n).
  int RowOf(int mesh_node) const noexcept;

  /// 3 num_nodes() values of one degree of freedom. @pre T is what storage() says.
  template <class T>
  const T* Values(int dof) const noexcept {
    return static_cast<const T*>(values_) + static_cast<std::ptrdiff_t>(dof) * 3 * num_nodes();
  }

  /// Displacement of `dof_i` by a unit force on `dof_j`, mm/N. For single values; loops are better
  /// off with Values().
  double At(int dof_i, int dof_j) const noexcept {
    return storage_ == Storage::kFloat ? static_cast<double>(Values<float>(dof_i)[dof_j])
                                       : Values<double>(dof_i)[dof_j];
  }

 private:
  std::vector<int> nodes_;
  Storage storage_ = Storage::kDouble;
  const void* values_ = nullptr;
  std::shared_ptr<const void> owner_;
};

}  // namespace acus::mechanics
