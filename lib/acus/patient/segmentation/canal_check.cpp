#include "acus/patient/segmentation/canal_check.h"

#include <algorithm>
#include <cmath>

#include "acus/base/core/text_table.h"
#include "acus/data/volume/labels.h"
#include "acus/patient/segmentation/segmenters/tissues.h"
#include "acus/patient/segmentation/voxels/mask.h"

namespace acus::segmentation {
namespace {

constexpr double kLeastCanalLengthMm = 60.0;  ///< Two vertebrae.
constexpr double kLeastMeanAreaMm2 = 80.0;
constexpr double kMostMeanAreaMm2 = 450.0;
constexpr double kAroundMm = 4.0;
constexpr double kLeastBoneAround = 0.25;
constexpr double kMostBesideMm = 40.0;

double MedianOf(std::vector<double>& values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

/// Fills all but `doubts`.
CanalCheck Measures(const volume::LabelMap& labels, int num_threads) {
  static const volume::Label kBone = volume::LabelOf("bone");
  const volume::Geometry& g = labels.geometry;
  const auto axis = static_cast<Eigen::Index>(AxialAxis(g));
  const Mask canal = MaskOf(labels, volume::LabelOf("spinal_canal"));
  const Box box = BoundsOf(canal);
  const Mask near =
      Dilated(canal, std::max(kAroundMm, 1.01 * g.spacing_mm.minCoeff()), num_threads);
  CanalCheck out;
  out.length_mm = (box.high[axis] - box.low[axis] + 1) * g.spacing_mm[axis];
  double x_mm = 0.0, count = 0.0, around = 0.0, bone = 0.0;
  std::vector<double> bone_x_mm;
  for (int k = 0; k < g.size[2]; ++k) {
    for (int j = 0; j < g.size[1]; ++j) {
      for (int i = 0; i < g.size[0]; ++i) {
        const Eigen::Array3i at(i, j, k);
        if (at[axis] < box.low[axis] || at[axis] > box.high[axis]) continue;
        const double here_mm = (g.ct_from_index() * at.cast<double>().matrix()).x();
        const bool is_bone = labels.At(i, j, k) == kBone;
        if (is_bone) bone_x_mm.push_back(here_mm);
        if (canal.At(i, j, k) != 0) {
          x_mm += here_mm;
          ++count;
        } else if (near.At(i, j, k) != 0) {
          ++around;
          bone += is_bone ? 1.0 : 0.0;
        }
      }
    }
  }
  out.area_mm2 = count * g.voxel_volume_mm3() / out.length_mm;
  out.bone_around = bone / std::max(around, 1.0);
  out.beside_middle_mm = std::abs(x_mm / count - MedianOf(bone_x_mm));
  return out;
}

}  // namespace

CanalCheck CheckCanal(const volume::LabelMap& labels, int num_threads) {
  CanalCheck out = Measures(labels, num_threads);
  if (out.length_mm < kLeastCanalLengthMm) {
    out.doubts.push_back(Message("only ", FixedText(out.length_mm, 0), " mm long"));
  }
  if (out.area_mm2 < kLeastMeanAreaMm2 || out.area_mm2 > kMostMeanAreaMm2) {
    out.doubts.push_back(Message("a mean cross-section of ", FixedText(out.area_mm2, 0),
                                 " mm2, which no adult has"));
  }
  if (out.bone_around < kLeastBoneAround) {
    out.doubts.push_back(
        Message("bone is only ", FixedText(100.0 * out.bone_around, 0), " % of what surrounds it"));
  }
  if (out.beside_middle_mm > kMostBesideMm) {
    out.doubts.push_back(
        Message(FixedText(out.beside_middle_mm, 0), " mm beside the middle of the bone"));
  }
  return out;
}

}  // namespace acus::segmentation
