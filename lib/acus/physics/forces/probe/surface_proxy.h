// A point that stays on a surface of a field while the device goes in behind it: the proxy of
// Vidal-2008, on an isosurface of the CT instead of a polygon mesh made from it.
#pragma once

#include <Eigen/Core>

#include "acus/physics/forces/laws/hu_field.h"

namespace acus::forces {

struct SurfaceProxySettings {
  double hu = 0.0;        ///< The surface: where the field passes this value.
  double friction = 0.0;  ///< Coefficient: the proxy slides only beyond the cone, >= 0.
  double face_mm = 0.0;   ///< The normal is that over such a length: a broad tool feels no noise.
};

/// A plain value.
struct SurfaceProxy {
  bool touching = false;
  Eigen::Vector3d at_in_ct_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d outward_in_ct = Eigen::Vector3d::UnitZ();  ///< Unit normal, to lower values.

  /// From the device back to the proxy; zero unless touching.
  Eigen::Vector3d PenetrationMm(const Eigen::Vector3d& device_in_ct_mm) const noexcept {
    return touching ? Eigen::Vector3d(at_in_ct_mm - device_in_ct_mm) : Eigen::Vector3d::Zero();
  }

  /// Begins contact at this place.
  void Touch(const HuField& field, const SurfaceProxySettings& settings,
             const Eigen::Vector3d& place_in_ct_mm) noexcept;

  /// Moves the proxy along the surface towards the point that is nearest to the device; lets go
  /// when the device is on the outer side. Does nothing unless touching.
  void Follow(const HuField& field, const SurfaceProxySettings& settings,
              const Eigen::Vector3d& device_in_ct_mm) noexcept;
};

}  // namespace acus::forces
