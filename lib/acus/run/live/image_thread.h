// The thread that renders the images of a live session without delaying the steps.
#pragma once

#include <atomic>
#include <deque>
#include <functional>
#include <mutex>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <thread>

#include "acus/run/live/duration_histogram.h"
#include "acus/run/live/image_maker.h"
#include "acus/run/live/live_image.h"
#include "acus/run/live/triple_buffer.h"
#include "acus/scene/simulation/scene.h"

namespace acus::live {

class RemoteImages;

struct ImageStatistics {
  std::atomic<std::int64_t> images{0};
  std::atomic<std::int64_t> late{0};    ///< Times of the grid at which an image was in work.
  std::atomic<std::int64_t> failed{0};  ///< Could not be rendered for lack of memory.
  DurationHistogram render;             ///< Wall-clock time of one image.
  DurationHistogram interval;           ///< From one finished image to the next.
  DurationHistogram tracker_to_image;   ///< From the measured pose to the finished image.

  std::atomic<std::int64_t> first_ns{0};  ///< End of the first image, CLOCK_MONOTONIC ...
  std::atomic<std::int64_t> last_ns{0};   ///< ... and the last.

  double per_s() const;  ///< 0 for fewer than two.
  nlohmann::json ToJson() const;
};

/// Renders the newest snapshot at a fixed rate. A "frozen" snapshot keeps the last images. An image
/// that cannot be rendered is counted, and the next one tried. While another computer sends images,
/// these are taken instead.
class ImageThread {
 public:
  /// @param scene, snapshots  Must outlive this. @param on_image  Called in this thread after
  ///     each image; may be empty; must not throw.
  ImageThread(const simulation::Scene& scene, TripleBuffer<LiveSnapshot>& snapshots, double rate_hz,
              std::function<void(const LiveImage&)> on_image);
  ~ImageThread();
  ImageThread(const ImageThread&) = delete;
  ImageThread& operator=(const ImageThread&) = delete;

  /// Before Start(). @param remote  Must outlive this.
  void TakeFrom(RemoteImages* remote) { remote_ = remote; }
  void Start();
  /// Waits for the image that is being rendered. A second call has no effect.
  void Stop() noexcept;

  /// For one reader: the window, or another consumer of images.
  TripleBuffer<LiveImage>& images() noexcept { return images_; }
  const ImageStatistics& statistics() const noexcept { return statistics_; }
  /// Costs of the stages of the images. Only to be read after Stop().
  const simulation::StageTimes& stage_times() const noexcept { return maker_.stage_times(); }
  double rate_hz() const noexcept { return rate_hz_; }
  /// Why the last image could not be rendered; empty if it could.
  std::string trouble() const;

 private:
  void Run();
  void MakeImage(std::int64_t begin_ns);
  void TakeImage();
  bool TakeNewest();
  void KeepLast();
  const LiveSnapshot& SnapshotAt(std::int64_t time_ns) const;
  void Hand(const LiveImage& out);
  void SetTrouble(const char* what);

  TripleBuffer<LiveSnapshot>& snapshots_;
  double rate_hz_;
  std::function<void(const LiveImage&)> on_image_;
  ImageMaker maker_;
  RemoteImages* remote_ = nullptr;   ///< Null: images are rendered here.
  std::int64_t taken_ = 0;           ///< Number of its newest image that was taken.
  std::int64_t kept_ns_ = 0;         ///< Time of the last snapshot that kept earlier images.
  std::deque<LiveSnapshot> recent_;  ///< Snapshots of the last second, for its images.
  TripleBuffer<LiveImage> images_;
  ImageStatistics statistics_;
  mutable std::mutex trouble_mutex_;
  std::string trouble_;
  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

}  // namespace acus::live
