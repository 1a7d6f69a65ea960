// How a proxy comes into contact with the skin and with what is under it, for one or many proxies.
#pragma once

#include <Eigen/Core>

#include "acus/physics/forces/laws/hu_field.h"
#include "acus/physics/forces/probe/surface_proxy.h"

namespace acus::forces {

/// Follows the skin, or begins contact where the way from `before` to `place` meets it; after a
/// jump it is sought on the last 20 mm only.
void MeetSkin(const HuField& field, const SurfaceProxySettings& settings, SurfaceProxy& skin,
              const Eigen::Vector3d& before_in_ct_mm,
              const Eigen::Vector3d& place_in_ct_mm) noexcept;

/// Where a tool that is seen for the first time came from: it may have been on the skin before the
/// recording began. Against its beam, as far as the skin is sought; `place` itself if that is not
/// outside.
Eigen::Vector3d CameFrom(const HuField& field, const SurfaceProxySettings& settings,
                         const Eigen::Vector3d& place_in_ct_mm,
                         const Eigen::Vector3d& beam_in_ct) noexcept;

/// The same for a structure under the skin, which is sought on the line from the skin's proxy to
/// the device (Vidal-2008, section 3.3.1). Off the skin there is no contact.
void MeetStructure(const HuField& field, const SurfaceProxySettings& settings,
                   const SurfaceProxy& skin, SurfaceProxy& structure,
                   const Eigen::Vector3d& before_in_ct_mm,
                   const Eigen::Vector3d& place_in_ct_mm) noexcept;

/// Spreads a rise of the force that the springs do not explain by the way made, as after a jump of
/// the tracker. A plain value.
struct SuddenRise {
  double held_back = 0.0;  ///< Share of the force that is still held back.
  double model_n = 0.0;    ///< Size of the last force before that.

  /// The share of `force_n` to give now.
  /// @param stiffest_n_per_mm  by which the springs can explain a rise.
  double ShareToGive(double force_n, double travel_mm, double dt_s, double stiffest_n_per_mm,
                     double smoothing_s) noexcept;
};

/// Spring and damping of one proxy: damping never exceeds the spring (a jump is not a speed), and
/// the skin never pulls.
Eigen::Vector3d ContactForceN(const SurfaceProxy& skin, const Eigen::Vector3d& spring_n,
                              const Eigen::Vector3d& velocity_mm_per_s,
                              double damping_n_s_per_mm) noexcept;

}  // namespace acus::forces
