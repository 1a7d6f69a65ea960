#include <algorithm>
#include <array>
#include <cmath>

#include "acus/base/core/parallel.h"
#include "acus/patient/segmentation/segmenters/supports.h"
#include "acus/patient/segmentation/segmenters/tissues.h"

namespace acus::segmentation {
namespace {

constexpr int kLowestTissueMedianHu = -200;  ///< A separate part below it is foam or cloth.
constexpr double kLeastCavityMm2 = 150.0;    ///< Smaller holes are found by filling alone.
constexpr double kLeastCavityMl = 60.0;      ///< Of lung; foam between back and table is less.
constexpr double kLeastBodyAround = 0.6;
constexpr double kMostUnseenAround = 0.4;
constexpr double kLeastAroundAtCut = 0.95;
constexpr double kThinWallMm = 12.0;
constexpr double kLimbRadiusMm = 12.0;  ///< Thinner parts beside the body are pads and boards.
constexpr std::size_t kSampleStep = 7;  ///< Medians of parts are taken of every 7th voxel.

/// Shares of what borders on a region in its slice.
struct Border {
  double body = 0.0;
  double unseen = 0.0;
};

Border BorderOf(const SliceRegion& region, const Mask& body, const Mask& unseen, int axis) {
  const volume::Geometry& g = body.geometry;
  const std::array<std::size_t, 3> stride = {1, static_cast<std::size_t>(g.size[0]),
                                             g.Index(0, 0, 1)};
  std::vector<std::size_t> inside = region.voxels;
  std::ranges::sort(inside);
  double all = 0.0;
  Border border;
  for (const std::size_t at : inside) {
    for (int d = 0; d < 3; ++d) {
      if (d == axis) continue;
      const std::size_t step = stride[static_cast<std::size_t>(d)];
      for (const std::size_t next : {at + step, at - step}) {
        if (next >= body.voxels.size() || std::ranges::binary_search(inside, next)) continue;
        ++all;
        if (unseen.voxels[next] != 0) {
          ++border.unseen;
        } else if (body.voxels[next] != 0) {
          ++border.body;
        }
      }
    }
  }
  if (all == 0.0) return {};
  return {border.body / all, border.unseen / all};
}

/// Lungs whose wall is thinner than the ball that opens the body, and lungs that the scanner's
/// field of view cuts: holes in a slice of body, tissue and what was not seen, that are denser than
/// the air around a patient and have mostly body around them.
void AddCavitiesBehindThinWalls(const volume::CtVolume& ct, const Mask& unseen, const Mask& solid,
                                const TissueOptions& options, int num_threads, Mask& body) {
  Mask walls = body;
  for (std::size_t i = 0; i < walls.voxels.size(); ++i) {
    walls.voxels[i] |= static_cast<std::uint8_t>(solid.voxels[i] | unseen.voxels[i]);
  }
  Mask filled = walls;
  const int axis = AxialAxis(ct.geometry);
  const double pixel_mm2 = ct.geometry.voxel_volume_mm3() / ct.geometry.spacing_mm[axis];
  FillInSlices(filled, axis, num_threads, [&](const SliceRegion& region) {
    const double area_mm2 = static_cast<double>(region.voxels.size()) * pixel_mm2;
    if (region.touches_border || area_mm2 < kLeastCavityMm2) return false;
    const Border border = BorderOf(region, body, unseen, axis);
    // Between body, table and the edge of the field there is foam; a lung has no table at it.
    const bool around = border.unseen == 0.0 ? border.body >= kLeastBodyAround
                                             : border.unseen <= kMostUnseenAround &&
                                                   border.body + border.unseen >= kLeastAroundAtCut;
    if (!around) return false;
    std::vector<std::int16_t> hu;
    for (const std::size_t at : region.voxels) hu.push_back(ct.voxels[at]);
    return MedianHu(hu) > options.gas_median_hu;
  });
  Mask cavity(ct.geometry);
  for (std::size_t i = 0; i < cavity.voxels.size(); ++i) {
    cavity.voxels[i] = filled.voxels[i] != 0 && walls.voxels[i] == 0 ? 1 : 0;
  }
  const Components parts = ConnectedComponents(cavity);
  const double ml = ct.geometry.voxel_volume_mm3() / 1000.0;
  cavity = Kept(parts, [&](std::int32_t n) {
    return static_cast<double>(parts.num_voxels[static_cast<std::size_t>(n)]) * ml > kLeastCavityMl;
  });
  if (Count(cavity) == 0) return;
  const Mask near = Dilated(cavity, kThinWallMm, num_threads);
  for (std::size_t i = 0; i < body.voxels.size(); ++i) {
    if (cavity.voxels[i] != 0 || (near.voxels[i] != 0 && solid.voxels[i] != 0)) body.voxels[i] = 1;
  }
}

/// Clears `kept` for parts into which no ball of kLimbRadiusMm fits: boards and pads, not limbs.
void KeepThick(const Components& parts, double opening_mm, int num_threads,
               std::vector<std::uint8_t>& kept) {
  if (std::ranges::count(kept, 1) == 0) return;
  const auto number = [&](std::size_t i) {
    return static_cast<std::size_t>(parts.number.voxels[i]);
  };
  Mask mask(parts.number.geometry);
  for (std::size_t i = 0; i < mask.voxels.size(); ++i) mask.voxels[i] = kept[number(i)];
  const Mask inner = Eroded(mask, std::max(kLimbRadiusMm - opening_mm, 0.0), num_threads);
  std::vector<std::uint8_t> thick(kept.size(), 0);
  for (std::size_t i = 0; i < inner.voxels.size(); ++i) {
    if (inner.voxels[i] != 0) thick[number(i)] = 1;
  }
  for (std::size_t n = 0; n < kept.size(); ++n) kept[n] = kept[n] & thick[n];
}

}  // namespace

int AxialAxis(const volume::Geometry& geometry) {
  Eigen::Index axis = 0;
  geometry.direction.row(2).cwiseAbs().maxCoeff(&axis);
  return static_cast<int>(axis);
}

Mask FindBody(const volume::CtVolume& ct, const Mask& unseen, const TissueOptions& options,
              int num_threads) {
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
  std::vector<std::uint8_t> is_tissue(parts.num_voxels.size(), 0);
  const std::vector<std::uint8_t> is_support =
      SupportsAmong(ct, parts, options.body_min_part_ml, AxialAxis(ct.geometry));
  for (std::size_t n = 1; n < is_tissue.size(); ++n) {
    is_tissue[n] =
        static_cast<std::int32_t>(n) != largest && is_support[n] == 0 &&
                static_cast<double>(parts.num_voxels[n]) * ml >= options.body_min_part_ml &&
                MedianHu(samples[n]) > kLowestTissueMedianHu
            ? 1
            : 0;
  }
  KeepThick(parts, opening_mm, num_threads, is_tissue);
  Mask body = Kept(parts, [&](std::int32_t n) {
    return n == largest || is_tissue[static_cast<std::size_t>(n)] != 0;
  });
  // A little farther than it was eroded, to win back what is thinner than the ball.
  body = Dilated(body, opening_mm + 2.0, num_threads);
  for (std::size_t i = 0; i < body.voxels.size(); ++i) body.voxels[i] &= solid.voxels[i];
  FillInSlices(body, AxialAxis(ct.geometry), num_threads);
  AddCavitiesBehindThinWalls(ct, unseen, solid, options, num_threads, body);
  return body;
}

}  // namespace acus::segmentation
