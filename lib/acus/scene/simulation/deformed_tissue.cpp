#include "acus/scene/simulation/deformed_tissue.h"

#include "acus/base/math/inverse_map.h"

namespace acus::simulation {

Eigen::Vector3d DeformedTissue::RestInCtMm(const Eigen::Vector3d& place_in_ct_mm,
                                           const Eigen::Vector3d& guess_in_ct_mm) const noexcept {
  // A hundredth of a millimetre is far below an image's pixel.
  const math::InverseSettings settings{.max_iterations = iterations_, .tolerance_mm = 0.01};
  const auto displacement = [this](const Eigen::Vector3d& rest_mm) {
    return field_.DisplacementMm(rest_mm);
  };
  // Tissue that has not moved is at rest, whatever happens around it.
  if (displacement(place_in_ct_mm).isZero(0.0)) return place_in_ct_mm;
  const math::InversePoint found =
      math::InvertDisplacement(displacement, place_in_ct_mm, guess_in_ct_mm, settings);
  // A larger residual is not due to a lack of iterations.
  constexpr double kNoTissueMm = 0.2;
  if (beyond_skin_ && found.residual_mm > kNoTissueMm) {
    return place_in_ct_mm - displacement(found.rest_mm);
  }
  return found.rest_mm;
}

}  // namespace acus::simulation
