// A moment of a live session with its images.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "acus/run/live/live_snapshot.h"
#include "acus/scene/simulation/effect_images.h"
#include "acus/scene/simulation/probe_image_renderer.h"

namespace acus::live {

struct LiveImage {
  LiveSnapshot snapshot;
  simulation::ProbeImages images;
  std::vector<simulation::EffectImage> effects;  ///< Of those effects of the list that have one.
  /// As it is set: gain, depth. Null without one in the plan.
  std::shared_ptr<const acoustics::Probe> probe;
  std::int64_t number = 0;   ///< 0: none yet.
  std::int64_t time_ns = 0;  ///< Session time that the images show.
};

/// The images of a moment as another computer has made them.
struct MadeImages {
  std::int64_t time_ns = 0;  ///< Session time.
  std::int64_t number = 0;   ///< From 1.
  simulation::ProbeImages images;
  std::vector<effects::EffectPixels> effects;  ///< As LiveImage::effects.
};

}  // namespace acus::live
