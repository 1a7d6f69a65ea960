// What one interface sends back and lets through: Fresnel's law for fluids, and a rough mirror.
#pragma once

#include <Eigen/Core>

#include "acus/data/volume/volume.h"
#include "acus/imaging/ultrasound/beams/beam_materials.h"
#include "acus/imaging/ultrasound/beams/beam_options.h"

namespace acus::ultrasound {

/// Amplitudes, relative to what arrives.
struct InterfaceEcho {
  double echo = 0.0;          ///< Towards the probe, with its sign.
  double reflection = 0.0;    ///< Fresnel's, whatever its direction.
  double transmission = 1.0;  ///< Two-way: 1 - R^2, or that of bone and gas.
};

/// R = (Z2 cos a1 - Z1 cos a2) / (Z2 cos a1 + Z1 cos a2); |R| = 1 beyond the critical angle.
/// @param impedance_ratio  Z2 / Z1.
/// @param speed_ratio      c2 / c1.
double FresnelReflection(double impedance_ratio, double speed_ratio, double cos_incidence);

/// Share of a rough mirror's echo that comes back to the probe: 1 at normal incidence.
double MirrorLobe(double cos_incidence, double lobe_deg, double diffuse_share);

/// Cosine of the angle between beams and the surfaces of tissues, from the voxels around.
class SurfaceNormals {
 public:
  explicit SurfaceNormals(const BeamTissue& tissue);

  /// How a beam meets the surface.
  struct Angles {
    double cos_incidence = 1.0;  ///< |cos| between the beam and the normal.
    double tan_in_plane = 0.0;   ///< Slope of the surface along the next line, in the plane.
  };

  /// Unit normal at a place (voxel indices), in mm along the voxel axes; zero where there is none.
  /// `before`, `after`: label (or Hounsfield unit) on both sides.
  Eigen::Vector3d At(const Eigen::Vector3d& index, float before, float after) const;

  /// `step`: along the beam, `across`: to the next line, both in voxels.
  Angles AnglesTo(const Eigen::Vector3d& index, const Eigen::Vector3d& step,
                  const Eigen::Vector3d& across, float before, float after) const;

  /// Steps of the beam from a place between two labels to where they weigh the same, trilinearly:
  /// there are no stairs then. 0 in a CT, which is smooth.
  double SamplesToSurface(const Eigen::Vector3d& index, const Eigen::Vector3d& step, float before,
                          float after) const;

 private:
  Eigen::Vector3d OfLabels(const Eigen::Array3i& voxel, int before, int after) const;
  double SideAt(const Eigen::Vector3d& index, int before, int after) const;
  Eigen::Vector3d OfHu(const Eigen::Array3i& voxel) const;

  const BeamTissue& tissue_;
  Eigen::Array3i size_;
  Eigen::Array3d spacing_mm_;
};

}  // namespace acus::ultrasound
