// Images in the plane of the probe at one instant: those of the coupled effects B-mode and CT slice
// (coupled/probe_images.cpp), which share needle, tissue and probe.
#pragma once

#include <cstdint>
#include <optional>

#include "acus/data/image/image.h"
#include "acus/imaging/slicing/ct_slice.h"
#include "acus/imaging/ultrasound/display/frame_persistence.h"
#include "acus/physics/breathing/breath.h"
#include "acus/scene/simulation/moment_rest.h"
#include "acus/scene/simulation/scene.h"
#include "acus/scene/simulation/snapshot.h"
#include "acus/scene/simulation/stage_timing.h"
#include "acus/scene/simulation/ultrasound_model.h"

namespace acus::simulation {

/// The needle as images show it; nothing if there is none.
std::optional<image::NeedleInImage> ImagedNeedle(const Scene& scene, const Snapshot& snapshot);

struct ProbeImages {
  image::GrayImage b_mode;    ///< Empty if the plan has no B-mode.
  image::GrayImage ct_slice;  ///< Empty if the plan has no CT slice.
};

/// Which of the plan's images are rendered.
enum class ImageChoice { kAll, kBModeOnly };

/// Whether a renderer makes all frames in order of time. Only then does it add the persistence of
/// the display; otherwise the caller adds it.
enum class Frames { kInOrder, kSingle };

/// The persistence of the scene's display.
ultrasound::FramePersistence PersistenceOf(const Scene& scene);

/// Renders the images of the probe that the plan has. Holds buffers: one renderer for each
/// thread.
class ProbeImageRenderer {
 public:
  /// @param scene  Must outlive the renderer.
  /// @param probe  The scene's, with another gain or depth; null: the scene's.
  explicit ProbeImageRenderer(const Scene& scene, const acoustics::Probe* probe = nullptr,
                              ImageChoice choice = ImageChoice::kAll,
                              Frames frames = Frames::kInOrder);

  /// The same bits for the same snapshot, whatever was rendered before, except for persistence. If
  /// the tracker does not see the probe, the images are black. Allocates nothing after the first
  /// call.
  /// @param times  If given, the cost of each stage is added to it.
  /// @param shown  The instant that `out` shows already, by a renderer of the same probe: an image
  ///     that would be equal is not rewritten, its stage sleeps. Null: none.
  void Render(const Snapshot& snapshot, ProbeImages& out, StageTimes* times = nullptr,
              const Snapshot* shown = nullptr);

  /// True if the image of that stage is the same at both instants.
  bool Sleeps(effects::PortRef id, const Snapshot& snapshot, const Snapshot& shown) const noexcept;

 private:
  bool ReadsRestMap() const;
  void DrawBMode(Sleep sleep, const Snapshot& snapshot,
                 const std::optional<image::NeedleInImage>& needle, const slicing::RestMap* rest,
                 image::GrayImage& out);
  Sleep SleepOf(effects::PortRef id, const Snapshot& snapshot,
                const Snapshot* shown) const noexcept;

  const Scene& scene_;
  double needle_reach_mm_ = 0.0;
  MomentRest rest_;
  std::optional<acoustics::Probe> probe_;  ///< That of the images.
  std::optional<UltrasoundModel> b_mode_;
  std::optional<slicing::CtSliceRenderer> ct_slice_;
  ultrasound::FramePersistence persistence_;
  image::GrayImage frame_;  ///< The B-mode before persistence.
};

}  // namespace acus::simulation
