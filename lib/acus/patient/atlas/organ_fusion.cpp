#include "acus/patient/atlas/organ_fusion.h"

#include <algorithm>
#include <array>

#include "acus/data/volume/labels.h"
#include "acus/patient/atlas/organ_place.h"
#include "acus/patient/segmentation/voxels/crop.h"

namespace acus::atlas {
namespace {

using segmentation::Mask;
using volume::Grid;

constexpr double kMarginMm = 55.0;       // Around the prior, in which an organ is looked for.
constexpr float kBeyondAtlas = 0.5F;     // Weight of the prior where the atlas's CT has ended.
constexpr float kLeastLikeness = 1e-6F;  // So that weights never add up to 0.

/// Distance [mm] to the surface of a region, positive inside.
Grid<float> SignedDistanceMm(const Mask& region, int num_threads) {
  Mask outside(region.geometry);
  for (std::size_t n = 0; n < region.voxels.size(); ++n) outside.voxels[n] = region.voxels[n] == 0;
  Grid<float> signed_mm = segmentation::DistanceMm(outside, num_threads);
  const Grid<float> to_region = segmentation::DistanceMm(region, num_threads);
  for (std::size_t n = 0; n < signed_mm.voxels.size(); ++n) {
    signed_mm.voxels[n] -= to_region.voxels[n];
  }
  return signed_mm;
}

/// The part of the patient around all regions.
segmentation::Box BoxAround(const std::vector<Mask>& regions) {
  Mask anywhere(regions.front().geometry);
  for (const Mask& region : regions) {
    for (std::size_t n = 0; n < anywhere.voxels.size(); ++n) {
      anywhere.voxels[n] |= region.voxels[n];
    }
  }
  segmentation::Box box = segmentation::BoundsOf(anywhere);
  const int margin = static_cast<int>(kMarginMm / anywhere.geometry.spacing_mm[0]);
  box.low = (box.low - margin).max(0);
  box.high = (box.high + margin).min(anywhere.geometry.size - 1);
  return box;
}

/// Where skin, lung, gas and air are, no organ is.
Mask AllowedIn(const volume::LabelMap& tissues) {
  static const std::array kNever = {volume::Label{0}, volume::LabelOf("skin"),
                                    volume::LabelOf("lung"), volume::LabelOf("gas")};
  Mask allowed(tissues.geometry);
  std::ranges::transform(tissues.voxels, allowed.voxels.begin(), [](volume::Label here) {
    return std::ranges::find(kNever, here) == kNever.end() ? 1 : 0;
  });
  return allowed;
}

/// Where one atlas patient has the organ.
Mask RegionOf(const CarriedAtlas& patient, const CarriedLabels& carried, volume::Label organ,
              double organ_hu, double reach_mm, int num_threads) {
  if (reach_mm > 0.0) {
    const Mask aligned = segmentation::MaskOf(carried.aligned, organ);
    if (segmentation::Count(aligned) > 0) {
      return Placed(patient.hu, aligned, organ_hu, reach_mm, num_threads);
    }
  }
  return segmentation::MaskOf(carried.organs, organ);
}

/// Adds one atlas patient's signed distances, by its likeness to the patient at each voxel.
void AddPrior(const Mask& expected, const CarriedLabels& carried, const segmentation::Box& box,
              int num_threads, FoundOrgan& out, Grid<float>& weights) {
  const Grid<float> distance = SignedDistanceMm(expected, num_threads);
  const Mask known = segmentation::Cropped(carried.covered, box);
  const Grid<float> likeness = segmentation::Cropped(carried.likeness, box);
  for (std::size_t n = 0; n < known.voxels.size(); ++n) {
    const float weight = std::max(likeness.voxels[n], kLeastLikeness);
    const float trust = known.voxels[n] != 0 ? 1.0F : kBeyondAtlas;
    out.search.prior_mm.voxels[n] += weight * trust * distance.voxels[n];
    out.covered.voxels[n] |= known.voxels[n];
    weights.voxels[n] += weight;
  }
}

}  // namespace

std::optional<FoundOrgan> FindOrgan(const CarriedAtlas& patient, std::string_view tissue,
                                    double reach_mm, int num_threads) {
  const volume::Label organ = volume::LabelOf(std::string(tissue));
  std::vector<Mask> regions;
  std::vector<const CarriedLabels*> having;
  double organ_hu = 0.0;
  for (const CarriedLabels& carried : patient.carried) {
    const auto hu = carried.organ_hu.find(organ);
    if (hu == carried.organ_hu.end()) continue;
    regions.push_back(RegionOf(patient, carried, organ, hu->second, reach_mm, num_threads));
    having.push_back(&carried);
    organ_hu += hu->second;
  }
  if (regions.empty()) return std::nullopt;
  organ_hu /= static_cast<double>(regions.size());

  const segmentation::Box box = BoxAround(regions);
  FoundOrgan out;
  out.search.hu = segmentation::Cropped(patient.hu, box);
  const volume::Geometry& grid = out.search.hu.geometry;
  out.search.prior_mm = Grid<float>(grid);
  out.covered = Mask(grid);
  out.tissues = volume::LabelMap(grid);
  out.tissues.voxels = segmentation::Cropped<volume::Label>(patient.tissues, box).voxels;
  Grid<float> weights(grid);
  for (std::size_t one = 0; one < regions.size(); ++one) {
    AddPrior(segmentation::Cropped(regions[one], box), *having[one], box, num_threads, out,
             weights);
  }
  for (std::size_t n = 0; n < weights.voxels.size(); ++n) {
    out.search.prior_mm.voxels[n] /= weights.voxels[n];
  }
  out.search.allowed = AllowedIn(out.tissues);
  out.u = CutOrgan(out.search, organ_hu, num_threads);
  return out;
}

}  // namespace acus::atlas
