// A limb of six bumpy layers around each other: as surfaces of any number of triangles, as voxels,
// and in closed form.
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "acus/data/volume/volume.h"
#include "acus/imaging/acoustics/probe.h"
#include "acus/imaging/slicing/beam_bend.h"
#include "acus/imaging/slicing/tracing/surface_tracer.h"

namespace acus::benchmarks {

/// Skin, fat, muscle, bursa, tendon and bone around the origin; the skin's radius is about 80 mm.
class BumpyBalls {
 public:
  static constexpr int kNumLayers = 6;

  /// Tissue at a place, by the radius of each layer in that direction.
  static volume::Label LabelAt(const Eigen::Vector3d& place_mm);

  /// An icosahedron's faces cut in four `levels` times for each layer, outer layers first: 6 x 20 x
  /// 4^levels triangles; with 8 levels 7,864,320, as in Alamilla-2021.
  static std::vector<tracing::LabelledSurface> Surfaces(int levels);

  /// Filled as a scene of surfaces is. `fill_s` gets the CPU time.
  static volume::LabelMap Voxels(const std::vector<tracing::LabelledSurface>& surfaces,
                                 double spacing_mm, double& fill_s);

  /// A linear probe of 512 x 512 pixels, 40 x 50 mm, on the skin; the image ends in the bone.
  static acoustics::Probe Probe();
  static Eigen::Isometry3d CtFromProbe();
};

/// Tissue that a needle in the image's plane takes along by up to 3 mm, within 20 mm around it.
class TakenAlong : public slicing::RestMap {
 public:
  Eigen::Vector3d RestInCtMm(const Eigen::Vector3d& place_in_ct_mm,
                             const Eigen::Vector3d& guess_in_ct_mm) const noexcept override;
  double SpacingMm() const noexcept override { return 2.0; }
};

/// How far labels along the image's lines are from the closed form.
struct LabelErrors {
  double wrong_percent = 0.0;  ///< Share of pixels in the wrong tissue.
  double rms_mm = 0.0;         ///< Of the depth of boundaries, on lines that meet the same tissues.
  double most_mm = 0.0;        ///< The same, the largest.
  double lost_percent = 0.0;   ///< Lines that meet other tissues, or in another order.
};

/// @param rest  Null: as at rest.
LabelErrors ErrorsOfVoxels(const volume::LabelMap& labels, const slicing::RestMap* rest);
LabelErrors ErrorsOfTriangles(const tracing::SurfaceTracer& tracer, const slicing::RestMap* rest);

}  // namespace acus::benchmarks
