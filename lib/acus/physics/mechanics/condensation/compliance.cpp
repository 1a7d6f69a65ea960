#include "acus/physics/mechanics/condensation/compliance.h"

#include <algorithm>
#include <utility>

#include "acus/base/core/error.h"

namespace acus::mechanics {
namespace {

template <class T>
std::shared_ptr<const void> CopyOf(const Eigen::Ref<const Eigen::MatrixXd>& matrix) {
  auto values = std::make_shared<std::vector<T>>(static_cast<std::size_t>(matrix.size()));
  Eigen::Map<Eigen::Matrix<T, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
      values->data(), matrix.rows(), matrix.cols()) = matrix.cast<T>();
  return {values, values->data()};
}

}  // namespace

Compliance::Compliance(std::vector<int> nodes, Storage storage, const void* values,
                       std::shared_ptr<const void> owner)
    : nodes_(std::move(nodes)), storage_(storage), values_(values), owner_(std::move(owner)) {
  ACUS_ASSERT(std::ranges::is_sorted(nodes_));
}

Compliance Compliance::FromMatrix(std::vector<int> nodes,
                                  const Eigen::Ref<const Eigen::MatrixXd>& matrix_mm_per_n,
                                  Storage storage) {
  ACUS_ASSERT(matrix_mm_per_n.rows() == static_cast<Eigen::Index>(3 * nodes.size()));
  ACUS_ASSERT(matrix_mm_per_n.rows() == matrix_mm_per_n.cols());
  auto values =
      storage == Storage::kFloat ? CopyOf<float>(matrix_mm_per_n) : CopyOf<double>(matrix_mm_per_n);
  const void* first = values.get();
  return {std::move(nodes), storage, first, std::move(values)};
}

int Compliance::RowOf(int mesh_node) const noexcept {
  const auto found = std::ranges::lower_bound(nodes_, mesh_node);
  if (found == nodes_.end() || *found != mesh_node) return -1;
  return static_cast<int>(found - nodes_.begin());
}

}  // namespace acus::mechanics
