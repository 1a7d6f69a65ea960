// Images of a live session, beside the steps and never in their way.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "acus/run/live/duration_histogram.h"
#include "acus/run/live/live_snapshot.h"
#include "acus/run/live/triple_buffer.h"
#include "acus/scene/simulation/effect_images.h"
#include "acus/scene/simulation/probe_image_renderer.h"
#include "acus/scene/simulation/scene.h"

namespace acus::live {

/// A moment with its images.
struct LiveImage {
  LiveSnapshot snapshot;
  simulation::ProbeImages images;
  std::vector<simulation::EffectImage> effects;  ///< Of those effects of the list that have one.
  /// As it is set: gain, depth. Null without one in the plan.
  std::shared_ptr<const acoustics::Probe> probe;
  std::int64_t number = 0;  ///< 0: none yet.
};

struct ImageStatistics {
  std::atomic<std::int64_t> images{0};
  std::atomic<std::int64_t> late{0};  ///< Moments of the grid at which an image was still in work.
  std::atomic<std::int64_t> failed{0};  ///< Could not be made: there was no memory for them.
  DurationHistogram render;             ///< Wall-clock time of one.
  DurationHistogram interval;           ///< From one finished image to the next.
  DurationHistogram tracker_to_image;   ///< From the measured pose to the finished image.

  std::atomic<std::int64_t> first_ns{0};  ///< When the first was finished, CLOCK_MONOTONIC ...
  std::atomic<std::int64_t> last_ns{0};   ///< ... and the last.

  double per_s() const;  ///< 0 for fewer than two.
  nlohmann::json ToJson() const;
};

/// Renders the newest snapshot at a fixed rate. A snapshot that says "frozen" keeps the images
/// that were there. An image that cannot be made is counted, and the next one tried.
class ImageThread {
 public:
  /// @param scene, snapshots  Must outlive this. @param on_image  Called in this thread after
  ///     each image; may be empty; must not throw.
  ImageThread(const simulation::Scene& scene, TripleBuffer<LiveSnapshot>& snapshots, double rate_hz,
              std::function<void(const LiveImage&)> on_image);
  ~ImageThread();
  ImageThread(const ImageThread&) = delete;
  ImageThread& operator=(const ImageThread&) = delete;

  void Start();
  /// Lets the image that is in work be finished. Twice is once.
  void Stop() noexcept;

  /// For one reader: the window, or whoever shows images.
  TripleBuffer<LiveImage>& images() noexcept { return images_; }
  const ImageStatistics& statistics() const noexcept { return statistics_; }
  /// What the stages of the images did. Only to be read after Stop().
  const simulation::StageTimes& stage_times() const noexcept { return stage_times_; }
  double rate_hz() const noexcept { return rate_hz_; }
  /// Why the last image could not be made; empty if it could.
  std::string trouble() const;

 private:
  struct Renderers;
  void Run();
  void MakeImage(std::int64_t begin_ns);
  void SetTrouble(const char* what);
  void Render(LiveImage& out);
  void SetProbe(const LiveSnapshot& snapshot);

  TripleBuffer<LiveSnapshot>& snapshots_;
  double rate_hz_;
  std::function<void(const LiveImage&)> on_image_;
  std::unique_ptr<Renderers> renderers_;
  TripleBuffer<LiveImage> images_;
  ImageStatistics statistics_;
  simulation::StageTimes stage_times_;
  simulation::ProbeImages last_images_;
  std::vector<simulation::EffectImage> last_effects_;
  /// The moment that last_images_ show; nothing if they are to be made anew.
  std::optional<LiveSnapshot> shown_;
  std::int64_t number_ = 0;
  mutable std::mutex trouble_mutex_;
  std::string trouble_;
  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

}  // namespace acus::live
