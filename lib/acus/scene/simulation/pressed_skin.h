// Tissue under a probe in the images of models that the probe does not deform: pressed in to the
// depth of the face below the skin.
#pragma once

#include <array>

#include "acus/imaging/slicing/beam_bend.h"
#include "acus/physics/forces/laws/tissue_lookup.h"
#include "acus/physics/tissue/probe_contact.h"

namespace acus::simulation {

/// Maps tissue below the face of a probe to where it was before the probe pressed it: a rest map
/// before all others. The skin, d(x) above the face along the beam, lies on the face; below it
/// displacements along the beam fade with depth, and beside the face with the distance from it, by
/// 1 - 3 t^2 + 2 t^3. Prescribed, not computed: tissue does not resist
/// (docs/models/forces_probe.md).
class PressedSkin : public slicing::RestMap {
 public:
  static constexpr double kDeepestMm = 30.0;  ///< A face deeper in the body presses nothing.
  static constexpr double kBesideMm = 15.0;   ///< Width beside the face in which they fade.

  /// Searches the skin above the face: 17 lines of up to 60 labels.
  /// @param next  The next map; may be null. Must outlive this.
  PressedSkin(const tissue::ProbeFace& face, const Eigen::Isometry3d& ct_from_probe,
              const forces::TissueLookup& tissue, const slicing::RestMap* next,
              double spacing_mm) noexcept;

  /// False: no part of the face is below the skin, and the map has the bits of the next one.
  bool presses() const noexcept { return deepest_mm_ > 0.0; }
  /// Depth of the face below the skin, at x along the face, mm; 0 for a point beside it.
  double DepthMm(double x_mm) const noexcept;

  Eigen::Vector3d RestInCtMm(const Eigen::Vector3d& place_in_ct_mm,
                             const Eigen::Vector3d& guess_in_ct_mm) const noexcept override;
  double SpacingMm() const noexcept override;

 private:
  static constexpr int kLines = 17;

  double SkinAboveMm(const Eigen::Vector3d& face_in_ct_mm, const Eigen::Vector3d& beam,
                     const forces::TissueLookup& tissue) const noexcept;
  Eigen::Vector3d NextMm(const Eigen::Vector3d& place_mm,
                         const Eigen::Vector3d& guess_mm) const noexcept;

  tissue::ProbeFace face_;
  Eigen::Isometry3d ct_from_probe_;
  const slicing::RestMap* next_;
  double spacing_mm_;
  double reach_mm_ = 0.0;  ///< Depth below the skin at which displacements vanish.
  double deepest_mm_ = 0.0;
  std::array<double, kLines> depth_mm_{};
};

}  // namespace acus::simulation
