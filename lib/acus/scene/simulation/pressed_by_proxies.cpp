#include "acus/scene/simulation/pressed_by_proxies.h"

#include <algorithm>
#include <cmath>

#include "acus/scene/simulation/inside_length.h"

namespace acus::simulation {
namespace {

constexpr double kSkinLookMm = 0.25;
/// Radius of the plateau in distances between proxies: the centre of four of them is at 0.71.
constexpr double kPlateau = 0.75;

/// Mean distance of proxies to the nearest other one, mm; 0 for a single one.
double SpacingOfProxies(const forces::PalpationTool& tool) noexcept {
  double sum_mm = 0.0;
  for (int i = 0; i < tool.num_nodes; ++i) {
    double nearest_mm = INFINITY;
    for (int j = 0; j < tool.num_nodes; ++j) {
      if (i == j) continue;
      const auto a = static_cast<std::size_t>(i), b = static_cast<std::size_t>(j);
      nearest_mm = std::min(nearest_mm, (tool.node_mm[a] - tool.node_mm[b]).norm());
    }
    if (std::isfinite(nearest_mm)) sum_mm += nearest_mm / tool.num_nodes;
  }
  return sum_mm;
}

}  // namespace

PressedByProxies::PressedByProxies(const forces::PalpationTool& tool,
                                   const Eigen::Isometry3d& ct_from_tool,
                                   const forces::HuField& skin, double skin_value,
                                   const slicing::RestMap* next, double spacing_mm) noexcept
    : next_(next),
      spacing_mm_(spacing_mm),
      plateau_mm_(kPlateau * SpacingOfProxies(tool)),
      axis_(ct_from_tool.linear().col(1)) {
  if (!ct_from_tool.matrix().allFinite()) return;
  for (int i = 0; i < tool.num_nodes; ++i) {
    const Eigen::Vector3d place_mm = ct_from_tool * tool.node_mm[static_cast<std::size_t>(i)];
    const double depth_mm = SkinBehindMm(place_mm, skin, skin_value);
    if (!(depth_mm > 0.0)) continue;
    place_mm_[static_cast<std::size_t>(num_)] = place_mm;
    depth_mm_[static_cast<std::size_t>(num_)] = depth_mm;
    ++num_;
  }
}

/// Distance of the skin behind a point; 0 if the point is in air or too deep.
double PressedByProxies::SkinBehindMm(const Eigen::Vector3d& place_mm, const forces::HuField& skin,
                                      double skin_value) const noexcept {
  const auto in_air = [&](double behind_mm) {
    const Eigen::Vector3d behind = place_mm - behind_mm * axis_;
    return skin.HuAt(NextMm(behind, behind)) < skin_value;
  };
  return InsideLengthMm(in_air, kSkinLookMm, kDeepestMm);
}

Eigen::Vector3d PressedByProxies::NextMm(const Eigen::Vector3d& place_mm,
                                         const Eigen::Vector3d& guess_mm) const noexcept {
  return next_ == nullptr ? place_mm : next_->RestInCtMm(place_mm, guess_mm);
}

double PressedByProxies::DepthMm(const Eigen::Vector3d& place_in_ct_mm) const noexcept {
  double most_mm = 0.0;
  for (int i = 0; i < num_; ++i) {
    const auto n = static_cast<std::size_t>(i);
    const Eigen::Vector3d off = place_in_ct_mm - place_mm_[n];
    const double along_mm = off.dot(axis_);
    const double left_mm = depth_mm_[n] - kAlong * std::abs(along_mm);
    if (left_mm <= most_mm) continue;
    const double across_mm = std::max(0.0, (off - along_mm * axis_).norm() - plateau_mm_);
    most_mm = std::max(most_mm, left_mm - kAcross * across_mm);
  }
  return most_mm;
}

Eigen::Vector3d PressedByProxies::RestInCtMm(const Eigen::Vector3d& place_in_ct_mm,
                                             const Eigen::Vector3d& guess_in_ct_mm) const noexcept {
  const double depth_mm = DepthMm(place_in_ct_mm);
  if (!(depth_mm > 0.0)) return NextMm(place_in_ct_mm, guess_in_ct_mm);
  const Eigen::Vector3d back_mm = -depth_mm * axis_;
  return NextMm(place_in_ct_mm + back_mm, guess_in_ct_mm + back_mm);
}

double PressedByProxies::SpacingMm() const noexcept {
  return next_ == nullptr ? spacing_mm_ : std::min(spacing_mm_, next_->SpacingMm());
}

}  // namespace acus::simulation
