#include "acus/patient/atlas/atlas_organs.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "acus/base/core/parallel.h"
#include "acus/data/volume/label_lookup.h"
#include "acus/data/volume/labels.h"
#include "acus/data/volume/volume_io.h"
#include "acus/patient/atlas/organ_evidence.h"
#include "acus/patient/atlas/organ_fusion.h"
#include "acus/patient/segmentation/import/imported_labels.h"
#include "acus/patient/segmentation/organ_checks.h"
#include "acus/patient/segmentation/voxels/metrics.h"

namespace acus::atlas {
namespace {

using segmentation::Mask;
using segmentation::OrganEvidence;
using volume::Grid;
using volume::LabelMap;

struct Organ {
  std::string_view name;
  double least_ml, most_ml;  ///< Volumes that a patient can have.
  double reach_mm;  ///< How far it may lie from where it is in the aligned body; see Placed.
};
constexpr std::array kOrgans = {Organ{"liver", 300.0, 4000.0, 0.0},
                                Organ{"kidney", 40.0, 1200.0, 60.0},
                                Organ{"spleen", 20.0, 2000.0, 0.0}};

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

/// The labels at the places of a grid.
LabelMap OnGrid(const LabelMap& labels, const volume::Geometry& grid, int num_threads) {
  LabelMap out(grid);
  const Eigen::Affine3d ct_from_index = grid.ct_from_index();
  const Eigen::Affine3d voxel_from_ct = labels.geometry.index_from_ct();
  ParallelFor(grid.size[2], num_threads, [&](int k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        out.At(i, j, k) =
            volume::LabelAt(labels, voxel_from_ct, ct_from_index * Eigen::Vector3d(i, j, k));
      }
    }
  });
  return out;
}

bool IsKnown(const LabelMap& labels, const Organ& organ) {
  return labels.names.contains(volume::LabelOf(std::string(organ.name)));
}

bool AreAllKnown(const LabelMap& labels) {
  return std::ranges::all_of(kOrgans, [&](const Organ& organ) { return IsKnown(labels, organ); });
}

/// @return False, with a warning, if no patient has such a volume.
bool Lay(const Organ& organ, const Mask& mask, LabelMap& labels, const RunContext& context) {
  const std::string name(organ.name);
  const double ml =
      static_cast<double>(segmentation::Count(mask)) * mask.geometry.voxel_volume_mm3() / 1000.0;
  if (ml < organ.least_ml || ml > organ.most_ml) {
    context.Warn(Message("the atlas finds ", std::round(ml), " ml of ", name,
                         ", which no patient has (", organ.least_ml, " to ", organ.most_ml,
                         " ml); omitted"));
    return false;
  }
  const volume::Label label = volume::LabelOf(name);
  for (std::size_t n = 0; n < mask.voxels.size(); ++n) {
    if (mask.voxels[n] != 0) labels.voxels[n] = label;
  }
  labels.names[label] = name;
  return true;
}

/// Carries atlas patients onto one CT, and warns of those that show another part of the body.
class Carrying {
 public:
  Carrying(const volume::CtVolume& ct, const LabelMap& labels)
      : image_(ct, labels, kAtlasSpacingMm) {}

  void Add(const LabelledPatient& other, const RunContext& context) {
    auto carried = CarryLabels(other, image_, context);
    if (carried) {
      carried_.push_back(std::move(*carried));
    } else {
      context.Warn(Message(other.name, " of the atlas shares too little of the body with the CT"));
    }
  }
  std::vector<OrganEvidence> AddOrgans(LabelMap& labels, const RunContext& context) {
    return AddCarriedOrgans(image_, std::move(carried_), labels, context);
  }

 private:
  PatientImage image_;
  std::vector<CarriedLabels> carried_;
};

/// How well the organs of `patient` are found from `other`: Dice of each part.
std::map<std::string, double> FoundBy(const LabelledPatient& other, const LabelledPatient& patient,
                                      const RunContext& context) {
  LabelMap labels = patient.tissues;
  std::map<std::string, double> dice;
  try {
    Carrying carrying(patient.ct, patient.tissues);
    carrying.Add(other, context);
    carrying.AddOrgans(labels, context);
  } catch (const NoAnswerError&) {
    return dice;  // The two show different parts of the body.
  }
  const auto middle = segmentation::MiddleXMm(labels);
  for (const Organ& organ : kOrgans) {
    const std::string name(organ.name);
    const auto parts_of = [&](const LabelMap& map) {
      return segmentation::OrganParts(name, segmentation::MaskOf(map, volume::LabelOf(name)),
                                      middle);
    };
    const auto found = parts_of(labels);
    for (const auto& [part, mask] : parts_of(patient.organs)) {
      const auto ours = std::ranges::find(found, part, [](const auto& p) { return p.first; });
      dice[part] = ours == found.end() ? 0.0 : segmentation::Dice(ours->second, mask);
    }
  }
  return dice;
}

