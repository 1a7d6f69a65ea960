// The transparent patient with needle, probe and its image, from any side (Alamilla-2021, section
// III.B).
#pragma once

#include <memory>
#include <vector>

#include "acus/imaging/volume_rendering/moving_surface.h"
#include "acus/imaging/volume_rendering/pressed_surface.h"
#include "acus/window/frame.h"
#include "acus/window/orbit.h"
#include "acus/window/shadow_texture.h"
#include "acus/window/space_layer.h"
#include "acus/window/steering.h"

namespace acus::window {

class TeachingView {
 public:
  /// @throws InputError for a surface that is not usable.
  TeachingView(const std::vector<volume_rendering::SurfaceInView>& surfaces, int max_triangles);

  SpaceLayer& layer() { return layer_; }
  /// Null if there is no skin.
  const mesh::Surface* skin() const { return has_skin_ ? &skin_surface_ : nullptr; }
  bool empty() const { return organs_.empty(); }
  const Eigen::AlignedBox3d& box_in_ct_mm() const { return box_in_ct_mm_; }

  void Update(const DisplayFrame& frame);
  void SetPlace(const Rectangle& place, const Rectangle& window, const Orbit& orbit, Stereo stereo);
  void Hide();

 private:
  struct Organ {
    int thing = 0;
    volume_rendering::MovingSurface surface;
    volume_rendering::PressedSurface pressed;
    bool is_pressed = false;  ///< Its nodes are at pressed positions.
  };
  static void UpdateOrgan(const DisplayFrame& frame, SpaceLayer& layer, Organ& organ);
  void UpdateNeedle(const DisplayFrame& frame);
  void UpdateProbe(const DisplayFrame& frame);
  void UpdateShadows(const DisplayFrame& frame);
  void AimLight(const DisplayFrame& frame);
  void SetLight(const Eigen::Vector3d& towards);

  SpaceLayer layer_;
  std::vector<Organ> organs_;
  Eigen::AlignedBox3d box_in_ct_mm_;
  std::unique_ptr<ShadowTexture> shadows_;
  mesh::Surface skin_surface_;
  bool has_skin_ = false;
  double lit_opacity_ = 1.0;  ///< Ratio of the skin's opacity to that of a shadow on it.
  Eigen::Vector3d towards_light_ = Eigen::Vector3d::Zero();
  int skin_ = -1;
  int shaft_ = -1;
  int marks_ = -1;
  int hub_ = -1;
  int probe_body_ = -1;
  int probe_mark_ = -1;
  int plane_ = -1;
  int target_ = -1;
  std::shared_ptr<const acoustics::Probe> probe_;
  mesh::Surface probe_surface_;
};

}  // namespace acus::window
