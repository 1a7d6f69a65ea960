// The images of a live session from a second computer, which receives the input of each step.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <thread>

#include "acus/rig/tracking/igtl_link.h"
#include "acus/run/live/duration_histogram.h"
#include "acus/run/live/image_protocol.h"
#include "acus/run/live/live_devices.h"
#include "acus/run/live/step_feed.h"

namespace acus::live {

/// The connection to it. The remote needs every step of the session, so a lost connection is not
/// reopened: after that, as before the first image, images are rendered here.
class RemoteImages {
 public:
  /// @param scene  Must outlive this. @param digest  DigestOf() it.
  RemoteImages(const ImagesFrom& where, const simulation::Scene& scene, std::string digest);
  ~RemoteImages();  ///< Stops.
  RemoteImages(const RemoteImages&) = delete;
  RemoteImages& operator=(const RemoteImages&) = delete;

  /// Connects and sends the request, for at most 4 s. False: trouble() gives the reason, and feed()
  /// accepts nothing.
  bool Connect();
  /// @pre Connect() was called. @param origin_ns  CLOCK_MONOTONIC at time 0 of the session.
  void Start(std::int64_t origin_ns);
  /// A second call has no effect.
  void Stop() noexcept;

  StepFeed& feed() { return feed_; }
  /// True while images arrive: none are rendered here. Any thread.
  bool works() const { return works_.load(std::memory_order_relaxed); }
  /// Null before the first. Any thread.
  std::shared_ptr<const MadeImages> Newest() const;
  /// "computer2:18946"
  const std::string& place() const { return place_; }
  /// Why images are rendered here; empty if they are not. Any thread.
  std::string trouble() const;
  /// Current age of the newest images, from the time that they show. @pre works()
  double age_ms() const;
  /// Median age of all images, at their arrival.
  double median_age_ms() const { return 1e-6 * age_.QuantileNs(0.5); }
  std::int64_t num_images() const { return images_; }
  nlohmann::json ToJson() const;

 private:
  void Run() noexcept;
  void SendSteps();
  void TakeMessages();
  void CheckProgress();
  void Lose(const std::string& why) noexcept;

  ImagesFrom where_;
  std::string place_;
  std::string digest_;
  tracking::WakeUp wake_;
  std::unique_ptr<tracking::IgtlLink> link_;
  MomentReader reader_;
  StepFeed feed_{1U << 12};
  std::int64_t origin_ns_ = 0;
  std::thread thread_;

  // Data of the thread.
  std::vector<StepInput> steps_;
  std::int64_t sent_steps_ = 0;
  std::int64_t sent_ns_ = 0;      ///< Session time of the newest step.
  std::int64_t progress_ns_ = 0;  ///< MonotonicNs() of the last images.

  DurationHistogram age_;
  std::atomic<std::int64_t> images_{0};
  std::atomic<std::int64_t> steps_sent_{0};
  std::atomic<std::int64_t> newest_ns_{0};  ///< Session time of the newest images.
  std::atomic<bool> works_{false};
  std::atomic<bool> stopping_{false};
  mutable std::mutex mutex_;
  std::string trouble_;
  std::shared_ptr<const MadeImages> newest_;
};

}  // namespace acus::live
