// What must hold of vessels, ducts and a lesion that were put into a liver.
#pragma once

#include <cmath>
#include <gtest/gtest.h>
#include <map>
#include <set>
#include <string>

#include "acus/data/volume/labels.h"
#include "acus/patient/phantom/anatomy/liver_ducts.h"
#include "acus/patient/segmentation/voxels/mask.h"

namespace acus::testing_support {

/// Axes by `radius + margin` inside the liver that was, by brute force over points of them.
inline void CheckClearance(const volume::Grid<float>& distance_mm, const phantom::DuctSegment& tube,
                           double margin_mm) {
  const volume::Geometry& g = distance_mm.geometry;
  for (int n = 0; n <= 20; ++n) {
    const Eigen::Vector3d at = tube.from_mm + (tube.to_mm - tube.from_mm) * n / 20.0;
    const Eigen::Vector3d index = g.index_from_ct() * at;
    const Eigen::Array3i voxel = index.array().round().cast<int>();
    ASSERT_TRUE(g.Contains(voxel[0], voxel[1], voxel[2]));
    EXPECT_GE(distance_mm.At(voxel[0], voxel[1], voxel[2]), tube.radius_mm + margin_mm);
  }
}

inline void CheckTree(const std::vector<phantom::DuctSegment>& tree) {
  std::map<int, std::vector<double>> branches;
  for (std::size_t i = 0; i < tree.size(); ++i) {
    if (i == 0) {
      EXPECT_EQ(tree[i].parent, -1);
      continue;
    }
    ASSERT_GE(tree[i].parent, 0);
    ASSERT_LT(tree[i].parent, static_cast<int>(i));
    EXPECT_EQ(tree[i].from_mm, tree[static_cast<std::size_t>(tree[i].parent)].to_mm);
    branches[tree[i].parent].push_back(tree[i].radius_mm);
  }
  for (const auto& [parent, radii] : branches) {
    ASSERT_EQ(radii.size(), 2U);
    const double r = tree[static_cast<std::size_t>(parent)].radius_mm;
    EXPECT_NEAR(std::pow(radii[0], 3) + std::pow(radii[1], 3), std::pow(r, 3), 1e-9 * r * r * r);
  }
}

/// Voxels with a label that were liver before, as a mask.
inline segmentation::Mask NewVoxels(const volume::LabelMap& before, const volume::LabelMap& after,
                                    const char* tissue) {
  segmentation::Mask mask(after.geometry);
  for (std::size_t n = 0; n < mask.voxels.size(); ++n) {
    if (before.voxels[n] == after.voxels[n]) continue;
    EXPECT_EQ(before.voxels[n], volume::LabelOf("liver"));
    mask.voxels[n] = after.voxels[n] == volume::LabelOf(tissue) ? 1 : 0;
  }
  return mask;
}

/// Mean HU over the voxels that share the label with all six around them.
inline double MeanHuInside(const volume::CtVolume& ct, const segmentation::Mask& mask) {
  double sum = 0.0, count = 0.0;
  const volume::Geometry& g = mask.geometry;
  for (int k = 1; k + 1 < g.size[2]; ++k) {
    for (int j = 1; j + 1 < g.size[1]; ++j) {
      for (int i = 1; i + 1 < g.size[0]; ++i) {
        if (mask.At(i, j, k) == 0) continue;
        if (mask.At(i - 1, j, k) + mask.At(i + 1, j, k) + mask.At(i, j - 1, k) +
                mask.At(i, j + 1, k) + mask.At(i, j, k - 1) + mask.At(i, j, k + 1) <
            6) {
          continue;
        }
        sum += ct.At(i, j, k);
        count += 1.0;
      }
    }
  }
  EXPECT_GT(count, 50.0);
  return sum / count;
}

inline void CheckLiverDucts(const volume::CtVolume& ct, const volume::LabelMap& labels,
                            const phantom::LiverDuctSettings& settings,
                            const phantom::LiverDucts& made) {
  segmentation::Mask not_liver(labels.geometry);
  for (std::size_t n = 0; n < labels.voxels.size(); ++n) {
    not_liver.voxels[n] = labels.voxels[n] == volume::LabelOf("liver") ? 0 : 1;
  }
  const auto distance_mm = segmentation::DistanceMm(not_liver, 1);
  CheckTree(made.vessels);
  CheckTree(made.ducts);
  for (const auto* tree : {&made.vessels, &made.ducts}) {
    for (const auto& tube : *tree) CheckClearance(distance_mm, tube, settings.margin_mm);
  }
  for (const auto& vessel : made.vessels) {
    for (const auto& duct : made.ducts) {
      EXPECT_GE(phantom::AxisDistanceMm(vessel, duct),
                vessel.radius_mm + duct.radius_mm + settings.margin_mm - 1e-9);
    }
  }
  const std::pair<const char*, double> structures[] = {{"vessel", settings.vessel_hu},
                                                       {"gallbladder", settings.duct_hu},
                                                       {"lesion", settings.lesion_hu}};
  for (const auto& [tissue, hu] : structures) {
    const segmentation::Mask mask = NewVoxels(labels, made.labels, tissue);
    EXPECT_EQ(segmentation::ConnectedComponents(mask).num_voxels.size(), 2U) << tissue;
    EXPECT_NEAR(MeanHuInside(made.ct, mask), hu, 3.0) << tissue;
  }
  std::size_t changed = 0, changed_elsewhere = 0;
  for (std::size_t n = 0; n < ct.voxels.size(); ++n) {
    changed += ct.voxels[n] != made.ct.voxels[n] ? 1 : 0;
    changed_elsewhere += ct.voxels[n] != made.ct.voxels[n] && not_liver.voxels[n] != 0 ? 1 : 0;
  }
  EXPECT_GT(changed, 100U);
  EXPECT_EQ(changed_elsewhere, 0U);
}

}  // namespace acus::testing_support
