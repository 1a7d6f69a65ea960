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
  double count = 0.0;
  for (int k = 0; k < g.size[2]; ++k) {
    for (int j = 0; j < g.size[1]; ++j) {
      for (int i = 0; i < g.size[0]; ++i) {
        if (organ.mask.At(i, j, k) == 0) continue;
        organ.centroid_mm += g.ct_from_index() * Eigen::Vector3d(i, j, k);
        ++count;
        const Eigen::Array3i at(i, j, k);
        organ.is_cut = organ.is_cut || (at == 0).any() || (at == g.size - 1).any();
      }
    }
  }
  organ.centroid_mm /= std::max(count, 1.0);
  return organ;
}

std::optional<double> MiddleXMm(const volume::LabelMap& labels) {
  const Mask canal = MaskOf(labels, volume::LabelOf("spinal_canal"));
  if (Count(canal) == 0) return std::nullopt;
  return Measured(canal).centroid_mm.x();
}

Mask OnSide(const Mask& mask, double middle_x_mm, double side) {
  Mask out = mask;
  const volume::Geometry& g = mask.geometry;
  for (int k = 0; k < g.size[2]; ++k) {
    for (int j = 0; j < g.size[1]; ++j) {
      for (int i = 0; i < g.size[0]; ++i) {
        const double x = (g.ct_from_index() * Eigen::Vector3d(i, j, k)).x();
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

/// Both kidneys, or what there is without a middle to distinguish them.
void AddKidneys(const Mask& mask, const Range& range, const std::optional<double>& middle_x_mm,
                std::vector<OrganCheck>& checks) {
  if (!middle_x_mm) {
    Range both = range;
    both.most_ml *= 2.0;
    checks.push_back(Checked("kidney", Measured(mask), both, middle_x_mm));
    return;
  }
  const Organ left = Measured(OnSide(mask, *middle_x_mm, 1.0));
  const Organ right = Measured(OnSide(mask, *middle_x_mm, -1.0));
  std::vector<OrganCheck> found;
  for (const auto& [name, organ] : {std::pair("kidney_left", &left), {"kidney_right", &right}}) {
    if (Count(organ->mask) > 0) found.push_back(Checked(name, *organ, range, middle_x_mm));
  }
  if (found.size() == 2) CompareKidneys(left, right, found[0], found[1]);
  checks.insert(checks.end(), found.begin(), found.end());
}

}  // namespace

std::vector<OrganCheck> CheckOrgans(const volume::LabelMap& labels) {
  const std::optional<double> middle = MiddleXMm(labels);
  std::vector<OrganCheck> checks;
  for (const Range& range : kRanges) {
    const Mask mask = MaskOf(labels, volume::LabelOf(range.tissue));
    if (Count(mask) == 0) continue;
    if (range.side == 0.0) {
      AddKidneys(mask, range, middle, checks);
    } else {
      checks.push_back(Checked(range.tissue, Measured(mask), range, middle));
    }
  }
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
