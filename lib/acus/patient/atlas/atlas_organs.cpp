#include "acus/patient/atlas/atlas_organs.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string_view>

#include "acus/base/core/parallel.h"
#include "acus/data/volume/label_lookup.h"
#include "acus/data/volume/labels.h"
#include "acus/data/volume/volume_io.h"
#include "acus/patient/atlas/organ_cut.h"
#include "acus/patient/atlas/organ_place.h"
#include "acus/patient/atlas/patient_map.h"
#include "acus/patient/segmentation/import/imported_labels.h"
#include "acus/patient/segmentation/voxels/crop.h"

namespace acus::atlas {
namespace {

using segmentation::Mask;
using volume::Grid;
using volume::LabelMap;

constexpr double kSpacingMm = 3.0;  // Of registration and cut.
constexpr double kMarginMm = 55.0;  // Around the prior, in which an organ is looked for.

constexpr float kBeyondAtlas = 0.5F;  // Weight of the prior where the atlas's CT has ended.

struct Organ {
  std::string_view name;
  double least_ml, most_ml;  ///< Volumes that a patient can have.
  double reach_mm;  ///< How far it may lie from where it is in the aligned body; see Placed.
};
constexpr std::array kOrgans = {Organ{"liver", 300.0, 4000.0, 0.0},
                                Organ{"kidney", 40.0, 1200.0, 60.0},
                                Organ{"spleen", 20.0, 2000.0, 0.0}};

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

float Interpolated(const Grid<float>& grid, const Eigen::Array3d& at) {
  const Eigen::Array3i& size = grid.geometry.size;
  if ((at < 0.0).any() || (at > (size - 1).cast<double>()).any()) return 0.0F;
  const Eigen::Array3i base = at.cast<int>().min(size - 2).max(0);
  const Eigen::Array3f t = (at - base.cast<double>()).cast<float>();
  float sum = 0.0F;
  for (int c = 0; c < 8; ++c) {
    const Eigen::Array3i corner(c & 1, (c >> 1) & 1, c >> 2);
    const Eigen::Array3i v = (base + corner).min(size - 1);
    const Eigen::Array3f weight = (corner == 1).select(t, 1.0F - t);
    sum += weight.prod() * grid.At(v[0], v[1], v[2]);
  }
  return sum;
}

/// The patient, and what the whole atlas says of him.
struct Patient {
  const volume::CtVolume& ct;
  const LabelMap& labels;
  const PatientImage& image;
  Grid<float> hu;
  std::vector<CarriedLabels> carried;
};

/// Where skin, lung, gas and air are, no organ is.
void ForbidAirAndSkin(const LabelMap& labels, Mask& allowed) {
  static const std::array kNever = {volume::Label{0}, volume::LabelOf("skin"),
                                    volume::LabelOf("lung"), volume::LabelOf("gas")};
  const Eigen::Affine3d ct_from_index = allowed.geometry.ct_from_index();
  const Eigen::Affine3d voxel_from_ct = labels.geometry.index_from_ct();
  const Eigen::Array3i& size = allowed.geometry.size;
  for (int k = 0; k < size[2]; ++k) {
    for (int j = 0; j < size[1]; ++j) {
      for (int i = 0; i < size[0]; ++i) {
        const volume::Label here =
            volume::LabelAt(labels, voxel_from_ct, ct_from_index * Eigen::Vector3d(i, j, k));
        if (std::ranges::find(kNever, here) != kNever.end()) allowed.At(i, j, k) = 0;
      }
    }
  }
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
  const int margin = static_cast<int>(kMarginMm / kSpacingMm);
  box.low = (box.low - margin).max(0);
  box.high = (box.high + margin).min(anywhere.geometry.size - 1);
  return box;
}

/// Where one atlas patient has the organ.
Mask RegionOf(const Patient& patient, const CarriedLabels& carried, const Organ& organ,
              double organ_hu, int num_threads) {
  const volume::Label label = volume::LabelOf(organ.name);
  if (organ.reach_mm > 0.0) {
    const Mask aligned = segmentation::MaskOf(carried.aligned, label);
    if (segmentation::Count(aligned) > 0) {
      return Placed(patient.hu, aligned, organ_hu, organ.reach_mm, num_threads);
    }
  }
  return segmentation::MaskOf(carried.organs, label);
}

/// None if no atlas patient has the organ where the CT shows the body.
std::optional<Grid<float>> FindOrgan(const Patient& patient, const Organ& wanted,
                                     const RunContext& context) {
  const volume::Label organ = volume::LabelOf(wanted.name);
  std::vector<Mask> regions, covered;
  double organ_hu = 0.0;
  for (const CarriedLabels& carried : patient.carried) {
    const auto hu = carried.organ_hu.find(organ);
    if (hu == carried.organ_hu.end()) continue;
    regions.push_back(RegionOf(patient, carried, wanted, hu->second, context.num_threads));
    covered.push_back(carried.covered);
    organ_hu += hu->second;
  }
  if (regions.empty()) return std::nullopt;
  const auto share = static_cast<float>(1.0 / static_cast<double>(regions.size()));
  organ_hu *= static_cast<double>(share);

  const segmentation::Box box = BoxAround(regions);
  OrganSearch search{.hu = segmentation::Cropped(patient.hu, box), .prior_mm = {}, .allowed = {}};
  search.prior_mm = Grid<float>(search.hu.geometry);
  search.allowed = Mask(search.hu.geometry, 1);
  for (std::size_t one = 0; one < regions.size(); ++one) {
    const Grid<float> distance =
        SignedDistanceMm(segmentation::Cropped(regions[one], box), context.num_threads);
    const Mask known = segmentation::Cropped(covered[one], box);
    for (std::size_t n = 0; n < known.voxels.size(); ++n) {
      const float trust = known.voxels[n] != 0 ? 1.0F : kBeyondAtlas;
      search.prior_mm.voxels[n] += share * trust * distance.voxels[n];
    }
  }
  ForbidAirAndSkin(patient.labels, search.allowed);
  return CutOrgan(search, organ_hu, context.num_threads);
}

/// The organ on the CT's own grid, where `labels` has nothing better.
Mask OnCt(const Grid<float>& u, const LabelMap& labels, int num_threads) {
  static const volume::Label kFat = volume::LabelOf("fat");
  static const volume::Label kSoft = volume::LabelOf("soft_tissue");
  static const volume::Label kMuscle = volume::LabelOf("muscle");
  constexpr float kCore = 0.9F;  // Fat this deep inside is noise.
  Mask organ(labels.geometry);
  const Eigen::Affine3d index = u.geometry.index_from_ct() * labels.geometry.ct_from_index();
  ParallelFor(labels.geometry.size[2], num_threads, [&](int k) {
    for (int j = 0; j < labels.geometry.size[1]; ++j) {
      for (int i = 0; i < labels.geometry.size[0]; ++i) {
        const volume::Label here = labels.At(i, j, k);
        if (here != kFat && here != kSoft && here != kMuscle) continue;
        const float value = Interpolated(u, (index * Eigen::Vector3d(i, j, k)).array());
        organ.At(i, j, k) = value > (here == kFat ? kCore : 0.5F);
      }
    }
  });
  return organ;
}

/// Lesions become the organ that most of their surroundings are.
void GiveLesionsToOrgans(LabelMap& organs) {
  static const volume::Label kLesion = volume::LabelOf("lesion");
  const Mask lesions = segmentation::MaskOf(organs, kLesion);
  if (segmentation::Count(lesions) == 0) return;
  const segmentation::Components parts = segmentation::ConnectedComponents(lesions);
  std::vector<std::array<std::size_t, 256>> around(parts.num_voxels.size());
  const Eigen::Array3i& size = organs.geometry.size;
  for (int k = 1; k + 1 < size[2]; ++k) {
    for (int j = 1; j + 1 < size[1]; ++j) {
      for (int i = 1; i + 1 < size[0]; ++i) {
        const auto part = static_cast<std::size_t>(parts.number.At(i, j, k));
        if (part == 0) continue;
        for (int axis = 0; axis < 3; ++axis) {
          const Eigen::Array3i d = Eigen::Vector3i::Unit(axis).array();
          ++around[part][organs.At(i + d[0], j + d[1], k + d[2])];
          ++around[part][organs.At(i - d[0], j - d[1], k - d[2])];
        }
      }
    }
  }
  for (std::size_t n = 0; n < lesions.voxels.size(); ++n) {
    const auto part = static_cast<std::size_t>(parts.number.voxels[n]);
    if (part == 0) continue;
    std::size_t most = 0;
    for (const Organ& organ : kOrgans) {
      const volume::Label label = volume::LabelOf(organ.name);
      if (around[part][label] <= most) continue;
      most = around[part][label];
      organs.voxels[n] = label;
    }
  }
}

LabelledPatient Read(const AtlasPatient& patient, const segmentation::TissueOptions& tissues,
                     const RunContext& context) {
  LabelledPatient out{
      .ct = volume::ReadCt(patient.ct, patient.series, context), .tissues = {}, .organs = {}};
  out.organs = segmentation::TissuesIn(
      segmentation::ReadImportedLabels(patient.labels, out.ct.geometry, context));
  GiveLesionsToOrgans(out.organs);
  out.tissues = segmentation::FindTissues(out.ct, tissues, context).labels;
  return out;
}

}  // namespace

void AddAtlasOrgans(const volume::CtVolume& ct, const std::vector<AtlasPatient>& atlas,
                    const segmentation::TissueOptions& tissues, LabelMap& labels,
                    const RunContext& context) {
  const auto is_known = [&](const Organ& organ) {
    return labels.names.contains(volume::LabelOf(organ.name));
  };
  if (atlas.empty() || std::ranges::all_of(kOrgans, is_known)) return;
  const PatientImage image(ct, labels, kSpacingMm);
  Patient patient{.ct = ct,
                  .labels = labels,
                  .image = image,
                  .hu = image.Hu(context.num_threads),
                  .carried = {}};
  for (const AtlasPatient& other : atlas) {
    context.Checkpoint(Message("reading ", other.name, " of the atlas"), 0.0);
    auto carried = CarryLabels(Read(other, tissues, context), image, context);
    if (carried) {
      patient.carried.push_back(std::move(*carried));
    } else {
      context.Warn(Message(other.name, " of the atlas shares too little of the body with the CT"));
    }
  }
  if (patient.carried.empty()) {
    throw NoAnswerError(
        "no patient of the atlas shows the part of the body that the CT shows; add one that does");
  }
  bool any = false;
  for (const Organ& organ : kOrgans) {
    const std::string name(organ.name);
    const volume::Label label = volume::LabelOf(name);
    if (is_known(organ)) continue;
    context.Checkpoint(Message("finding the ", name), 0.0);
    const auto u = FindOrgan(patient, organ, context);
    if (!u) continue;
    const Mask mask = OnCt(*u, labels, context.num_threads);
    const double ml =
        static_cast<double>(segmentation::Count(mask)) * ct.geometry.voxel_volume_mm3() / 1000.0;
    if (ml < organ.least_ml || ml > organ.most_ml) {
      context.Warn(Message("the atlas finds ", std::round(ml), " ml of ", name,
                           ", which no patient has (", organ.least_ml, " to ", organ.most_ml,
                           " ml); omitted"));
      continue;
    }
    for (std::size_t n = 0; n < mask.voxels.size(); ++n) {
      if (mask.voxels[n] != 0) labels.voxels[n] = label;
    }
    labels.names[label] = name;
    any = true;
  }
  if (!any) throw NoAnswerError("the atlas finds no organ in the CT");
}

}  // namespace acus::atlas
