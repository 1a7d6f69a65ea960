// Images of the volume view, rendered one after the other in a thread of their own.
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

/// All that an image of the volume view shows: a value that points to nothing which may end.
struct VolumeMoment {
  volume_rendering::Camera camera;
  std::size_t look = 0;  ///< Of those that the renderer was made with.
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

/// What casts the rays.
enum class VolumeRays {
  kAuto,       ///< A graphics card, where there is one; else the processor.
  kProcessor,  ///< The bits of replays.
  kGraphics,   ///< OpenGL, also where its driver computes on the processor.
};
/// @pre not kProcessor.
graphics::DriverKind DriverFor(VolumeRays rays);
/// "auto", "processor", "graphics". @throws InputError for another name.
VolumeRays VolumeRaysOf(std::string_view name);

struct VolumeStatistics {
  long images = 0;
  /// Moments that were asked for while an image was under way, and replaced by a newer one before
  /// their turn.
  long dropped = 0;
  double per_s = 0.0;   ///< Of the last images; 0 for fewer than two.
  double cpu_ms = 0.0;  ///< Of the thread, for the last image.
  std::string rays_on;  ///< Name of the graphics card; empty: the processor.
  /// Why a graphics card is not used any more, or cannot be; empty: nothing is wrong.
  std::string card_trouble;
};

/// Does not wait for anybody, and nobody for it: its thread has a lower priority than all others of
/// the session (5 more of nice), and only the newest moment waits for its turn.
class VolumeRenderer {
 public:
  /// @param looks  Must outlive this. @param in_background  False: Ask() renders.
  VolumeRenderer(const std::vector<VolumeLook>& looks, bool in_background,
                 VolumeRays rays = VolumeRays::kProcessor);
  ~VolumeRenderer();
  VolumeRenderer(const VolumeRenderer&) = delete;
  VolumeRenderer& operator=(const VolumeRenderer&) = delete;

  /// @param may_stop  The image is left unfinished if another view is asked for meanwhile.
  void Ask(VolumeMoment moment, bool may_stop);
  /// True if there is a newer image than at the last call; then it is in `out`.
  bool Take(image::ColourImage& out);
  /// Nothing is waiting or under way.
  bool idle() const;
  /// Until it is idle.
  void Wait();

  VolumeStatistics statistics() const;
  /// Why there is no image; empty if there is one.
  std::string trouble() const;

 private:
  struct Content;
  std::unique_ptr<Content> content_;
};

}  // namespace acus::window
