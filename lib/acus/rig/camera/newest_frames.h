// The newest images of a camera, read by a thread of their own: for two cameras beside each other.
#pragma once

#include <atomic>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>

#include "acus/rig/camera/frame_source.h"

namespace acus::camera {

/// Images are stamped when they arrive, however busy whoever uses them is; those that no thread
/// requests are dropped.
class NewestFrames final : public FrameSource {
 public:
  explicit NewestFrames(std::unique_ptr<FrameSource> source);
  ~NewestFrames() override;

  /// The newest image, if it was not given before.
  bool Next(Image& out, int timeout_ms) override;
  bool finished() const override { return finished_; }
  FrameSourceStatus status() const override;
  /// The image whose time is nearest to `time_ns` and at most `apart_ns` from it; waits for it
  /// until it could have arrived. Nothing if there is none.
  std::optional<Image> NearestTo(std::int64_t time_ns, std::int64_t apart_ns) const;

 private:
  void Run();

  std::unique_ptr<FrameSource> source_;
  mutable std::mutex mutex_;
  std::deque<Image> newest_;  // By the mutex,
  FrameSourceStatus status_;  // as is this.
  std::int64_t given_ns_ = 0;
  std::atomic<bool> finished_{false}, stop_{false};
  std::thread thread_;
};

}  // namespace acus::camera
