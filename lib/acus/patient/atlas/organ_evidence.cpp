#include "acus/patient/atlas/organ_evidence.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "acus/data/volume/labels.h"
#include "acus/patient/segmentation/organ_checks.h"
#include "acus/patient/segmentation/voxels/line_filter.h"
#include "acus/patient/segmentation/voxels/metrics.h"
#include "acus/patient/segmentation/voxels/trilinear.h"

namespace acus::atlas {
namespace {

using segmentation::Mask;
using segmentation::OrganEvidence;
using volume::Grid;

constexpr double kEdgeStepHu = 15.0;   // Least difference across an edge.
constexpr double kEdgeOffsetMm = 3.0;  // Farthest steepest change from the surface.
constexpr double kStepMm = 1.5;        // Along the normal.
constexpr int kReachSteps = 5;         // To both sides.
constexpr double kNormalBlurMm = 3.0;

double ShareOf(double part, double all) {
  return all > 0.0 ? part / all : 0.0;
}

/// HU across the surface, from inside to outside.
struct Edge {
  double step_hu = 0.0;    ///< Between the means inside and outside.
  double offset_mm = 0.0;  ///< Of the steepest change, > 0 outside.
};

Edge EdgeAt(const Grid<float>& hu, const Eigen::Vector3d& index, const Eigen::Vector3d& outwards) {
  std::array<double, 2 * kReachSteps + 1> along{};
  const double step = kStepMm / hu.geometry.spacing_mm[0];
  for (int n = -kReachSteps; n <= kReachSteps; ++n) {
    along[static_cast<std::size_t>(n + kReachSteps)] =
        segmentation::TrilinearAt(hu, index + n * step * outwards);
  }
  Edge edge;
  double inside = 0.0, outside = 0.0, steepest = -1.0;
  for (std::size_t n = 0; n < 3; ++n) {
    inside += along[n] / 3.0;
    outside += along[along.size() - 1 - n] / 3.0;
  }
  edge.step_hu = std::abs(inside - outside);
  for (int n = 1 - kReachSteps; n < kReachSteps; ++n) {
    const auto at = static_cast<std::size_t>(n + kReachSteps);
    const double change = std::abs(along[at + 1] - along[at - 1]);
    if (change > steepest) {
      steepest = change;
      edge.offset_mm = n * kStepMm;
    }
  }
  return edge;
}

/// The outward normal of a blurred mask, in voxels; zero where it has none.
Eigen::Vector3d OutwardsAt(const Grid<float>& soft, const Eigen::Vector3i& at) {
  Eigen::Vector3d slope = Eigen::Vector3d::Zero();
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d d = Eigen::Vector3d::Unit(axis);
    slope[axis] = segmentation::TrilinearAt(soft, at.cast<double>() - d) -
                  segmentation::TrilinearAt(soft, at.cast<double>() + d);
  }
  const double length = slope.norm();
  return length > 0.0 ? Eigen::Vector3d(slope / length) : slope;
}

bool IsOnSurface(const Mask& mask, const Eigen::Vector3i& at) {
  for (int axis = 0; axis < 3; ++axis) {
    for (const int side : {-1, 1}) {
      const Eigen::Vector3i v = at + side * Eigen::Vector3i::Unit(axis);
      if (mask.geometry.Contains(v[0], v[1], v[2]) && mask.At(v[0], v[1], v[2]) == 0) return true;
    }
  }
  return false;
}

/// Share of the surface that lies at an edge of the CT.
double EdgeShare(const FoundOrgan& found, const Mask& part, int num_threads) {
  Grid<float> soft(part.geometry);
  std::ranges::copy(part.voxels, soft.voxels.begin());
  soft = segmentation::Blurred(soft, kNormalBlurMm, num_threads);
  double all = 0.0, edges = 0.0;
  const Eigen::Array3i& size = part.geometry.size;
  for (int k = 0; k < size[2]; ++k) {
    for (int j = 0; j < size[1]; ++j) {
      for (int i = 0; i < size[0]; ++i) {
        const Eigen::Vector3i at(i, j, k);
        if (part.At(i, j, k) == 0 || !IsOnSurface(part, at)) continue;
        const Eigen::Vector3d outwards = OutwardsAt(soft, at);
        // The surface lies half a voxel outside the last voxel of the organ.
        const Edge edge = EdgeAt(found.search.hu, at.cast<double>() + 0.5 * outwards, outwards);
        ++all;
        const bool is_held =
            edge.step_hu >= kEdgeStepHu && std::abs(edge.offset_mm) <= kEdgeOffsetMm;
        edges += is_held ? 1.0 : 0.0;
      }
    }
  }
  return ShareOf(edges, all);
}

/// Share of the voxels of a region that have one of some labels.
template <std::size_t kCount>
double LabelledShare(const Mask& region, const volume::LabelMap& tissues,
                     const std::array<volume::Label, kCount>& labels) {
  double all = 0.0, those = 0.0;
  for (std::size_t n = 0; n < region.voxels.size(); ++n) {
    if (region.voxels[n] == 0) continue;
    ++all;
    those += std::ranges::find(labels, tissues.voxels[n]) != labels.end() ? 1.0 : 0.0;
  }
  return ShareOf(those, all);
}

double SharedPart(const Mask& region, const Mask& other) {
  double all = 0.0, both = 0.0;
  for (std::size_t n = 0; n < region.voxels.size(); ++n) {
    all += region.voxels[n] != 0 ? 1.0 : 0.0;
    both += region.voxels[n] != 0 && other.voxels[n] != 0 ? 1.0 : 0.0;
  }
  return ShareOf(both, all);
}

/// The part of that name; empty if there is none.
Mask PartNamed(const std::string& name, const std::string& tissue, const Mask& organ,
               const std::optional<double>& middle_x_mm) {
  for (auto& [part_name, mask] : segmentation::OrganParts(tissue, organ, middle_x_mm)) {
    if (part_name == name) return std::move(mask);
  }
  return Mask(organ.geometry);
}

}  // namespace

std::vector<OrganEvidence> EvidenceOf(const std::string& tissue, const FoundOrgan& found,
                                      const std::optional<double>& middle_x_mm, int num_threads) {
  static const std::array kBarred = {volume::Label{0},        volume::LabelOf("skin"),
                                     volume::LabelOf("lung"), volume::LabelOf("gas"),
                                     volume::LabelOf("bone"), volume::LabelOf("spinal_canal")};
  Mask organ(found.u.geometry), expected(found.u.geometry);
  for (std::size_t n = 0; n < organ.voxels.size(); ++n) {
    organ.voxels[n] = found.u.voxels[n] > 0.5F ? 1 : 0;
    expected.voxels[n] = found.search.prior_mm.voxels[n] > 0.0F ? 1 : 0;
  }
  std::vector<OrganEvidence> out;
  for (const auto& [name, part] : segmentation::OrganParts(tissue, organ, middle_x_mm)) {
    const Mask wanted = PartNamed(name, tissue, expected, middle_x_mm);
    out.push_back({.name = name,
                   .edge_share = EdgeShare(found, part, num_threads),
                   .barred_share = LabelledShare(wanted, found.tissues, kBarred),
                   .covered_share = SharedPart(part, found.covered)});
  }
  return out;
}

}  // namespace acus::atlas
