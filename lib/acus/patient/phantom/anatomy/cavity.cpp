#include "acus/patient/phantom/anatomy/cavity.h"

#include <algorithm>
#include <cmath>

#include "acus/base/math/statistics.h"
#include "acus/data/volume/labels.h"
#include "acus/patient/segmentation/segmenters/trunk_wall.h"

namespace acus::phantom {
namespace {

using segmentation::Mask;
using volume::Label;

constexpr double kGridMm = segmentation::TrunkWall::kGridMm;

struct Kinds {
  Label bone = volume::LabelOf("bone");
  Label lung = volume::LabelOf("lung");
  Label skin = volume::LabelOf("skin");
};

/// Height of the domes: where the lung ends above at least 24 mm of something else.
double DomeZ(const volume::Grid<Label>& labels, const Kinds& kinds) {
  const volume::Geometry& g = labels.geometry;
  std::vector<double> heights;
  for (int j = 0; j < g.size[1]; ++j) {
    for (int i = 0; i < g.size[0]; ++i) {
      int lowest = 0;
      while (lowest < g.size[2] && labels.At(i, j, lowest) != kinds.lung) ++lowest;
      if (lowest == g.size[2] || lowest < 8) continue;
      bool within = true;
      for (int k = lowest - 8; k < lowest; ++k) {
        const Label here = labels.At(i, j, k);
        within = within && here != 0 && here != kinds.bone && here != kinds.skin;
      }
      if (within) heights.push_back(g.origin_mm.z() + kGridMm * lowest);
    }
  }
  ACUS_REQUIRE(heights.size() > 30,
               "breathing motion: no diaphragm is found: the labels need lung above other tissue");
  return math::Quantile(heights, 0.85);
}

/// The lung's top, in slices; the number of slices if the volume cuts it.
int LungTop(const volume::Grid<Label>& labels, const Kinds& kinds) {
  const volume::Geometry& g = labels.geometry;
  const std::size_t slice = g.Index(0, 0, 1);
  for (int k = g.size[2] - 1; k >= 0; --k) {
    const auto begin = labels.voxels.begin() + static_cast<std::ptrdiff_t>(slice) * k;
    if (std::count(begin, begin + static_cast<std::ptrdiff_t>(slice), kinds.lung) > 20) {
      return k >= g.size[2] - 2 ? g.size[2] : k;
    }
  }
  return g.size[2];
}

/// Fills what of each column along the body lies between cavity within 45 mm: rays do not see
/// behind folds, and organs would be pressed on the ledges that are left.
void FillColumns(Mask& inside, const Mask& bone) {
  const volume::Geometry& g = inside.geometry;
  const int longest = static_cast<int>(45.0 / kGridMm);
  for (int j = 0; j < g.size[1]; ++j) {
    for (int i = 0; i < g.size[0]; ++i) {
      int last = -1;
      for (int k = 0; k < g.size[2]; ++k) {
        if (inside.At(i, j, k) == 0) continue;
        for (int gap = last + 1; last >= 0 && k - last <= longest && gap < k; ++gap) {
          if (bone.At(i, j, gap) == 0) inside.At(i, j, gap) = 1;
        }
        last = k;
      }
    }
  }
}

}  // namespace

Cavity FindCavity(const volume::LabelMap& labels, const RunContext& context) {
  context.Checkpoint("finding the cavity", 0.0);
  const Kinds kinds;
  const auto wall = segmentation::FindTrunkWall(labels, context.num_threads);
  ACUS_REQUIRE(wall, "breathing motion: no spine is found in the labels");
  const volume::Grid<Label>& coarse = wall->labels;
  const volume::Geometry& g = coarse.geometry;
  const std::vector<segmentation::TrunkSlice>& slices = wall->slices;
  Cavity cavity;
  cavity.dome_z_mm = DomeZ(coarse, kinds);
  const int top = LungTop(coarse, kinds);
  cavity.top_z_mm = top < g.size[2] ? g.origin_mm.z() + kGridMm * top : cavity.dome_z_mm + 160.0;
  Mask inside = wall->inside;
  const Mask lung =
      segmentation::Closed(segmentation::MaskOf(coarse, kinds.lung), 4.5, context.num_threads);
  const Mask bone =
      segmentation::Dilated(segmentation::MaskOf(coarse, kinds.bone), 3.1, context.num_threads);
  for (std::size_t n = 0; n < inside.voxels.size(); ++n) {
    const bool above = static_cast<int>(n / g.Index(0, 0, 1)) > top;
    const bool in =
        !above && ((inside.voxels[n] != 0 && bone.voxels[n] == 0) || lung.voxels[n] != 0);
    inside.voxels[n] = in ? 1 : 0;
  }
  FillColumns(inside, bone);
  const auto parts = segmentation::ConnectedComponents(inside);
  const auto largest = std::ranges::max_element(parts.num_voxels) - parts.num_voxels.begin();
  inside = segmentation::Kept(parts, [&](std::int32_t number) { return number == largest; });
  cavity.wall = SmoothLevel(inside, 4.0, 0.0, context.num_threads);
  const int dome = std::clamp(static_cast<int>((cavity.dome_z_mm - g.origin_mm.z()) / kGridMm), 0,
                              g.size[2] - 1);
  const segmentation::TrunkSlice& slice = slices[static_cast<std::size_t>(dome)];
  cavity.middle_x_mm = g.origin_mm.x() + kGridMm * slice.middle_x;
  cavity.spine_front_mm = g.origin_mm.y() + kGridMm * slice.spine_y;
  double front = slice.front_y;
  for (const segmentation::TrunkSlice& other : slices)
    front = other.body ? std::min(front, other.front_y) : front;
  cavity.skin_front_mm = g.origin_mm.y() + kGridMm * front;
  return cavity;
}

volume::LabelMap LabelsOf(const Cavity& cavity) {
  volume::LabelMap labels(cavity.wall.geometry());
  labels.names[1] = "cavity";
  const volume::Geometry& g = labels.geometry;
  for (int k = 0; k < g.size[2]; ++k) {
    for (int j = 0; j < g.size[1]; ++j) {
      for (int i = 0; i < g.size[0]; ++i) {
        const Eigen::Vector3d p = g.ct_from_index() * Eigen::Vector3d(i, j, k);
        labels.At(i, j, k) = cavity.wall.LevelMm(p) < 0.0 ? 1 : 0;
      }
    }
  }
  return labels;
}

}  // namespace acus::phantom
