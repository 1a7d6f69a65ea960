// Displacements of the nodes that an image shows, by unit forces on the nodes that tools can reach.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

namespace acus::mechanics {

/// A matrix of floats in mm/N, column by column: one column per degree of freedom of a Compliance,
/// three rows (x, y, z of CT space, LPS) per visible node. What few forces do needs few columns.
///
/// Copies share the numbers, which never change. Reading takes no lock and allocates nothing.
class ImageBlock {
 public:
  /// Holds nothing: no node is visible.
  ImageBlock() = default;

  /// Wraps numbers of another owner, such as a mapped file, and keeps `owner` alive.
  /// @param nodes  Mesh node of each three rows, ascending.
  ImageBlock(std::vector<int> nodes, const float* values, std::shared_ptr<const void> owner);

  /// Keeps a copy of `matrix_mm_per_n`. @pre the matrix has 3 rows per node.
  static ImageBlock FromMatrix(std::vector<int> nodes,
                               const Eigen::Ref<const Eigen::MatrixXf>& matrix_mm_per_n);

  int num_nodes() const { return static_cast<int>(nodes_.size()); }
  std::span<const int> nodes() const { return nodes_; }

  /// 3 num_nodes() displacements by 1 N on a degree of freedom of the compliance.
  const float* Column(int dof) const noexcept {
    return values_ + static_cast<std::ptrdiff_t>(dof) * 3 * num_nodes();
  }

 private:
  std::vector<int> nodes_;
  const float* values_ = nullptr;
  std::shared_ptr<const void> owner_;
};

}  // namespace acus::mechanics
