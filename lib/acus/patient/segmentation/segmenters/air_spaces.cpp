#include <algorithm>

#include "acus/patient/segmentation/segmenters/tissues.h"

namespace acus::segmentation {
namespace {

constexpr std::int16_t kDensestInLungHu = 200;  ///< Vessels with contrast agent.
constexpr double kWholeLungMl = 300.0;          ///< Of a lung that the CT does not cut above.
constexpr double kLeastCutMm2 = 100.0;
constexpr double kLargestLungHoleMm2 = 400.0;  ///< Of a vessel in a slice of the lung.

/// Median HU by component, of voxels all of whose face neighbours are in the component too: edges
/// are mixed with tissue.
std::vector<int> CoreMedians(const volume::CtVolume& ct, const Components& components) {
  const auto& number = components.number;
  const auto& size = ct.geometry.size;
  std::vector<std::vector<std::int16_t>> cores(components.num_voxels.size());
  for (int k = 1; k + 1 < size[2]; ++k) {
    for (int j = 1; j + 1 < size[1]; ++j) {
      for (int i = 1; i + 1 < size[0]; ++i) {
        const std::int32_t n = number.At(i, j, k);
        if (n == 0 || number.At(i - 1, j, k) != n || number.At(i + 1, j, k) != n ||
            number.At(i, j - 1, k) != n || number.At(i, j + 1, k) != n ||
            number.At(i, j, k - 1) != n || number.At(i, j, k + 1) != n) {
          continue;
        }
        cores[static_cast<std::size_t>(n)].push_back(ct.At(i, j, k));
      }
    }
  }
  std::vector<int> medians;
  for (auto& core : cores) medians.push_back(MedianHu(core));
  return medians;
}

/// 1 for components with nothing of the body above a part of them: what the CT cuts.
std::vector<std::uint8_t> CutAbove(const Components& components, const Mask& body) {
  const volume::Geometry& g = body.geometry;
  const int axis = AxialAxis(g);
  Eigen::Array3i up = Eigen::Array3i::Zero();
  up[axis] = g.direction(2, axis) > 0.0 ? 1 : -1;
  std::vector<double> cut_mm2(components.num_voxels.size(), 0.0);
  for (int k = 0; k < g.size[2]; ++k) {
    for (int j = 0; j < g.size[1]; ++j) {
      for (int i = 0; i < g.size[0]; ++i) {
        const Eigen::Array3i above = Eigen::Array3i(i, j, k) + up;
        if (g.Contains(above[0], above[1], above[2]) &&
            body.At(above[0], above[1], above[2]) != 0) {
          continue;
        }
        cut_mm2[static_cast<std::size_t>(components.number.At(i, j, k))] +=
            g.voxel_volume_mm3() / g.spacing_mm[axis];
      }
    }
  }
  std::vector<std::uint8_t> is_cut;
  for (const double area_mm2 : cut_mm2) is_cut.push_back(area_mm2 >= kLeastCutMm2 ? 1 : 0);
  return is_cut;
}

}  // namespace

AirSpaces FindAirSpaces(const volume::CtVolume& ct, const Mask& body, const TissueOptions& options,
                        int num_threads) {
  Mask air(ct.geometry);
  for (std::size_t i = 0; i < air.voxels.size(); ++i) {
    air.voxels[i] = body.voxels[i] != 0 && ct.voxels[i] < options.air_threshold_hu ? 1 : 0;
  }
  const Components components = ConnectedComponents(air);
  const std::vector<int> medians = CoreMedians(ct, components);
  const std::vector<std::uint8_t> is_cut = CutAbove(components, body);
  const double ml = ct.geometry.voxel_volume_mm3() / 1000.0;
  AirSpaces out;
  out.lung = Kept(components, [&](std::int32_t n) {
    const auto at = static_cast<std::size_t>(n);
    // Bowel gas among stool is as dense as lung, but a lung continues upwards or is seen whole.
    const double least_ml =
        is_cut[at] != 0 ? options.lung_min_ml : std::max(options.lung_min_ml, kWholeLungMl);
    return static_cast<double>(components.num_voxels[at]) * ml >= least_ml &&
           medians[at] > options.gas_median_hu;
  });
  out.gas = Mask(ct.geometry);
  for (std::size_t i = 0; i < air.voxels.size(); ++i) {
    out.gas.voxels[i] = air.voxels[i] != 0 && out.lung.voxels[i] == 0 ? 1 : 0;
  }
  // Vessels and bronchial walls belong to the lung.
  Mask filled = Closed(out.lung, options.lung_closing_mm, num_threads);
  const double pixel_mm2 =
      ct.geometry.voxel_volume_mm3() / ct.geometry.spacing_mm[AxialAxis(ct.geometry)];
  FillInSlices(filled, AxialAxis(ct.geometry), num_threads, [&](const SliceRegion& region) {
    return !region.touches_border &&
           static_cast<double>(region.voxels.size()) * pixel_mm2 < kLargestLungHoleMm2;
  });
  for (std::size_t i = 0; i < filled.voxels.size(); ++i) {
    if (filled.voxels[i] != 0 && body.voxels[i] != 0 && out.gas.voxels[i] == 0 &&
        ct.voxels[i] < kDensestInLungHu) {
      out.lung.voxels[i] = 1;
    }
  }
  return out;
}

}  // namespace acus::segmentation
