// Rest positions of the tissue that an image shows.
#pragma once

#include "acus/imaging/slicing/beam_bend.h"
#include "acus/physics/tissue/tissue_model.h"

namespace acus::simulation {

/// Inverts a tissue model's displacements, for one image at a time. One for each thread.
class DeformedTissue : public slicing::RestMap {
 public:
  /// @param model  Must outlive this.
  /// @param beyond_skin  Models with a mesh move nothing outside of it: in a dent of the skin, no
  ///     tissue maps to such a point. True: the point maps above the skin, displaced as the skin
  ///     next to it, so that dents show. False: it maps to the nearest tissue.
  DeformedTissue(const tissue::TissueModel& model, double spacing_mm, int iterations,
                 bool beyond_skin = false)
      : field_(model.NewField()),
        spacing_mm_(spacing_mm),
        iterations_(iterations),
        beyond_skin_(beyond_skin) {}

  /// Takes in the forces on the tissue. Allocates nothing after the first call.
  void Update(const tissue::TissueLoad& load) { field_.Update(load); }

  Eigen::Vector3d RestInCtMm(const Eigen::Vector3d& place_in_ct_mm,
                             const Eigen::Vector3d& guess_in_ct_mm) const noexcept override;
  double SpacingMm() const noexcept override { return spacing_mm_; }

 private:
  tissue::TissueField field_;
  double spacing_mm_;
  int iterations_;
  bool beyond_skin_;
};

}  // namespace acus::simulation
