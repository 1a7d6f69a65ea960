// Tissue around a palpating tool in the images: pressed in to the depth of the tool's proxies below
// the skin.
#pragma once

#include <array>

#include "acus/imaging/slicing/beam_bend.h"
#include "acus/physics/forces/laws/hu_field.h"
#include "acus/physics/forces/probe/palpation_tool.h"

namespace acus::simulation {

/// Maps tissue to where it was before a tool pressed it: a rest map before all others. Proxy i, at
/// depth d_i below the skin against the tool's axis n, presses the tissue along n by
///   D(x) = max_i (d_i - kAcross * max(0, across_i(x) - plateau) - kAlong * along_i(x))+,
/// the least indentation of these slopes that reaches all proxies (McShane 1934); rest = x - n D.
/// Along n its slope is at most kAlong < 1, so that no two points have the same rest position.
/// Fortmeier-2016, section 2.2: for images only, it does not affect forces.
class PressedByProxies : public slicing::RestMap {
 public:
  static constexpr double kAcross = 1.0;      ///< The skin falls off at 45 degrees, mm per mm.
  static constexpr double kAlong = 0.25;      ///< Displacements vanish 4 d below, mm per mm.
  static constexpr double kDeepestMm = 30.0;  ///< A proxy deeper in the body presses nothing.

  /// Searches the skin behind each proxy: up to 120 points, and bisection.
  /// @param skin        The skin is where it passes `skin_value`; above it is tissue.
  /// @param next        The next map; may be null. Must outlive this, as must `skin`.
  /// @param spacing_mm  Distance over which the map may be taken as linear.
  PressedByProxies(const forces::PalpationTool& tool, const Eigen::Isometry3d& ct_from_tool,
                   const forces::HuField& skin, double skin_value, const slicing::RestMap* next,
                   double spacing_mm) noexcept;

  /// False: no proxy is below the skin, and the map has the bits of the next one.
  bool presses() const noexcept { return num_ > 0; }
  /// D, mm. >= 0.
  double DepthMm(const Eigen::Vector3d& place_in_ct_mm) const noexcept;

  Eigen::Vector3d RestInCtMm(const Eigen::Vector3d& place_in_ct_mm,
                             const Eigen::Vector3d& guess_in_ct_mm) const noexcept override;
  double SpacingMm() const noexcept override;

 private:
  double SkinBehindMm(const Eigen::Vector3d& place_mm, const forces::HuField& skin,
                      double skin_value) const noexcept;
  Eigen::Vector3d NextMm(const Eigen::Vector3d& place_mm,
                         const Eigen::Vector3d& guess_mm) const noexcept;

  const slicing::RestMap* next_;
  double spacing_mm_;
  double plateau_mm_;     ///< Between proxies the skin does not rise.
  Eigen::Vector3d axis_;  ///< n, into the body.
  int num_ = 0;           ///< Number of proxies below the skin.
  std::array<Eigen::Vector3d, forces::PalpationTool::kMostNodes> place_mm_;
  std::array<double, forces::PalpationTool::kMostNodes> depth_mm_;
};

}  // namespace acus::simulation
