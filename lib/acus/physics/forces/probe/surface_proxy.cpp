#include "acus/physics/forces/probe/surface_proxy.h"

#include <algorithm>
#include <cmath>

namespace acus::forces {
namespace {

constexpr int kMostSlides = 4;
constexpr double kLongestSlideMm = 1.0;  // Per slide: the surface must be found again.
constexpr double kNearestMm = 1e-6;
constexpr double kNoiseMm = 1e-5;  // The surface is found to 1e-6 mm.
constexpr double kRoughMm =
    0.02;  // The same under a broad face, whose normal is not the place's own.

/// Towards lower values; the one before where the field is flat.
Eigen::Vector3d Outward(const HuField& field, double face_mm, const Eigen::Vector3d& place,
                        const Eigen::Vector3d& before) noexcept {
  const Eigen::Vector3d gradient = field.GradientHuPerMm(place, 0.5 * face_mm);
  const double size = gradient.norm();
  return size > 1e-6 ? Eigen::Vector3d(-gradient / size) : before;
}

/// The place of the surface on the line through `place` along the outward normal, at most
/// `reach_mm` away; `place` itself if there is none.
Eigen::Vector3d BackToSurface(const HuField& field, double hu, const Eigen::Vector3d& place,
                              const Eigen::Vector3d& outward, double reach_mm) noexcept {
  const bool inside = field.HuAt(place) >= hu;
  // From the side that is outside, inwards.
  const Eigen::Vector3d far = place + (inside ? reach_mm : -reach_mm) * outward;
  if ((field.HuAt(far) >= hu) == inside) return place;
  double low = 0.0;  // Same side as `place`.
  double high = 1.0;
  for (int i = 0; i < 20; ++i) {
    const double middle = 0.5 * (low + high);
    ((field.HuAt(place + middle * (far - place)) >= hu) == inside ? low : high) = middle;
  }
  return place + 0.5 * (low + high) * (far - place);
}

}  // namespace

void SurfaceProxy::Touch(const HuField& field, const SurfaceProxySettings& settings,
                         const Eigen::Vector3d& place) noexcept {
  touching = true;
  at_in_ct_mm = place;
  outward_in_ct = Outward(field, settings.face_mm, place, outward_in_ct);
}

void SurfaceProxy::Follow(const HuField& field, const SurfaceProxySettings& settings,
                          const Eigen::Vector3d& device) noexcept {
  if (!touching) return;
  const double noise_mm = settings.face_mm > 0.0 ? kRoughMm : kNoiseMm;
  for (int slide = 0; slide < kMostSlides; ++slide) {
    const Eigen::Vector3d to_device = device - at_in_ct_mm;
    const double height_mm = to_device.dot(outward_in_ct);
    Eigen::Vector3d along = to_device - height_mm * outward_in_ct;
    const double size_mm = along.norm();
    const double held_mm = settings.friction * std::max(0.0, -height_mm);
    if (size_mm <= held_mm + kNearestMm) break;
    along *= std::min(size_mm - held_mm, kLongestSlideMm) / size_mm;
    const Eigen::Vector3d next =
        BackToSurface(field, settings.hu, at_in_ct_mm + along, outward_in_ct, kLongestSlideMm);
    // Over a sharp edge or at noise the nearest place may be the one before: never go farther off.
    if ((device - next).norm() >= to_device.norm() + noise_mm) break;
    at_in_ct_mm = next;
    outward_in_ct = Outward(field, settings.face_mm, next, outward_in_ct);
  }
  if ((device - at_in_ct_mm).dot(outward_in_ct) > 0.0) touching = false;
}

}  // namespace acus::forces
