// The images of a live session, made here or taken from another computer.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "acus/run/live/live_image.h"
#include "acus/scene/simulation/scene.h"

namespace acus::live {

/// Holds buffers and what the last images show. For one thread.
class ImageMaker {
 public:
  /// @param scene  Must outlive this.
  explicit ImageMaker(const simulation::Scene& scene);
  ~ImageMaker();
  ImageMaker(const ImageMaker&) = delete;
  ImageMaker& operator=(const ImageMaker&) = delete;

  /// Renders. A snapshot that says "frozen" keeps the images that were there.
  void Make(const LiveSnapshot& snapshot, LiveImage& out);
  /// Takes images of about that moment. False, and `out` is not to be used, if they are not of the
  /// size that the probe has then.
  bool Take(const LiveSnapshot& snapshot, const MadeImages& made, LiveImage& out);
  /// The last images at another moment: of tools and needle, while nothing newer has come.
  void Keep(const LiveSnapshot& snapshot, LiveImage& out) { Finish(snapshot, time_ns_, out); }
  /// All images are to be made anew.
  void Forget();

  /// What the stages of the images did.
  const simulation::StageTimes& stage_times() const noexcept { return stage_times_; }

 private:
  struct Renderers;
  void SetProbe(const LiveSnapshot& snapshot);
  void Finish(const LiveSnapshot& snapshot, std::int64_t time_ns, LiveImage& out);

  std::unique_ptr<Renderers> renderers_;
  simulation::StageTimes stage_times_;
  simulation::ProbeImages last_images_;
  std::vector<simulation::EffectImage> last_effects_;
  /// The moment that last_images_ show; nothing if they are to be made anew.
  std::optional<LiveSnapshot> shown_;
  std::int64_t time_ns_ = 0;  ///< Of the last images.
  std::int64_t number_ = 0;
};

}  // namespace acus::live
