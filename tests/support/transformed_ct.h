// A CT as another scan of the same patient would show it: cut, with thick slices, tilted, noisy.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "acus/base/core/random.h"
#include "acus/data/volume/volume.h"
#include "acus/patient/segmentation/voxels/crop.h"

namespace acus::testing_support {

/// A CT with values of a label map on the same grid, which may be empty.
struct LabelledCt {
  volume::CtVolume ct;
  volume::Grid<std::int32_t> labels;
};

/// The voxels from `low` to `high`, both included.
inline LabelledCt CutTo(const LabelledCt& from, const Eigen::Array3i& low,
                        const Eigen::Array3i& high) {
  const segmentation::Box box{low.max(0), high.min(from.ct.geometry.size - 1)};
  LabelledCt out{segmentation::Cropped(from.ct, box), {}};
  if (!from.labels.voxels.empty()) out.labels = segmentation::Cropped(from.labels, box);
  return out;
}

/// Means over `count` slices along the third axis; of labels the middle slice.
inline LabelledCt Thickened(const LabelledCt& from, int count) {
  volume::Geometry g = from.ct.geometry;
  g.size[2] /= count;
  g.origin_mm += g.direction.col(2) * (0.5 * (count - 1) * g.spacing_mm[2]);
  g.spacing_mm[2] *= count;
  LabelledCt out{volume::CtVolume(g), {}};
  if (!from.labels.voxels.empty()) out.labels = volume::Grid<std::int32_t>(g);
  for (int k = 0; k < g.size[2]; ++k) {
    for (int j = 0; j < g.size[1]; ++j) {
      for (int i = 0; i < g.size[0]; ++i) {
        double sum = 0.0;
        for (int n = 0; n < count; ++n) sum += from.ct.At(i, j, k * count + n);
        out.ct.At(i, j, k) = static_cast<std::int16_t>(std::lround(sum / count));
        if (!out.labels.voxels.empty()) {
          out.labels.At(i, j, k) = from.labels.At(i, j, k * count + count / 2);
        }
      }
    }
  }
  return out;
}

/// Every `count`-th column and row, of means over as many.
inline LabelledCt Coarsened(const LabelledCt& from, int count) {
  volume::Geometry g = from.ct.geometry;
  for (const int axis : {0, 1}) {
    g.size[axis] /= count;
    g.origin_mm += g.direction.col(axis) * (0.5 * (count - 1) * g.spacing_mm[axis]);
    g.spacing_mm[axis] *= count;
  }
  LabelledCt out{volume::CtVolume(g), {}};
  if (!from.labels.voxels.empty()) out.labels = volume::Grid<std::int32_t>(g);
  for (int k = 0; k < g.size[2]; ++k) {
    for (int j = 0; j < g.size[1]; ++j) {
      for (int i = 0; i < g.size[0]; ++i) {
        double sum = 0.0;
        for (int n = 0; n < count * count; ++n) {
          sum += from.ct.At(i * count + n % count, j * count + n / count, k);
        }
        out.ct.At(i, j, k) = static_cast<std::int16_t>(std::lround(sum / (count * count)));
        if (!out.labels.voxels.empty()) {
          out.labels.At(i, j, k) = from.labels.At(i * count + count / 2, j * count + count / 2, k);
        }
      }
    }
  }
  return out;
}

/// The patient turned about an axis through the middle of the volume; air where it was not seen.
inline LabelledCt Turned(const LabelledCt& from, const Eigen::Vector3d& axis, double angle_rad) {
  const volume::Geometry& g = from.ct.geometry;
  const Eigen::Vector3d middle = g.ct_from_index() * (0.5 * (g.size - 1).cast<double>()).matrix();
  const Eigen::Affine3d back = g.index_from_ct() * Eigen::Translation3d(middle) *
                               Eigen::AngleAxisd(-angle_rad, axis) * Eigen::Translation3d(-middle) *
                               g.ct_from_index();
  LabelledCt out{volume::CtVolume(g, volume::kPaddingHu), {}};
  if (!from.labels.voxels.empty()) out.labels = volume::Grid<std::int32_t>(g);
  for (int k = 0; k < g.size[2]; ++k) {
    for (int j = 0; j < g.size[1]; ++j) {
      for (int i = 0; i < g.size[0]; ++i) {
        const Eigen::Array3d at = (back * Eigen::Vector3d(i, j, k)).array();
        if ((at < 0.0).any() || (at > (g.size - 1).cast<double>()).any()) continue;
        const Eigen::Array3i low = at.cast<int>().min(g.size - 2).max(0);
        const Eigen::Array3d part = at - low.cast<double>();
        double sum = 0.0;
        for (int c = 0; c < 8; ++c) {
          const Eigen::Array3i one(c & 1, (c >> 1) & 1, c >> 2);
          const double weight = (one == 1).select(part, 1.0 - part).prod();
          if (weight > 0.0) {
            sum += weight * from.ct.At(low[0] + one[0], low[1] + one[1], low[2] + one[2]);
          }
        }
        out.ct.At(i, j, k) = static_cast<std::int16_t>(std::lround(sum));
        if (!out.labels.voxels.empty()) {
          const Eigen::Array3i nearest = at.round().cast<int>();
          out.labels.At(i, j, k) = from.labels.At(nearest[0], nearest[1], nearest[2]);
        }
      }
    }
  }
  return out;
}

/// With independent normal noise in each voxel.
inline LabelledCt Noisy(LabelledCt from, double sd_hu) {
  RandomStream random(1, "noise of a transformed CT");
  for (auto& hu : from.ct.voxels) {
    hu = static_cast<std::int16_t>(std::lround(hu + sd_hu * random.Normal()));
  }
  return from;
}

}  // namespace acus::testing_support
