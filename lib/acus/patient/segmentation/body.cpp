#include <algorithm>
#include <cmath>

#include "acus/base/core/parallel.h"
#include "acus/patient/segmentation/tissues.h"

namespace acus::segmentation {
namespace {

constexpr int kLowestTissueMedianHu = -200;  ///< A separate part below it is foam or cloth.
constexpr std::size_t kSampleStep = 7;       ///< Medians of parts are taken of every 7th voxel.

}  // namespace

int AxialAxis(const volume::Geometry& geometry) {
  Eigen::Index axis = 0;
  geometry.direction.row(2).cwiseAbs().maxCoeff(&axis);
  return static_cast<int>(axis);
}

Mask FindBody(const volume::CtVolume& ct, const TissueOptions& options, int num_threads) {
  Mask solid(ct.geometry);
  for (std::size_t i = 0; i < ct.voxels.size(); ++i) {
    solid.voxels[i] = ct.voxels[i] > options.body_threshold_hu ? 1 : 0;
  }
  const double opening_mm =
      std::max(options.body_opening_mm, 1.01 * ct.geometry.spacing_mm.minCoeff());
  const Components parts = ConnectedComponents(Eroded(solid, opening_mm, num_threads));
  ACUS_REQUIRE(parts.num_voxels.size() > 1, "the CT holds nothing thicker than ", 2.0 * opening_mm,
               " mm and denser than ", options.body_threshold_hu, " HU: there is no body in it");
  std::vector<std::vector<std::int16_t>> samples(parts.num_voxels.size());
  for (std::size_t i = 0; i < ct.voxels.size(); i += kSampleStep) {
    const std::int32_t number = parts.number.voxels[i];
    if (number != 0) samples[static_cast<std::size_t>(number)].push_back(ct.voxels[i]);
  }
  const auto largest = static_cast<std::int32_t>(std::ranges::max_element(parts.num_voxels) -
                                                 parts.num_voxels.begin());
  const double ml = ct.geometry.voxel_volume_mm3() / 1000.0;
  Mask body = Kept(parts, [&](std::int32_t n) {
    const auto at = static_cast<std::size_t>(n);
    if (n == largest) return true;
    return static_cast<double>(parts.num_voxels[at]) * ml >= options.body_min_part_ml &&
           MedianHu(samples[at]) > kLowestTissueMedianHu;
  });
  // A little further than it was eroded, to win back what is thinner than the ball.
  body = Dilated(body, opening_mm + 2.0, num_threads);
  for (std::size_t i = 0; i < body.voxels.size(); ++i) body.voxels[i] &= solid.voxels[i];
  FillInSlices(body, AxialAxis(ct.geometry), num_threads);
  return body;
}

}  // namespace acus::segmentation
