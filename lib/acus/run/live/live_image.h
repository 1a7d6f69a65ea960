// A snapshot of a live session with its images.
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
  std::vector<simulation::EffectImage> effects;  ///< Images of the list's effects that have one.
  /// The probe with the current gain and depth. Null without a probe in the plan.
  std::shared_ptr<const acoustics::Probe> probe;
  std::int64_t number = 0;   ///< 0: before the first image.
  std::int64_t time_ns = 0;  ///< Session time of the images.
};

/// The images of one snapshot, received from another computer.
struct MadeImages {
  std::int64_t time_ns = 0;  ///< Session time.
  std::int64_t number = 0;   ///< From 1.
  simulation::ProbeImages images;
  std::vector<effects::EffectPixels> effects;  ///< In the order of LiveImage::effects.
};

}  // namespace acus::live
