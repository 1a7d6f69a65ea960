// First, so that ITK's headers find this Eigen's include guards and do not mix in their own copy.
#include "acus/patient/segmentation/segmenters/organs.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <itkConnectedThresholdImageFilter.h>
#include <itkImportImageFilter.h>
#include <itkMedianImageFilter.h>
#include <itkThresholdSegmentationLevelSetImageFilter.h>

#include "acus/patient/segmentation/voxels/crop.h"

namespace acus::segmentation {
namespace {

using HuImage = itk::Image<std::int16_t, 3>;
using FloatImage = itk::Image<float, 3>;
using ByteImage = itk::Image<std::uint8_t, 3>;

constexpr double kSeedBallMm = 4.0;           ///< Where a level set begins.
constexpr double kLevelSetRmsChange = 0.005;  ///< Stops earlier than at its last iteration.

/// An ITK image on the memory of a grid; index space with spacing, no rotation.
template <typename Image, typename Scalar>
typename Image::Pointer ItkView(volume::Grid<Scalar>& grid) {
  const auto import = itk::ImportImageFilter<Scalar, 3>::New();
  typename Image::RegionType region;
  typename Image::SpacingType spacing;
  for (unsigned d = 0; d < 3; ++d) {
    region.SetSize(d, static_cast<itk::SizeValueType>(grid.geometry.size[d]));
    spacing[d] = grid.geometry.spacing_mm[d];
  }
  import->SetRegion(region);
  import->SetSpacing(spacing);
  import->SetImportPointer(grid.voxels.data(), grid.voxels.size(),
                           /*LetImageContainerManageMemory=*/false);
  import->Update();
  typename Image::Pointer image = import->GetOutput();
  image->DisconnectPipeline();
  return image;
}

std::vector<Eigen::Array3i> SeedVoxels(const volume::CtVolume& ct, const OrganSeed& organ) {
  std::vector<Eigen::Array3i> voxels;
  for (const Eigen::Vector3d& point : organ.points_mm) {
    const Eigen::Vector3d at = ct.geometry.index_from_ct() * point;
    const Eigen::Array3i voxel = at.array().round().cast<int>();
    ACUS_REQUIRE(ct.geometry.Contains(voxel[0], voxel[1], voxel[2]), organ.tissue, ": the seed ",
                 point.transpose(),
                 " mm is outside the CT; seeds are in patient coordinates (LPS)");
    voxels.push_back(voxel);
  }
  return voxels;
}

Box BoxAround(const std::vector<Eigen::Array3i>& voxels, const volume::Geometry& g,
              double radius_mm) {
  const Eigen::Array3i reach = (radius_mm / g.spacing_mm).ceil().cast<int>();
  Box box{voxels.front(), voxels.front()};
  for (const auto& voxel : voxels) {
    box.low = box.low.min(voxel);
    box.high = box.high.max(voxel);
  }
  box.low = (box.low - reach).max(0);
  box.high = (box.high + reach).min(g.size - 1);
  return box;
}

/// Distance [mm] of each voxel centre to the nearest seed.
volume::Grid<float> SeedDistanceMm(const volume::Geometry& g, const OrganSeed& organ) {
  volume::Grid<float> distance(g);
  const Eigen::Affine3d ct_from_index = g.ct_from_index();
  for (int k = 0; k < g.size[2]; ++k) {
    for (int j = 0; j < g.size[1]; ++j) {
      for (int i = 0; i < g.size[0]; ++i) {
        const Eigen::Vector3d at = ct_from_index * Eigen::Vector3d(i, j, k);
        double nearest = 1e9;
        for (const auto& point : organ.points_mm) nearest = std::min(nearest, (at - point).norm());
        distance.At(i, j, k) = static_cast<float>(nearest);
      }
    }
  }
  return distance;
}

volume::CtVolume MedianFiltered(volume::CtVolume& ct) {
  const auto median = itk::MedianImageFilter<HuImage, HuImage>::New();
  median->SetInput(ItkView<HuImage>(ct));
  median->SetRadius(1);
  median->SetNumberOfWorkUnits(1);
  median->Update();
  volume::CtVolume out(ct.geometry);
  std::copy_n(median->GetOutput()->GetBufferPointer(), out.voxels.size(), out.voxels.begin());
  return out;
}

Mask RegionGrown(volume::CtVolume& ct, const std::vector<Eigen::Array3i>& seeds,
                 const OrganSeed& organ) {
  const auto grow = itk::ConnectedThresholdImageFilter<HuImage, ByteImage>::New();
  grow->SetInput(ItkView<HuImage>(ct));
  grow->SetLower(static_cast<std::int16_t>(organ.lower_hu));
  grow->SetUpper(static_cast<std::int16_t>(organ.upper_hu));
  grow->SetReplaceValue(1);
  grow->SetNumberOfWorkUnits(1);
  for (const auto& seed : seeds) grow->AddSeed({{seed[0], seed[1], seed[2]}});
  grow->Update();
  Mask mask(ct.geometry);
  std::copy_n(grow->GetOutput()->GetBufferPointer(), mask.voxels.size(), mask.voxels.begin());
  return mask;
}

Mask LevelSetGrown(volume::CtVolume& ct, const volume::Grid<float>& seed_distance_mm,
                   const OrganSeed& organ) {
  volume::Grid<float> start = seed_distance_mm;
  volume::Grid<float> feature(ct.geometry);
  for (std::size_t i = 0; i < start.voxels.size(); ++i) {
    start.voxels[i] -= static_cast<float>(kSeedBallMm);
    feature.voxels[i] = ct.voxels[i];
  }
  using Filter = itk::ThresholdSegmentationLevelSetImageFilter<FloatImage, FloatImage>;
  const auto filter = Filter::New();
  filter->SetInput(ItkView<FloatImage>(start));
  filter->SetFeatureImage(ItkView<FloatImage>(feature));
  filter->SetLowerThreshold(static_cast<float>(organ.lower_hu));
  filter->SetUpperThreshold(static_cast<float>(organ.upper_hu));
  filter->SetPropagationScaling(1.0);
  filter->SetCurvatureScaling(static_cast<float>(organ.curvature_weight));
  filter->SetEdgeWeight(0.0);
  filter->SetIsoSurfaceValue(0.0);
  filter->SetMaximumRMSError(kLevelSetRmsChange);
  filter->SetNumberOfIterations(static_cast<unsigned>(organ.iterations));
  filter->SetNumberOfWorkUnits(1);
  filter->Update();
  Mask mask(ct.geometry);
  const float* level = filter->GetOutput()->GetBufferPointer();
  for (std::size_t i = 0; i < mask.voxels.size(); ++i) mask.voxels[i] = level[i] <= 0.0F ? 1 : 0;
  return mask;
}

/// Only the parts that hold a seed, or failing that the largest.
Mask PartsWithSeeds(const Mask& mask, const std::vector<Eigen::Array3i>& seeds) {
  const Components parts = ConnectedComponents(mask);
  std::vector<std::uint8_t> keep(parts.num_voxels.size(), 0);
  bool any = false;
  for (const auto& seed : seeds) {
    const std::int32_t n = parts.number.At(seed[0], seed[1], seed[2]);
    if (n != 0) keep[static_cast<std::size_t>(n)] = 1;
    any |= n != 0;
  }
  if (!any)
    keep[static_cast<std::size_t>(std::ranges::max_element(parts.num_voxels) -
                                  parts.num_voxels.begin())] = 1;
  return Kept(parts, [&](std::int32_t n) { return keep[static_cast<std::size_t>(n)] != 0; });
}

void RequireSeedsInRange(const volume::CtVolume& ct, const std::vector<Eigen::Array3i>& seeds,
                         const OrganSeed& organ) {
  for (std::size_t s = 0; s < seeds.size(); ++s) {
    const double hu = ct.At(seeds[s][0], seeds[s][1], seeds[s][2]);
    ACUS_REQUIRE(hu >= organ.lower_hu && hu <= organ.upper_hu, organ.tissue, ": the CT is ", hu,
                 " HU at the seed ", organ.points_mm[s].transpose(), " mm, outside the range ",
                 organ.lower_hu, " to ", organ.upper_hu, "; move the seed or widen the range");
  }
}

}  // namespace

Mask FindOrgan(const volume::CtVolume& ct, const OrganSeed& organ, const RunContext& context) {
  ACUS_REQUIRE(!organ.points_mm.empty(), organ.tissue, ": needs at least one seed point");
  ACUS_REQUIRE(organ.lower_hu < organ.upper_hu, organ.tissue, ": lower_hu ", organ.lower_hu,
               " must be below upper_hu ", organ.upper_hu);
  auto seeds = SeedVoxels(ct, organ);
  const Box box = BoxAround(seeds, ct.geometry, organ.radius_mm);
  for (auto& seed : seeds) seed -= box.low;
  volume::CtVolume part = Cropped(ct, box);
  part = MedianFiltered(part);
  RequireSeedsInRange(part, seeds, organ);
  const volume::Grid<float> distance = SeedDistanceMm(part.geometry, organ);
  Mask mask;
  try {
    mask = organ.method == OrganSeed::Method::kRegionGrowing ? RegionGrown(part, seeds, organ)
                                                             : LevelSetGrown(part, distance, organ);
  } catch (const itk::ExceptionObject& error) {
    throw NoAnswerError(
        Message(organ.tissue, ": the segmentation failed: ", error.GetDescription()));
  }
  for (std::size_t i = 0; i < mask.voxels.size(); ++i) {
    if (distance.voxels[i] > organ.radius_mm) mask.voxels[i] = 0;
  }
  if (organ.smoothing_mm > 0.0) {
    mask = PartsWithSeeds(Opened(mask, organ.smoothing_mm, context.num_threads), seeds);
    mask = Closed(mask, organ.smoothing_mm, context.num_threads);
  }
  if (Count(mask) == 0) {
    throw NoAnswerError(Message(organ.tissue,
                                ": nothing remains around its seeds; lower smoothing_mm or "
                                "widen the range of HU"));
  }
  Mask whole(ct.geometry);
  Paste(mask, box, whole);
  return whole;
}

}  // namespace acus::segmentation
