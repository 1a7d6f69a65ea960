#include "acus/scene/effects/fluid/layer_normal.h"

#include <Eigen/Eigenvalues>

#include "acus/data/volume/label_lookup.h"

namespace acus::effects {
namespace {

constexpr int kLayerSteps = 6;
constexpr double kLayerStepMm = 1.0;
/// Largest ratio of the variances across and along a layer; it is 1 for tissue on all sides.
constexpr double kThinShare = 0.5;
constexpr int kLeastLayerPoints = 12;

}  // namespace

std::optional<Eigen::Vector3d> LayerNormal(const volume::LabelMap& labels,
                                           const Eigen::Affine3d& index_from_ct,
                                           const Eigen::Vector3d& place_in_ct_mm) noexcept {
  const volume::Label label = volume::LabelAt(labels, index_from_ct, place_in_ct_mm);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  int count = 0;
  for (int i = -kLayerSteps; i <= kLayerSteps; ++i) {
    for (int j = -kLayerSteps; j <= kLayerSteps; ++j) {
      for (int k = -kLayerSteps; k <= kLayerSteps; ++k) {
        if (i * i + j * j + k * k > kLayerSteps * kLayerSteps) continue;
        const Eigen::Vector3d offset_mm = kLayerStepMm * Eigen::Vector3d(i, j, k);
        if (volume::LabelAt(labels, index_from_ct, place_in_ct_mm + offset_mm) != label) continue;
        sum += offset_mm;
        squares += offset_mm * offset_mm.transpose();
        ++count;
      }
    }
  }
  if (count < kLeastLayerPoints) return std::nullopt;
  const Eigen::Vector3d mean = sum / count;
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes;
  axes.computeDirect(squares / count - mean * mean.transpose());
  if (!(axes.eigenvalues()[0] < kThinShare * axes.eigenvalues()[1])) return std::nullopt;
  return axes.eigenvectors().col(0).normalized();
}

}  // namespace acus::effects
