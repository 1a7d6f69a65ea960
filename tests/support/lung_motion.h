// How a lung moves from end expiration to end inspiration, by height: measured in patients
// (DIR-Lab), or simulated.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <numeric>
#include <vector>

#include "acus/base/core/csv.h"
#include "acus/base/math/statistics.h"

namespace acus::testing_support {

/// Places of tissue at end expiration, the height growing towards the head, and where it goes.
/// Components: anterior-posterior, left-right, superior-inferior, mm.
struct MovedLung {
  std::vector<double> height_mm;
  std::vector<Eigen::Vector3d> displacement_mm;

  /// In CT space, LPS.
  void Add(const Eigen::Vector3d& from_mm, const Eigen::Vector3d& to_mm) {
    const Eigen::Vector3d moved = to_mm - from_mm;
    height_mm.push_back(from_mm.z());
    displacement_mm.emplace_back(moved.y(), moved.x(), moved.z());
  }
};

/// Means over tenths of the places by height, the lowest first, and over all.
struct LungMotion {
  std::array<double, 10> by_height{};  ///< Along the body, relative to the lowest tenth.
  double lowest_mm = 0.0;              ///< Of the lowest tenth, a magnitude.
  double ap_share = 0.0;               ///< Mean |AP| over mean |SI|.
  double lr_share = 0.0;
};

inline LungMotion MotionOf(const MovedLung& lung) {
  std::vector<std::size_t> order(lung.height_mm.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::sort(order, {}, [&](std::size_t i) { return lung.height_mm[i]; });
  LungMotion motion;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t tenth = 0; tenth < 10; ++tenth) {
    std::vector<double> along_mm;
    for (std::size_t n = tenth * order.size() / 10; n < (tenth + 1) * order.size() / 10; ++n) {
      const Eigen::Vector3d& d = lung.displacement_mm[order[n]];
      along_mm.push_back(d.z());
      sum += d.cwiseAbs();
    }
    const double mean_mm = math::Mean(along_mm);
    if (tenth == 0) motion.lowest_mm = std::abs(mean_mm);
    motion.by_height[tenth] = std::abs(mean_mm) / motion.lowest_mm;
  }
  motion.ap_share = sum.x() / sum.z();
  motion.lr_share = sum.y() / sum.z();
  return motion;
}

/// Median of ten patients.
inline constexpr std::array kMedianByHeight = {1.0,  0.96, 0.82, 0.66, 0.54,
                                               0.46, 0.35, 0.29, 0.19, 0.09};
inline constexpr double kMedianApShare = 0.25;
inline constexpr double kMedianLrShare = 0.20;

/// Matched points of one patient: caseN.csv.
inline LungMotion MeasuredLungMotion(const std::filesystem::path& csv) {
  const CsvTable table(csv);
  MovedLung lung;
  const auto si = table.Numbers("si_mm"), ap = table.Numbers("d_ap_mm"),
             lr = table.Numbers("d_lr_mm"), down = table.Numbers("d_si_mm");
  for (std::size_t i = 0; i < si.size(); ++i) {
    lung.height_mm.push_back(-si[i]);
    lung.displacement_mm.emplace_back(ap[i], lr[i], down[i]);
  }
  return MotionOf(lung);
}

}  // namespace acus::testing_support
