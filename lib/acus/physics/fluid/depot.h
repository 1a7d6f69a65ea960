// The region that injected fluid fills, as an ultrasound image shows it: numbers only.
#pragma once

#include "acus/physics/fluid/fluid_model.h"

namespace acus::fluid {

/// An ellipsoid of revolution about the normal of the layers that it opens.
struct Depot {
  double liquid_ml = 0.0;
  double air_ml = 0.0;
  double width_radius_mm = 0.0;      ///< Along the layers.
  double thickness_radius_mm = 0.0;  ///< Across them; the same in tissue without layers.
  double wet_share = 0.0;  ///< Share of fluid in its volume that is new: 1 in a cavity, dark.
};

/// V = 4/3 pi w^2 t with t = flatness w, V = fluid volume / fluid_share.
Depot DepotOf(const FluidTissue& tissue, const TissueFluid& fluid) noexcept;

}  // namespace acus::fluid
