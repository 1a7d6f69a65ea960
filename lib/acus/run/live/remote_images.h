// The images of a live session from a second computer, which is fed what each step was given.
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

/// The link to it. It has to make every step of the session, so a link that is lost stays lost:
/// from then on, as before the first image, images are made here.
class RemoteImages {
 public:
  /// @param scene  Must outlive this. @param digest  DigestOf() it.
  RemoteImages(const ImagesFrom& where, const simulation::Scene& scene, std::string digest);
  ~RemoteImages();  ///< Stops.
  RemoteImages(const RemoteImages&) = delete;
  RemoteImages& operator=(const RemoteImages&) = delete;

  /// Connects and asks, for at most some 4 s. False: trouble() says why, and feed() takes nothing.
  bool Connect();
  /// @pre Connect() was called. @param origin_ns  CLOCK_MONOTONIC at time 0 of the session.
  void Start(std::int64_t origin_ns);
  /// Twice is once.
  void Stop() noexcept;

  StepFeed& feed() { return feed_; }
  /// Images come: nobody needs to make them here. Any thread.
  bool works() const { return works_.load(std::memory_order_relaxed); }
  /// Null before the first. Any thread.
  std::shared_ptr<const MadeImages> Newest() const;
  /// "computer2:18946"
  const std::string& place() const { return place_; }
  /// Why images are made here; empty if they are not. Any thread.
  std::string trouble() const;
  /// Of the newest images, now: since the time that they show. @pre works()
  double age_ms() const;
  /// Of all images, at their arrival.
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

  // Of the thread.
  std::vector<StepInput> steps_;
  std::int64_t sent_steps_ = 0;
  std::int64_t sent_ns_ = 0;      ///< Session time of the newest step.
  std::int64_t progress_ns_ = 0;  ///< MonotonicNs() of the last images.

  DurationHistogram age_;
  std::atomic<std::int64_t> images_{0};
  std::atomic<std::int64_t> steps_sent_{0};
  std::atomic<std::int64_t> newest_ns_{0};  ///< Session time that the newest images show.
  std::atomic<bool> works_{false};
  std::atomic<bool> stopping_{false};
  mutable std::mutex mutex_;
  std::string trouble_;
  std::shared_ptr<const MadeImages> newest_;
};

}  // namespace acus::live
