#include "acus/physics/forces/probe/proxy_contact.h"

#include <algorithm>
#include <cmath>

namespace acus::forces {
namespace {

constexpr double kFarthestSkinFromToolMm =
    20.0;                                 // The skin is sought at most so far behind the tool.
constexpr double kFastestMmPerS = 500.0;  // Beyond it, it is the tracker that jumped.
constexpr double kSuddenN = 0.05;  // A rise beyond what the springs give for the way is smoothed.

}  // namespace

void MeetSkin(const HuField& field, const SurfaceProxySettings& settings, SurfaceProxy& skin,
              const Eigen::Vector3d& before, const Eigen::Vector3d& place) noexcept {
  if (skin.touching) {
    skin.Follow(field, settings, place);
    return;
  }
  const Eigen::Vector3d way = place - before;
  const double length_mm = way.norm();
  const double share =
      length_mm > kFarthestSkinFromToolMm ? kFarthestSkinFromToolMm / length_mm : 1.0;
  const Eigen::Vector3d from = place - share * way;
  const double crossing = field.FirstCrossing(from, place, settings.hu);
  if (crossing > 1.0) return;
  skin.outward_in_ct = length_mm > 0.0 ? Eigen::Vector3d(-way / length_mm)
                                       : Eigen::Vector3d(Eigen::Vector3d::UnitZ());
  skin.Touch(field, settings, from + crossing * (place - from));
  skin.Follow(field, settings, place);
}

Eigen::Vector3d CameFrom(const HuField& field, const SurfaceProxySettings& settings,
                         const Eigen::Vector3d& place, const Eigen::Vector3d& beam) noexcept {
  const double length = beam.norm();
  if (!(length > 0.5 && length < 2.0)) return place;
  const Eigen::Vector3d from = place - beam * (kFarthestSkinFromToolMm / length);
  return field.HuAt(from) < settings.hu ? from : place;
}

void MeetStructure(const HuField& field, const SurfaceProxySettings& settings,
                   const SurfaceProxy& skin, SurfaceProxy& structure, const Eigen::Vector3d& before,
                   const Eigen::Vector3d& place) noexcept {
  if (!skin.touching) {
    structure.touching = false;
    return;
  }
  if (structure.touching) {
    structure.Follow(field, settings, place);
    return;
  }
  const Eigen::Vector3d line = place - skin.at_in_ct_mm;
  const double crossing = field.FirstCrossing(skin.at_in_ct_mm, place, settings.hu);
  if (crossing > 1.0) return;
  const double beyond_mm = (1.0 - crossing) * line.norm();
  const Eigen::Vector3d travel_mm = place - before;
  structure.outward_in_ct = skin.outward_in_ct;
  if (beyond_mm <= travel_mm.norm() + field.ResolutionMm()) {
    structure.Touch(field, settings, skin.at_in_ct_mm + crossing * line);
  } else if (field.HuAt(place) >= settings.hu) {
    // Pushed into its side: it pushes back from where the device came in. A device that slid below
    // it through soft tissue has no force: a force out of nowhere would throw the hand.
    const double side = field.FirstCrossing(before, place, settings.hu);
    structure.Touch(field, settings, before + std::min(side, 1.0) * travel_mm);
  }
  structure.Follow(field, settings, place);
}

double SuddenRise::ShareToGive(double force_n, double travel_mm, double dt_s,
                               double stiffest_n_per_mm, double smoothing_s) noexcept {
  if (smoothing_s <= 0.0) return 1.0;
  held_back *= std::exp(-dt_s / smoothing_s);
  const double rise_n =
      kSuddenN + 2.0 * stiffest_n_per_mm * std::min(travel_mm, kFastestMmPerS * dt_s);
  if (force_n > model_n + rise_n) {
    const double before_n = (1.0 - held_back) * model_n;
    held_back = 1.0 - before_n / force_n;
  }
  model_n = force_n;
  return 1.0 - held_back;
}

Eigen::Vector3d ContactForceN(const SurfaceProxy& skin, const Eigen::Vector3d& spring_n,
                              const Eigen::Vector3d& velocity_mm_per_s,
                              double damping_n_s_per_mm) noexcept {
  Eigen::Vector3d damping_n = -damping_n_s_per_mm * velocity_mm_per_s;
  const double most_n = spring_n.norm();
  if (damping_n.norm() > most_n) damping_n *= most_n / damping_n.norm();
  Eigen::Vector3d force_n = spring_n + damping_n;
  const double outwards_n = force_n.dot(skin.outward_in_ct);
  if (outwards_n < 0.0) force_n -= outwards_n * skin.outward_in_ct;
  return force_n;
}

}  // namespace acus::forces
