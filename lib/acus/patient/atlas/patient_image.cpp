#include "acus/patient/atlas/patient_image.h"

#include <algorithm>
#include <array>
#include <optional>

#include "acus/data/volume/label_lookup.h"
#include "acus/data/volume/labels.h"
#include "acus/patient/breathing_registration/level_image.h"
#include "acus/patient/segmentation/segmenters/tissues.h"
#include "acus/patient/segmentation/voxels/crop.h"

namespace acus::atlas {
namespace {

using segmentation::Mask;
using volume::Grid;

constexpr double kLeastContrast = -80.0, kMostContrast = 150.0;  // Of soft tissue, HU.

/// The value of a tissue that follows from its label alone; none for soft tissue.
std::optional<float> FixedValue(volume::Label tissue) {
  static const auto values = [] {
    std::array<std::optional<float>, 256> table;
    table[0] = -250.0F;
    table[volume::LabelOf("lung")] = -200.0F;
    table[volume::LabelOf("fat")] = -100.0F;
    table[volume::LabelOf("skin")] = -50.0F;
    table[volume::LabelOf("gas")] = 0.0F;  // Bowel gas is elsewhere in every patient.
    table[volume::LabelOf("bone")] = 200.0F;
    return table;
  }();
  return values[tissue];
}

float SoftValue(double hu, double soft_hu) {
  return static_cast<float>(std::clamp(hu - soft_hu, kLeastContrast, kMostContrast));
}

}  // namespace

PatientImage::PatientImage(const volume::CtVolume& ct, const volume::LabelMap& tissues,
                           double spacing_mm)
    : ct_(ct), tissues_(tissues), box_(segmentation::BoundsOf(segmentation::BodyOf(tissues))) {
  ACUS_REQUIRE(!box_.empty(), "atlas: there is no body in the CT");
  volume::Geometry part = ct.geometry;
  part.size = box_.high - box_.low + 1;
  part.origin_mm = ct.geometry.ct_from_index() * box_.low.cast<double>().matrix();
  geometry_ = breathing_registration::CubicGrid(part, spacing_mm);
  body_ = Mask(geometry_);
  const Eigen::Affine3d ct_from_index = geometry_.ct_from_index();
  const Eigen::Affine3d voxel_from_ct = tissues.geometry.index_from_ct();
  for (int k = 0; k < geometry_.size[2]; ++k) {
    for (int j = 0; j < geometry_.size[1]; ++j) {
      for (int i = 0; i < geometry_.size[0]; ++i) {
        body_.At(i, j, k) =
            volume::LabelAt(tissues, voxel_from_ct, ct_from_index * Eigen::Vector3d(i, j, k)) != 0;
      }
    }
  }
  std::vector<std::int16_t> soft;
  for (std::size_t n = 0; n < ct.voxels.size(); ++n) {
    if (!FixedValue(tissues.voxels[n])) soft.push_back(ct.voxels[n]);
  }
  soft_hu_ = segmentation::MedianHu(soft);
}

Grid<float> PatientImage::Coarse(const Grid<float>& fine, int num_threads) const {
  return breathing_registration::Averaged(segmentation::Cropped(fine, box_), geometry_,
                                          num_threads);
}

Grid<float> PatientImage::Comparable(double soft_hu, int num_threads) const {
  Grid<float> fine(ct_.geometry);
  for (std::size_t n = 0; n < fine.voxels.size(); ++n) {
    fine.voxels[n] = FixedValue(tissues_.voxels[n]).value_or(SoftValue(ct_.voxels[n], soft_hu));
  }
  return Coarse(fine, num_threads);
}

Grid<float> PatientImage::Imitated(const volume::LabelMap& organs,
                                   const std::map<volume::Label, double>& organ_hu, double soft_hu,
                                   int num_threads) const {
  std::array<std::optional<float>, 256> value;
  for (const auto& [label, hu] : organ_hu) value[label] = SoftValue(hu, soft_hu);
  Grid<float> fine(ct_.geometry);
  for (std::size_t n = 0; n < fine.voxels.size(); ++n) {
    const volume::Label tissue = tissues_.voxels[n];
    const auto organ = tissue != 0 ? value[organs.voxels[n]] : std::nullopt;
    fine.voxels[n] = organ ? *organ : FixedValue(tissue).value_or(0.0F);
  }
  return Coarse(fine, num_threads);
}

Grid<float> PatientImage::Hu(int num_threads) const {
  Grid<float> fine(ct_.geometry);
  std::ranges::copy(ct_.voxels, fine.voxels.begin());
  return Coarse(fine, num_threads);
}

}  // namespace acus::atlas
