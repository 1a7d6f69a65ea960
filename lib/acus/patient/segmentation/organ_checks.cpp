#include "acus/patient/segmentation/organ_checks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>

#include "acus/base/core/error.h"
#include "acus/base/core/text_table.h"
#include "acus/base/core/words.h"
#include "acus/data/volume/labels.h"
#include "acus/patient/segmentation/voxels/crop.h"

namespace acus::segmentation {
namespace {

constexpr double kLeastInOnePiece = 0.85;  ///< Of the organ.
constexpr double kMostKidneyRatio = 1.8;   ///< Of the two volumes.
constexpr double kMostKidneyStepMm = 60.0;
constexpr double kMostInOtherHalfMm = 15.0;  ///< Of the centroid.
/// Where a kidney's centroid lies beside and in front of the spinal canal at its height: wide
/// limits.
constexpr double kLeastKidneyAsideMm = 25.0, kMostKidneyAsideMm = 110.0;
constexpr double kLeastKidneyInFrontMm = -25.0, kMostKidneyInFrontMm = 75.0;
constexpr double kNearHeightMm = 20.0;

/// Volumes of adults: wide limits around published means, rounded; not a study's quantiles.
struct Range {
  const char* tissue;
  double least_ml, most_ml;
  double side;  ///< +1 left, -1 right, 0 one on each side.
};
constexpr std::array kRanges = {Range{"liver", 594.0, 2250.0, -1.0},
                                Range{"kidney", 80.0, 270.0, 0.0},
                                Range{"spleen", 40.0, 460.0, 1.0}};

struct Organ {
  Mask mask;
  Eigen::Vector3d centroid_mm = Eigen::Vector3d::Zero();
  bool is_cut = false;  ///< By the border of the volume.
};

Organ Measured(Mask mask) {
  Organ organ{.mask = std::move(mask)};
  const volume::Geometry& g = organ.mask.geometry;
  const Eigen::Affine3d ct_from_index = g.ct_from_index();
  double count = 0.0;
  for (int k = 0; k < g.size[2]; ++k) {
    for (int j = 0; j < g.size[1]; ++j) {
      for (int i = 0; i < g.size[0]; ++i) {
        if (organ.mask.At(i, j, k) == 0) continue;
        organ.centroid_mm += ct_from_index * Eigen::Vector3d(i, j, k);
        ++count;
        const Eigen::Array3i at(i, j, k);
        organ.is_cut = organ.is_cut || (at == 0).any() || (at == g.size - 1).any();
      }
    }
  }
  organ.centroid_mm /= std::max(count, 1.0);
  return organ;
}

Mask OnSide(const Mask& mask, double middle_x_mm, double side) {
  Mask out = mask;
  const volume::Geometry& g = mask.geometry;
  const Eigen::Affine3d ct_from_index = g.ct_from_index();
  for (int k = 0; k < g.size[2]; ++k) {
    for (int j = 0; j < g.size[1]; ++j) {
      for (int i = 0; i < g.size[0]; ++i) {
        const double x = (ct_from_index * Eigen::Vector3d(i, j, k)).x();
        if ((x - middle_x_mm) * side <= 0.0) out.At(i, j, k) = 0;
      }
    }
  }
  return out;
}

std::string Millilitres(double ml) {
  return FixedText(ml, 0) + " ml";
}

OrganCheck Checked(const std::string& name, const Organ& organ, const Range& range,
                   const std::optional<double>& middle_x_mm) {
  const double voxel_ml = organ.mask.geometry.voxel_volume_mm3() / 1000.0;
  OrganCheck check{.name = name,
                   .volume_ml = static_cast<double>(Count(organ.mask)) * voxel_ml,
                   .least_ml = range.least_ml,
                   .most_ml = range.most_ml,
                   .doubts = {}};
  if (check.volume_ml > range.most_ml) {
    check.doubts.push_back(Message("larger than ", Millilitres(range.most_ml)));
  }
  if (check.volume_ml < range.least_ml && !organ.is_cut) {
    check.doubts.push_back(Message("smaller than ", Millilitres(range.least_ml)));
  }
  const Components parts = ConnectedComponents(organ.mask);
  const auto largest = static_cast<double>(std::ranges::max(parts.num_voxels)) * voxel_ml;
  if (largest < kLeastInOnePiece * check.volume_ml) {
    check.doubts.push_back(Message("in pieces: the largest has ", Millilitres(largest), " of ",
                                   Millilitres(check.volume_ml)));
  }
  if (middle_x_mm && range.side != 0.0 &&
      (organ.centroid_mm.x() - *middle_x_mm) * range.side < -kMostInOtherHalfMm) {
    check.doubts.emplace_back(range.side > 0.0 ? "on the right side" : "on the left side");
  }
  return check;
}

void CompareKidneys(const Organ& left, const Organ& right, OrganCheck& left_check,
                    OrganCheck& right_check) {
  const auto both = [&](const std::string& doubt) {
    left_check.doubts.push_back(doubt);
    right_check.doubts.push_back(doubt);
  };
  const auto [low, high] = std::minmax(left_check.volume_ml, right_check.volume_ml);
  if (!left.is_cut && !right.is_cut && high > kMostKidneyRatio * low) {
    both(Message("one kidney is ", FixedText(high / low, 1), " times as large as the other"));
  }
  const double step_mm = std::abs(left.centroid_mm.z() - right.centroid_mm.z());
  if (step_mm > kMostKidneyStepMm) {
    both(Message("one kidney lies ", FixedText(step_mm, 0), " mm higher than the other"));
  }
}

/// The middle of the canal near a height; none if the canal does not reach it.
std::optional<Eigen::Vector3d> CanalAt(const Mask& canal, double z_mm) {
  const volume::Geometry& g = canal.geometry;
  const Eigen::Affine3d ct_from_index = g.ct_from_index();
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double count = 0.0;
  for (int k = 0; k < g.size[2]; ++k) {
    for (int j = 0; j < g.size[1]; ++j) {
      for (int i = 0; i < g.size[0]; ++i) {
        if (canal.At(i, j, k) == 0) continue;
        const Eigen::Vector3d p = ct_from_index * Eigen::Vector3d(i, j, k);
        if (std::abs(p.z() - z_mm) > kNearHeightMm) continue;
        sum += p;
        ++count;
      }
    }
  }
  return count > 0.0 ? std::optional<Eigen::Vector3d>(sum / count) : std::nullopt;
}

/// A kidney that is cut may have its centroid anywhere.
void CheckPlace(const Organ& kidney, const Mask& canal, OrganCheck& check) {
  const auto middle = CanalAt(canal, kidney.centroid_mm.z());
  if (!middle || kidney.is_cut) return;
  const double beside_mm = std::abs(kidney.centroid_mm.x() - middle->x());
  const double in_front_mm = middle->y() - kidney.centroid_mm.y();
  if (beside_mm < kLeastKidneyAsideMm || beside_mm > kMostKidneyAsideMm) {
    check.doubts.push_back(
        Message("its middle lies ", FixedText(beside_mm, 0), " mm beside the spinal canal, of ",
                FixedText(kLeastKidneyAsideMm, 0), " to ", FixedText(kMostKidneyAsideMm, 0)));
  }
  if (in_front_mm < kLeastKidneyInFrontMm || in_front_mm > kMostKidneyInFrontMm) {
    check.doubts.push_back(Message(
        "its middle lies ", FixedText(in_front_mm, 0), " mm in front of the spinal canal, of ",
        FixedText(kLeastKidneyInFrontMm, 0), " to ", FixedText(kMostKidneyInFrontMm, 0)));
  }
}

void AddEvidence(const std::vector<OrganEvidence>& evidence, OrganCheck& check) {
  const auto found = std::ranges::find(evidence, check.name, &OrganEvidence::name);
  if (found == evidence.end()) return;
  check.expected_dice = ExpectedDice(*found);
  for (std::string& doubt : DoubtsIn(*found)) check.doubts.push_back(std::move(doubt));
}

}  // namespace

std::optional<double> MiddleXMm(const volume::LabelMap& labels) {
  const Mask canal = MaskOf(labels, volume::LabelOf("spinal_canal"));
  if (Count(canal) == 0) return std::nullopt;
  return Measured(canal).centroid_mm.x();
}

std::vector<std::pair<std::string, Mask>> OrganParts(const std::string& tissue, const Mask& organ,
                                                     const std::optional<double>& middle_x_mm) {
  std::vector<std::pair<std::string, Mask>> parts;
  if (tissue == "kidney" && middle_x_mm) {
    parts.emplace_back("kidney_left", OnSide(organ, *middle_x_mm, 1.0));
    parts.emplace_back("kidney_right", OnSide(organ, *middle_x_mm, -1.0));
  } else {
    parts.emplace_back(tissue, organ);
  }
  std::erase_if(parts, [](const auto& part) { return Count(part.second) == 0; });
  return parts;
}

std::vector<OrganCheck> CheckOrgans(const volume::LabelMap& labels,
                                    const std::vector<OrganEvidence>& evidence) {
  const std::optional<double> middle = MiddleXMm(labels);
  const Mask canal = MaskOf(labels, volume::LabelOf("spinal_canal"));
  std::vector<OrganCheck> checks;
  for (const Range& range : kRanges) {
    std::vector<Organ> organs;
    const std::size_t first = checks.size();
    const Mask whole = MaskOf(labels, volume::LabelOf(range.tissue));
    for (auto& [name, part] : OrganParts(range.tissue, whole, middle)) {
      Range one = range;
      if (name == "kidney") one.most_ml *= 2.0;  // Both.
      organs.push_back(Measured(std::move(part)));
      checks.push_back(Checked(name, organs.back(), one, middle));
      if (name.starts_with("kidney_")) CheckPlace(organs.back(), canal, checks.back());
    }
    if (organs.size() == 2) CompareKidneys(organs[0], organs[1], checks[first], checks[first + 1]);
  }
  for (OrganCheck& check : checks) AddEvidence(evidence, check);
  return checks;
}

volume::LabelMap WithDoubtsInNames(volume::LabelMap labels, const std::vector<OrganCheck>& organs) {
  for (const OrganCheck& organ : organs) {
    if (organ.is_sure()) continue;
    const volume::Label label = volume::LabelOf(organ.name.substr(0, organ.name.find('_')));
    std::string& name = labels.names[label];
    if (!name.ends_with("(unsure)")) name += " (unsure)";
  }
  return labels;
}

}  // namespace acus::segmentation
