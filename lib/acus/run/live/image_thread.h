// Images of a live session, beside the steps and never in their way.
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
/// that were there. An image that cannot be made is counted, and the next one tried. While another
/// computer sends images, these are taken instead.
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
  /// Lets the image that is in work be finished. Twice is once.
  void Stop() noexcept;

  /// For one reader: the window, or whoever shows images.
  TripleBuffer<LiveImage>& images() noexcept { return images_; }
  const ImageStatistics& statistics() const noexcept { return statistics_; }
  /// What the stages of the images did. Only to be read after Stop().
  const simulation::StageTimes& stage_times() const noexcept { return maker_.stage_times(); }
  double rate_hz() const noexcept { return rate_hz_; }
  /// Why the last image could not be made; empty if it could.
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
  RemoteImages* remote_ = nullptr;   ///< Null: images are made here.
  std::int64_t taken_ = 0;           ///< Number of the newest of its images that was taken.
  std::int64_t kept_ns_ = 0;         ///< Of the last moment that got images of before.
  std::deque<LiveSnapshot> recent_;  ///< Of the last second, for its images.
  TripleBuffer<LiveImage> images_;
  ImageStatistics statistics_;
  mutable std::mutex trouble_mutex_;
  std::string trouble_;
  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

}  // namespace acus::live
