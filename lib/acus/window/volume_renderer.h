// Images of the volume view, rendered one after the other in a separate thread.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "acus/data/image/image.h"
#include "acus/imaging/acoustics/probe.h"
#include "acus/imaging/graphics/shader_rays.h"
#include "acus/imaging/volume_rendering/camera.h"
#include "acus/imaging/volume_rendering/patient_view.h"
#include "acus/physics/breathing/motion_map.h"
#include "acus/window/frame.h"

namespace acus::window {

/// The inputs of an image of the volume view: a value without references that can dangle.
struct VolumeMoment {
  volume_rendering::Camera camera;
  std::size_t look = 0;  ///< Index among the looks of the renderer.
  double opacity = 1.0;  ///< Factor on the opacities of the look: above 0, up to 1.
  std::vector<volume_rendering::CutPlane> cuts;
  std::optional<breathing::MotionMap> motion;
  std::optional<image::NeedleInImage> needle;
  std::optional<Eigen::Isometry3d> ct_from_probe;
  std::shared_ptr<const acoustics::Probe> probe;
  image::GrayImage b_mode;
  std::shared_ptr<const volume_rendering::PressedTissue> pressed;

  bool SameView(const VolumeMoment& other) const;     ///< Eye, look and cuts.
  bool SameContent(const VolumeMoment& other) const;  ///< Breath, tissue, tools and their image.
};

/// The device that casts the rays.
enum class VolumeRays {
  kAuto,       ///< A graphics card if there is one; else the processor.
  kProcessor,  ///< The same bits as in replays.
  kGraphics,   ///< OpenGL, even if its driver computes on the processor.
};
/// @pre not kProcessor.
graphics::DriverKind DriverFor(VolumeRays rays);
/// "auto", "processor", "graphics". @throws InputError for another name.
VolumeRays VolumeRaysOf(std::string_view name);

struct VolumeStatistics {
  long images = 0;
  /// Frames that were requested while an image was being rendered, and replaced by a newer one
  /// before their turn.
  long dropped = 0;
  double per_s = 0.0;   ///< Rate of the last images; 0 for fewer than two.
  double cpu_ms = 0.0;  ///< CPU time of the thread for the last image.
  std::string rays_on;  ///< Name of the graphics card; empty: the processor.
  /// Why a graphics card is not used any more, or cannot be; empty: no problem.
  std::string card_trouble;
};

/// Renders without blocking its caller: its thread has a lower priority than all others of the
/// session (nice value + 5), and only the newest frame waits for its turn.
class VolumeRenderer {
 public:
  /// @param looks  Must outlive this. @param in_background  False: Ask() renders.
  VolumeRenderer(const std::vector<VolumeLook>& looks, bool in_background,
                 VolumeRays rays = VolumeRays::kProcessor);
  ~VolumeRenderer();
  VolumeRenderer(const VolumeRenderer&) = delete;
  VolumeRenderer& operator=(const VolumeRenderer&) = delete;

  /// @param may_stop  Rendering stops if another view is requested meanwhile.
  void Ask(VolumeMoment moment, bool may_stop);
  /// True if there is a newer image than at the last call; then it is in `out`.
  bool Take(image::ColourImage& out);
  /// Nothing is waiting or being rendered.
  bool idle() const;
  /// Waits until it is idle.
  void Wait();

  VolumeStatistics statistics() const;
  /// Why there is no image; empty if there is one.
  std::string trouble() const;

 private:
  struct Content;
  std::unique_ptr<Content> content_;
};

}  // namespace acus::window
