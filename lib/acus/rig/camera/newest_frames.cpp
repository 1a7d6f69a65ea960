#include "acus/rig/camera/newest_frames.h"

#include <chrono>
#include <cstdlib>

#include "acus/base/core/monotonic_time.h"

namespace acus::camera {
namespace {

constexpr std::size_t kKept = 4;
constexpr int kReadMs = 20;  ///< Bounds how long the end takes.

void Rest() {
  std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

}  // namespace

NewestFrames::NewestFrames(std::unique_ptr<FrameSource> source)
    : source_(std::move(source)), status_(source_->status()), thread_([this] { Run(); }) {}

NewestFrames::~NewestFrames() {
  stop_ = true;
  thread_.join();
}

void NewestFrames::Run() {
  while (!stop_) {
    Image image;
    const bool got = source_->Next(image, kReadMs);
    {
      const std::lock_guard lock(mutex_);
      status_ = source_->status();
      if (got) newest_.push_back(std::move(image));
      if (newest_.size() > kKept) newest_.pop_front();
    }
    finished_ = source_->finished();
    if (!got) Rest();
  }
}

bool NewestFrames::Next(Image& out, int timeout_ms) {
  const std::int64_t until = MonotonicNs() + std::int64_t{timeout_ms} * 1'000'000;
  while (true) {
    {
      const std::lock_guard lock(mutex_);
      if (!newest_.empty() && newest_.back().time_ns > given_ns_) {
        out = newest_.back();
        given_ns_ = out.time_ns;
        return true;
      }
    }
    if (MonotonicNs() >= until) return false;
    Rest();
  }
}

FrameSourceStatus NewestFrames::status() const {
  const std::lock_guard lock(mutex_);
  return status_;
}

std::optional<Image> NewestFrames::NearestTo(std::int64_t time_ns, std::int64_t apart_ns) const {
  const auto off = [&](const Image& image) { return std::llabs(image.time_ns - time_ns); };
  while (true) {
    {
      const std::lock_guard lock(mutex_);
      const Image* best = nullptr;
      for (const Image& image : newest_) {
        if (off(image) <= apart_ns && (best == nullptr || off(image) < off(*best))) best = &image;
      }
      if (best != nullptr) return *best;
    }
    if (MonotonicNs() > time_ns + apart_ns) return std::nullopt;
    Rest();
  }
}

}  // namespace acus::camera