/// Adds to the evidence how well each atlas patient finds the organs of the next.
void CheckAtlas(const std::vector<LabelledPatient>& atlas, std::vector<OrganEvidence>& evidence,
                const RunContext& context) {
  std::map<std::string, std::pair<double, int>> sums;
  for (std::size_t n = 0; n < atlas.size(); ++n) {
    const LabelledPatient& next = atlas[(n + 1) % atlas.size()];
    context.Checkpoint(Message("finding the organs of ", next.name, " from ", atlas[n].name),
                       static_cast<double>(n) / static_cast<double>(atlas.size()));
    for (const auto& [part, dice] : FoundBy(atlas[n], next, context)) {
      sums[part].first += dice;
      ++sums[part].second;
    }
  }
  for (OrganEvidence& organ : evidence) {
    const auto sum = sums.find(organ.name);
    if (sum != sums.end()) organ.self_check = sum->second.first / sum->second.second;
  }
}

}  // namespace

LabelledPatient ReadLabelledPatient(const AtlasPatient& patient,
                                    const segmentation::TissueOptions& tissues,
                                    const RunContext& context) {
  context.Checkpoint(Message("reading ", patient.name, " of the atlas"), 0.0);
  LabelledPatient out{.name = patient.name,
                      .ct = volume::ReadCt(patient.ct, patient.series, context),
                      .tissues = {},
                      .organs = {}};
  out.organs = segmentation::TissuesIn(
      segmentation::ReadImportedLabels(patient.labels, out.ct.geometry, context));
  GiveLesionsToOrgans(out.organs);
  out.tissues = segmentation::FindTissues(out.ct, tissues, context).labels;
  return out;
}

std::vector<OrganEvidence> AddCarriedOrgans(const PatientImage& image,
                                            std::vector<CarriedLabels> carried, LabelMap& labels,
                                            const RunContext& context) {
  if (carried.empty()) {
    throw NoAnswerError(
        "no patient of the atlas shows the part of the body that the CT shows; add one that does");
  }
  const CarriedAtlas patient{.hu = image.Hu(context.num_threads),
                             .tissues = OnGrid(labels, image.geometry(), context.num_threads),
                             .carried = std::move(carried)};
  const auto middle = segmentation::MiddleXMm(labels);
  std::vector<OrganEvidence> evidence;
  for (const Organ& organ : kOrgans) {
    if (IsKnown(labels, organ)) continue;
    context.Checkpoint(Message("finding the ", organ.name), 0.0);
    const auto found = FindOrgan(patient, organ.name, organ.reach_mm, context.num_threads);
    if (!found) continue;
    if (!Lay(organ, OnCt(found->u, labels, context.num_threads), labels, context)) continue;
    const auto parts = EvidenceOf(std::string(organ.name), *found, middle, context.num_threads);
    evidence.insert(evidence.end(), parts.begin(), parts.end());
  }
  if (evidence.empty()) throw NoAnswerError("the atlas finds no organ in the CT");
  return evidence;
}

std::vector<OrganEvidence> AddAtlasOrgans(const volume::CtVolume& ct,
                                          const std::vector<LabelledPatient>& atlas,
                                          LabelMap& labels, const RunContext& context) {
  if (atlas.empty() || AreAllKnown(labels)) return {};
  Carrying carrying(ct, labels);
  for (const LabelledPatient& other : atlas) carrying.Add(other, context);
  std::vector<OrganEvidence> evidence = carrying.AddOrgans(labels, context);
  if (atlas.size() > 1) CheckAtlas(atlas, evidence, context);
  return evidence;
}

std::vector<OrganEvidence> AddAtlasOrgans(const volume::CtVolume& ct,
                                          const std::vector<AtlasPatient>& atlas,
                                          const segmentation::TissueOptions& tissues,
                                          LabelMap& labels, const RunContext& context) {
  if (AreAllKnown(labels)) return {};
  std::vector<LabelledPatient> patients;
  for (const AtlasPatient& other : atlas) {
    patients.push_back(ReadLabelledPatient(other, tissues, context));
  }
  return AddAtlasOrgans(ct, patients, labels, context);
}

}  // namespace acus::atlas
