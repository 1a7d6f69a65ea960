#include "acus/scene/simulation/pressed_skin.h"

#include <algorithm>
#include <cmath>

#include "acus/physics/tissue/displacement_functions.h"
#include "acus/scene/simulation/inside_length.h"

namespace acus::simulation {
namespace {

constexpr double kLookMm = 0.5;  // Step of the search for the skin, along the beam.
constexpr int kDepthBisections = 40;
constexpr double kLeastReach = 3.0;  // Times the depth: the map does not fold below 1.5.

}  // namespace

PressedSkin::PressedSkin(const tissue::ProbeFace& face, const Eigen::Isometry3d& ct_from_probe,
                         const forces::TissueLookup& tissue, const slicing::RestMap* next,
                         double spacing_mm) noexcept
    : face_(face), ct_from_probe_(ct_from_probe), next_(next), spacing_mm_(spacing_mm) {
  if (!ct_from_probe.matrix().allFinite()) return;
  const Eigen::Vector3d beam = ct_from_probe.linear().col(1);
  for (int i = 0; i < kLines; ++i) {
    const double x_mm = face_.length_mm * (static_cast<double>(i) / (kLines - 1) - 0.5);
    const Eigen::Vector3d on_face = ct_from_probe * Eigen::Vector3d(x_mm, face_.SurfaceMm(x_mm), 0);
    double& depth_mm = depth_mm_[static_cast<std::size_t>(i)];
    depth_mm = SkinAboveMm(on_face, beam, tissue);
    deepest_mm_ = std::max(deepest_mm_, depth_mm);
  }
  reach_mm_ = std::max(face_.length_mm, kLeastReach * deepest_mm_);
}

/// Distance of the skin behind a point of the face; 0 if the point is in air or too deep.
double PressedSkin::SkinAboveMm(const Eigen::Vector3d& face_in_ct_mm, const Eigen::Vector3d& beam,
                                const forces::TissueLookup& tissue) const noexcept {
  const auto in_air = [&](double above_mm) {
    const Eigen::Vector3d place_mm = face_in_ct_mm - above_mm * beam;
    return tissue.At(NextMm(place_mm, place_mm)) == 0;
  };
  return InsideLengthMm(in_air, kLookMm, kDeepestMm);
}

Eigen::Vector3d PressedSkin::NextMm(const Eigen::Vector3d& place_mm,
                                    const Eigen::Vector3d& guess_mm) const noexcept {
  return next_ == nullptr ? place_mm : next_->RestInCtMm(place_mm, guess_mm);
}

double PressedSkin::DepthMm(double x_mm) const noexcept {
  const double place =
      std::clamp(x_mm / face_.length_mm + 0.5, 0.0, 1.0) * static_cast<double>(kLines - 1);
  const int low = std::min(static_cast<int>(place), kLines - 2);
  const double share = place - low;
  return (1.0 - share) * depth_mm_[static_cast<std::size_t>(low)] +
         share * depth_mm_[static_cast<std::size_t>(low + 1)];
}

Eigen::Vector3d PressedSkin::RestInCtMm(const Eigen::Vector3d& place_in_ct_mm,
                                        const Eigen::Vector3d& guess_in_ct_mm) const noexcept {
  if (!presses()) return NextMm(place_in_ct_mm, guess_in_ct_mm);
  const Eigen::Vector3d at = ct_from_probe_.inverse() * place_in_ct_mm;
  const double half_mm = 0.5 * face_.length_mm;
  const double beside = tissue::Fade((std::abs(at.x()) - half_mm) / kBesideMm) *
                        tissue::Fade((std::abs(at.z()) - 0.5 * face_.width_mm) / kBesideMm);
  const double x_mm = std::clamp(at.x(), -half_mm, half_mm);
  const double depth_mm = DepthMm(x_mm);
  const double moved_mm = beside * depth_mm;
  // Depth of the point below the skin at rest.
  const double below_mm = at.y() - (face_.SurfaceMm(x_mm) - depth_mm);
  if (!(moved_mm > 0.0) || !(below_mm < reach_mm_ + moved_mm)) {
    return NextMm(place_in_ct_mm, guess_in_ct_mm);
  }
  const auto now_mm = [&](double rest_mm) {
    return rest_mm + moved_mm * tissue::Fade(std::abs(rest_mm) / reach_mm_);
  };
  double low_mm = below_mm - moved_mm;
  double high_mm = below_mm;
  for (int i = 0; i < kDepthBisections; ++i) {
    const double middle_mm = 0.5 * (low_mm + high_mm);
    (now_mm(middle_mm) < below_mm ? low_mm : high_mm) = middle_mm;
  }
  const Eigen::Vector3d back_mm =
      (0.5 * (low_mm + high_mm) - below_mm) * ct_from_probe_.linear().col(1);
  return NextMm(place_in_ct_mm + back_mm, guess_in_ct_mm + back_mm);
}

double PressedSkin::SpacingMm() const noexcept {
  return next_ == nullptr ? spacing_mm_ : std::min(spacing_mm_, next_->SpacingMm());
}

}  // namespace acus::simulation
