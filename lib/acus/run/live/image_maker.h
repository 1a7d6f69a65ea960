// The images of a live session, rendered here or received from another computer.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "acus/run/live/live_image.h"
#include "acus/scene/simulation/scene.h"

namespace acus::live {

/// Holds buffers and the snapshot of the last images. For one thread.
class ImageMaker {
 public:
  /// @param scene  Must outlive this.
  explicit ImageMaker(const simulation::Scene& scene);
  ~ImageMaker();
  ImageMaker(const ImageMaker&) = delete;
  ImageMaker& operator=(const ImageMaker&) = delete;

  /// Renders. A "frozen" snapshot keeps the last images.
  void Make(const LiveSnapshot& snapshot, LiveImage& out);
  /// Takes images of approximately that time. False, with `out` not usable, if their size is not
  /// that of the probe.
  bool Take(const LiveSnapshot& snapshot, const MadeImages& made, LiveImage& out);
  /// The last images with another snapshot: of tools and needle, while no newer image exists.
  void Keep(const LiveSnapshot& snapshot, LiveImage& out) { Finish(snapshot, time_ns_, out); }
  /// Renders all images of the next snapshot.
  void Forget();

  /// Costs of the stages of the images.
  const simulation::StageTimes& stage_times() const noexcept { return stage_times_; }

 private:
  struct Renderers;
  void SetProbe(const LiveSnapshot& snapshot);
  void Finish(const LiveSnapshot& snapshot, std::int64_t time_ns, LiveImage& out);

  std::unique_ptr<Renderers> renderers_;
  simulation::StageTimes stage_times_;
  simulation::ProbeImages last_images_;
  std::vector<simulation::EffectImage> last_effects_;
  /// The snapshot of last_images_; nothing if they are to be rendered again.
  std::optional<LiveSnapshot> shown_;
  std::int64_t time_ns_ = 0;  ///< Time of the last images.
  std::int64_t number_ = 0;
};

}  // namespace acus::live
