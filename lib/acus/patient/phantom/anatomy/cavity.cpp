#include "acus/patient/phantom/anatomy/cavity.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>
#include <utility>

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

constexpr double kBesideHeartMm = 40.0;  // To the right of the middle there is no heart.
constexpr std::size_t kFewestColumns = 30;

/// Heights at which the lung ends above at least 24 mm of something else, in columns left of
/// `last_i` in the grid, which is on the patient's right.
std::vector<double> LungEndsMm(const volume::Grid<Label>& labels, const Kinds& kinds, int last_i) {
  const volume::Geometry& g = labels.geometry;
  std::vector<double> heights;
  for (int j = 0; j < g.size[1]; ++j) {
    for (int i = 0; i < std::min(last_i, g.size[0]); ++i) {
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
  return heights;
}

/// Height of the domes: of the right one, since lung on the left also ends above the heart.
double DomeZ(const volume::Grid<Label>& labels, const Kinds& kinds, double middle_i) {
  const int right = static_cast<int>(middle_i - kBesideHeartMm / kGridMm);
  std::vector<double> heights = LungEndsMm(labels, kinds, right);
  if (heights.size() <= kFewestColumns) {
    heights = LungEndsMm(labels, kinds, labels.geometry.size[0]);
  }
  ACUS_REQUIRE(heights.size() > kFewestColumns,
               "breathing motion: no diaphragm is found: the labels need lung above other tissue");
  return math::Quantile(heights, 0.85);
}

constexpr double kAboveDomeMm = 15.0;  // Lung that begins higher lies on the heart.

DiaphragmHeight DiaphragmOf(const volume::Grid<Label>& labels, const Kinds& kinds,
                            double dome_z_mm) {
  const volume::Geometry& g = labels.geometry;
  std::vector<double> lowest_mm;
  for (int j = 0; j < g.size[1]; ++j) {
    for (int i = 0; i < g.size[0]; ++i) {
      int k = 0;
      while (k < g.size[2] && labels.At(i, j, k) != kinds.lung) ++k;
      const double z_mm = g.origin_mm.z() + kGridMm * k;
      lowest_mm.push_back(k < g.size[2] && z_mm < dome_z_mm + kAboveDomeMm ? z_mm : NAN);
    }
  }
  return {g.origin_mm.head<2>(), kGridMm, g.size.head<2>(), lowest_mm, dome_z_mm};
}

double MiddleOf(const std::vector<segmentation::TrunkSlice>& slices) {
  std::vector<double> middle;
  for (const segmentation::TrunkSlice& slice : slices) {
    if (slice.body) middle.push_back(slice.middle_x);
  }
  return math::Median(middle);
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

constexpr double kLeastLungDepthMm = 60.0;  // Depth of a volume that shows hardly any lung.

/// y between which 98 % of the lung lies, the front first.
std::pair<double, double> LungDepth(const volume::Grid<Label>& labels, const Kinds& kinds) {
  const volume::Geometry& g = labels.geometry;
  std::vector<double> y_mm;
  for (int k = 0; k < g.size[2]; ++k) {
    for (int j = 0; j < g.size[1]; ++j) {
      for (int i = 0; i < g.size[0]; ++i) {
        if (labels.At(i, j, k) == kinds.lung) y_mm.push_back(g.origin_mm.y() + kGridMm * j);
      }
    }
  }
  const double front_mm = math::Quantile(y_mm, 0.01);
  return {front_mm, std::max(math::Quantile(y_mm, 0.99), front_mm + kLeastLungDepthMm)};
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

constexpr double kDiaphragmSmoothMm = 15.0;
constexpr double kFarWeight = 1e-6;  // Weight of the value far from every known column.

/// A Gaussian along one axis of a grid, without its constant factor.
std::vector<double> SmoothedAlong(int axis, const std::vector<double>& in,
                                  const Eigen::Array2i& size, double sigma) {
  const int reach = static_cast<int>(std::ceil(3.0 * sigma));
  std::vector<double> out(in.size(), 0.0);
  for (int j = 0; j < size[1]; ++j) {
    for (int i = 0; i < size[0]; ++i) {
      double& sum = out[static_cast<std::size_t>(j) * size[0] + i];
      const int at = axis == 0 ? i : j;
      for (int n = std::max(0, at - reach); n <= std::min(size[axis] - 1, at + reach); ++n) {
        const double away = (n - at) / sigma;
        const std::size_t from = axis == 0 ? static_cast<std::size_t>(j) * size[0] + n
                                           : static_cast<std::size_t>(n) * size[0] + i;
        sum += std::exp(-0.5 * away * away) * in[from];
      }
    }
  }
  return out;
}

}  // namespace

DiaphragmHeight::DiaphragmHeight(const Eigen::Vector2d& first_mm, double spacing_mm,
                                 Eigen::Array2i size, std::span<const double> lowest_mm,
                                 double otherwise_mm)
    : first_mm_(first_mm), spacing_mm_(spacing_mm), size_(size) {
  std::vector<double> weight, weighted;
  for (const double height_mm : lowest_mm) {
    const bool known = !std::isnan(height_mm);
    weight.push_back(known ? 1.0 : 0.0);
    weighted.push_back(known ? height_mm : 0.0);
  }
  for (const int axis : {0, 1}) {
    weight = SmoothedAlong(axis, weight, size, kDiaphragmSmoothMm / spacing_mm);
    weighted = SmoothedAlong(axis, weighted, size, kDiaphragmSmoothMm / spacing_mm);
  }
  height_mm_.resize(weight.size());
  for (std::size_t n = 0; n < weight.size(); ++n) {
    height_mm_[n] = (weighted[n] + kFarWeight * otherwise_mm) / (weight[n] + kFarWeight);
  }
}

double DiaphragmHeight::AtMm(double x_mm, double y_mm) const noexcept {
  const Eigen::Array2d last = (size_ - 1).cast<double>();
  const Eigen::Array2d at =
      ((Eigen::Array2d(x_mm, y_mm) - first_mm_.array()) / spacing_mm_).max(0.0).min(last);
  const Eigen::Array2i base = at.cast<int>();
  const Eigen::Array2d t = at - base.cast<double>();
  const auto weights = [](double s) {
    const double r = 1.0 - s;
    return std::array{r * r * r / 6.0, (4.0 - 6.0 * s * s + 3.0 * s * s * s) / 6.0,
                      (4.0 - 6.0 * r * r + 3.0 * r * r * r) / 6.0, s * s * s / 6.0};
  };
  const std::array<double, 4> wx = weights(t[0]), wy = weights(t[1]);
  double sum_mm = 0.0;
  for (int b = 0; b < 4; ++b) {
    const int j = std::clamp(base[1] + b - 1, 0, size_[1] - 1);
    for (int a = 0; a < 4; ++a) {
      const int i = std::clamp(base[0] + a - 1, 0, size_[0] - 1);
      sum_mm += wx[static_cast<std::size_t>(a)] * wy[static_cast<std::size_t>(b)] *
                height_mm_[static_cast<std::size_t>(j) * size_[0] + i];
    }
  }
  return sum_mm;
}

Cavity FindCavity(const volume::LabelMap& labels, const RunContext& context) {
  context.Checkpoint("finding the cavity", 0.0);
  const Kinds kinds;
  const auto wall = segmentation::FindTrunkWall(labels, context.num_threads);
  ACUS_REQUIRE(wall, "breathing motion: no spine is found in the labels");
  const volume::Grid<Label>& coarse = wall->labels;
  const volume::Geometry& g = coarse.geometry;
  const std::vector<segmentation::TrunkSlice>& slices = wall->slices;
  Cavity cavity;
  cavity.dome_z_mm = DomeZ(coarse, kinds, MiddleOf(slices));
  cavity.diaphragm = DiaphragmOf(coarse, kinds, cavity.dome_z_mm);
  const int top = LungTop(coarse, kinds);
  cavity.top_z_mm = top < g.size[2] ? g.origin_mm.z() + kGridMm * top : cavity.dome_z_mm + 160.0;
  std::tie(cavity.lung_front_mm, cavity.lung_back_mm) = LungDepth(coarse, kinds);
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
