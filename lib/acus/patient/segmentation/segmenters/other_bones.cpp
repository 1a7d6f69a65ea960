#include "acus/patient/segmentation/segmenters/other_bones.h"

#include "acus/data/volume/labels.h"
#include "acus/patient/segmentation/voxels/mask.h"

namespace acus::segmentation {
namespace {

constexpr double kReachMm = 30.0;

}  // namespace

std::size_t DropOtherBones(const volume::LabelMap& import, volume::LabelMap& labels,
                           int num_threads) {
  ACUS_ASSERT(import.voxels.size() == labels.voxels.size());
  const volume::Label bone = volume::LabelOf("bone");
  Mask other(labels.geometry);
  Mask something(labels.geometry);
  for (std::size_t n = 0; n < other.voxels.size(); ++n) {
    other.voxels[n] = labels.voxels[n] == bone && import.voxels[n] != bone;
    something.voxels[n] = import.voxels[n] != 0;
  }
  if (Count(something) == 0 || Count(other) == 0) return 0;
  const volume::Grid<float> distance = DistanceMm(something, num_threads);
  const Components pieces = ConnectedComponents(other);
  std::vector<std::size_t> within(pieces.num_voxels.size(), 0);
  for (std::size_t n = 0; n < other.voxels.size(); ++n) {
    const auto piece = static_cast<std::size_t>(pieces.number.voxels[n]);
    if (piece > 0 && distance.voxels[n] <= static_cast<float>(kReachMm)) ++within[piece];
  }
  std::size_t dropped = 0;
  for (std::size_t n = 0; n < other.voxels.size(); ++n) {
    const auto piece = static_cast<std::size_t>(pieces.number.voxels[n]);
    if (piece == 0 || 2 * within[piece] < pieces.num_voxels[piece]) continue;
    labels.voxels[n] = volume::LabelOf("soft_tissue");
    ++dropped;
  }
  if (dropped > 0) labels.names[volume::LabelOf("soft_tissue")] = "soft_tissue";
  return dropped;
}

}  // namespace acus::segmentation
