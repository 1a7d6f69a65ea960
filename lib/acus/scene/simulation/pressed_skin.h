// Tissue under a probe in the images of models that the probe does not deform: pressed in as far as
// its face is in the skin.
#pragma once

#include <array>

#include "acus/imaging/slicing/beam_bend.h"
#include "acus/physics/forces/laws/tissue_lookup.h"
#include "acus/physics/tissue/probe_contact.h"

namespace acus::simulation {

/// Where tissue below the face of a probe was before the probe pressed it: a rest map in front of
/// all others. The skin, d(x) above the face along the beam, lies on the face; below it
/// displacements along the beam fade with depth, and beside the face with the distance from it, by
/// 1 - 3 t^2 + 2 t^3. Known, not computed: tissue does not resist (docs/models/forces_probe.md).
class PressedSkin : public slicing::RestMap {
 public:
  static constexpr double kDeepestMm = 30.0;  ///< A face deeper in the body presses nothing.
  static constexpr double kBesideMm = 15.0;   ///< Beside the face displacements are gone after it.

  /// Looks for the skin above the face: 17 lines of up to 60 labels.
  /// @param next  what moves tissue besides; may be null. Must outlive this.
  PressedSkin(const tissue::ProbeFace& face, const Eigen::Isometry3d& ct_from_probe,
              const forces::TissueLookup& tissue, const slicing::RestMap* next,
              double spacing_mm) noexcept;

  /// False: the face is nowhere in the skin, and the map is that of the next, bit for bit.
  bool presses() const noexcept { return deepest_mm_ > 0.0; }
  /// Of the face in the skin, at x along it, mm; 0 for a place beside it.
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
  double reach_mm_ = 0.0;  ///< Below the skin displacements are gone after it.
  double deepest_mm_ = 0.0;
  std::array<double, kLines> depth_mm_{};
};

}  // namespace acus::simulation
