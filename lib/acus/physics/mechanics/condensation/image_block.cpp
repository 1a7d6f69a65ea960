#include "acus/physics/mechanics/condensation/image_block.h"

#include <algorithm>
#include <utility>

#include "acus/base/core/error.h"

namespace acus::mechanics {

ImageBlock::ImageBlock(std::vector<int> nodes, const float* values,
                       std::shared_ptr<const void> owner)
    : nodes_(std::move(nodes)), values_(values), owner_(std::move(owner)) {
  ACUS_ASSERT(std::ranges::is_sorted(nodes_));
}

ImageBlock ImageBlock::FromMatrix(std::vector<int> nodes,
                                  const Eigen::Ref<const Eigen::MatrixXf>& matrix_mm_per_n) {
  ACUS_ASSERT(matrix_mm_per_n.rows() == static_cast<Eigen::Index>(3 * nodes.size()));
  const auto values = std::make_shared<const Eigen::MatrixXf>(matrix_mm_per_n);
  return {std::move(nodes), values->data(), values};
}

}  // namespace acus::mechanics
