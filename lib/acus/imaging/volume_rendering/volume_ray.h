// One ray through the CT of a patient who breathes, with the surfaces that it meets.
#pragma once

#include <Eigen/Dense>
#include <span>

#include "acus/data/volume/volume.h"
#include "acus/imaging/volume_rendering/cut_planes.h"
#include "acus/imaging/volume_rendering/fragments.h"
#include "acus/imaging/volume_rendering/hidden_cells.h"
#include "acus/imaging/volume_rendering/maximum_projection.h"
#include "acus/imaging/volume_rendering/pressed_tissue.h"
#include "acus/imaging/volume_rendering/shading.h"
#include "acus/imaging/volume_rendering/shadow_map.h"
#include "acus/imaging/volume_rendering/slope_volume.h"
#include "acus/imaging/volume_rendering/transfer_function.h"
#include "acus/imaging/volume_rendering/visible_blocks.h"
#include "acus/imaging/volume_rendering/warp_lattice.h"
#include "acus/imaging/volume_rendering/warped_ray.h"
#include "acus/physics/breathing/motion_map.h"

namespace acus::volume_rendering {

/// What is behind is not seen any more.
inline constexpr float kDark = 0.004F;
/// Below this slope, tissue has no surface that light could fall on.
inline constexpr float kSurfaceHuPerMm = 40.0F;

/// How the volume is sampled.
struct RaySettings {
  double step_mm = 1.0;
  WarpSettings warp;
  /// Where neighbours differ by no more than this share of full scale in all channels, pixels
  /// between them are interpolated: see FirstPixels(). 0: every pixel has its ray.
  double pixel_tolerance = 0.0;
  double tool_shine = 0.35;  ///< What is seen of a tool behind tissue; 0: what light gets through.
  Projection projection = Projection::kEmission;
  HuWindow window = {};  ///< Of kMaximum.
};

/// What is there for all rays of an image.
struct VolumeScene {
  const volume::CtVolume* ct = nullptr;  ///< Null: surfaces only.
  /// What light falls on: of `ct`, smoothed. Null for Projection::kMaximum.
  const SlopeVolume* slopes = nullptr;
  const TransferFunction* transfer = nullptr;  ///< May be null for kMaximum.
  const TissueClasses* classes = nullptr;      ///< Null: `transfer` has none.
  const VisibleBlocks* blocks = nullptr;
  const HiddenCells* hidden = nullptr;           ///< Null: every sample is looked at.
  const breathing::MotionMap* motion = nullptr;  ///< Null: at rest.
  const WarpLattice* lattice = nullptr;          ///< Of `motion`; null: every sample is inverted.
  const ShadowMap* shadows = nullptr;            ///< Null: none.
  const PressedTissue* pressed = nullptr;        ///< After breath; null: tools press nothing.
  std::span<const CutPlane> cuts = {};           ///< Of the CT.
  Light light;
};

struct RayColour {
  Eigen::Array3f colour = Eigen::Array3f::Zero();  ///< Weighted by opacity.
  float opacity = 0.0F;
};

/// Light along rays from one eye: emission and absorption, front to back, or what else Projection
/// says. Samples lie at whole multiples of the step from the eye, whatever is jumped over; where
/// the patient breathes, a WarpedRay gives what is there. One ray at a time: the reference of
/// TileCaster, and for volumes that it cannot address.
class RayCaster {
 public:
  RayCaster(const VolumeScene& scene, const RaySettings& settings, const Eigen::Vector3d& eye_mm);

  /// Beyond any volume.
  static constexpr float kFarMm = 1e5F;

  /// Distance up to which nothing of the CT can show on any ray within the cone around `middle`
  /// that the rays of `rim` span: so far neighbours need not look for themselves. Unit, CT space.
  /// kFarMm: nothing shows at all.
  float EmptyUntilMm(const Eigen::Vector3d& middle, std::span<const Eigen::Vector3d> rim) const;

  /// @param direction  Unit, CT space.
  /// @param fragments  By rising distance.
  /// @param empty_mm  Nothing of the CT shows before that.
  RayColour Cast(const Eigen::Vector3d& direction, std::span<const Fragment> fragments,
                 float empty_mm = 0.0F) const;

 private:
  struct March;
  void CastVolume(March& march, float empty_mm) const;
  void Step(March& march, float enter_mm, float leave_mm) const;
  void TakeMaximum(March& march, const Eigen::Vector3f& index) const;
  void TakeSample(March& march, const Eigen::Vector3f& index, float at_mm) const;
  Eigen::Vector3f RestIndex(March& march, int sample, const Eigen::Vector3f& in_blocks,
                            const Eigen::Array3i& block) const;
  Eigen::Vector3f PressedIndex(March& march, const Eigen::Vector3f& place_mm) const;
  TransferFunction::Emission EmissionAt(const Eigen::Vector3f& index, float hu_before,
                                        float hu) const noexcept;
  float HuAt(const volume::CtVolume& ct, const Eigen::Vector3f& index) const noexcept;
  Eigen::Vector3f GradientAt(const Eigen::Vector3f& index) const noexcept;
  Eigen::Array3f ColourAt(const March& march, const Eigen::Array3f& colour,
                          const Eigen::Vector3f& index, float distance_mm) const;
  void Absorb(March& march, const TransferFunction::Emission& emission, float from_mm, float to_mm,
              const Eigen::Vector3f& index) const;
  int NextVisible(const March& march, int sample, const Eigen::Vector3f& in_blocks,
                  const Eigen::Array3i& block, int distance) const;

  VolumeScene scene_;
  RaySettings settings_;
  Eigen::Vector3d eye_mm_;
  Eigen::Affine3f index_from_ct_ = Eigen::Affine3f::Identity();
  Eigen::Array3f last_index_ = Eigen::Array3f::Zero();
  Eigen::Vector3f eye_in_index_ = Eigen::Vector3f::Zero();
  Eigen::Vector3f eye_in_blocks_ = Eigen::Vector3f::Zero();
};

}  // namespace acus::volume_rendering
