#include "acus/run/live/image_thread.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>

#include "acus/base/core/monotonic_time.h"
#include "acus/run/live/remote_images.h"

namespace acus::live {
namespace {

constexpr std::size_t kRecentSnapshots = 250;  // One second of snapshots, one each 4 ms.
constexpr std::int64_t kLateNs = 150'000'000;

}  // namespace

double ImageStatistics::per_s() const {
  const double span_s = 1e-9 * static_cast<double>(last_ns - first_ns);
  return span_s > 0.0 ? static_cast<double>(images - 1) / span_s : 0.0;
}

nlohmann::json ImageStatistics::ToJson() const {
  return {{"images", images.load()},
          {"late", late.load()},
          {"failed", failed.load()},
          {"per_s", per_s()},
          {"render", render.ToJson()},
          {"interval", interval.ToJson()},
          {"tracker_to_image", tracker_to_image.ToJson()}};
}

ImageThread::ImageThread(const simulation::Scene& scene, TripleBuffer<LiveSnapshot>& snapshots,
                         double rate_hz, std::function<void(const LiveImage&)> on_image)
    : snapshots_(snapshots), rate_hz_(rate_hz), on_image_(std::move(on_image)), maker_(scene) {}

ImageThread::~ImageThread() {
  Stop();
}

void ImageThread::Start() {
  thread_ = std::thread([this] { Run(); });
}

void ImageThread::Stop() noexcept {
  stopping_ = true;
  if (thread_.joinable()) thread_.join();
}

void ImageThread::Run() {
  const auto period_ns = static_cast<std::int64_t>(std::llround(1e9 / rate_hz_));
  std::int64_t due_ns = MonotonicNs();
  while (!stopping_) {
    const std::int64_t begin_ns = MonotonicNs();
    if (remote_ != nullptr && remote_->works()) {
      TakeImage();
      due_ns = begin_ns;
      continue;
    }
    if (begin_ns < due_ns) {
      std::this_thread::sleep_for(
          std::chrono::nanoseconds(std::min<std::int64_t>(due_ns - begin_ns, 20'000'000)));
      continue;
    }
    due_ns += period_ns;
    while (due_ns <= begin_ns) {
      due_ns += period_ns;
      ++statistics_.late;
    }
    if (!snapshots_.Refresh()) continue;  // Before the first step, or a silent device.
    try {
      MakeImage(begin_ns);
      SetTrouble("");
    } catch (const std::bad_alloc&) {
      SetTrouble("there is no memory for images; close other programs");
    } catch (const std::exception& error) {
      SetTrouble(error.what());
    }
  }
}

void ImageThread::MakeImage(std::int64_t begin_ns) {
  LiveImage& out = images_.Back();
  maker_.Make(snapshots_.Front(), out);
  statistics_.render.Add(MonotonicNs() - begin_ns);
  Hand(out);
}

void ImageThread::Hand(const LiveImage& out) {
  const std::int64_t end_ns = MonotonicNs();
  const bool is_first = statistics_.images == 0;
  if (is_first) statistics_.first_ns = end_ns;
  if (!is_first) statistics_.interval.Add(end_ns - statistics_.last_ns);
  statistics_.last_ns = end_ns;
  statistics_.tracker_to_image.Add(end_ns - out.snapshot.measured_ns);
  ++statistics_.images;
  if (on_image_) on_image_(out);
  images_.Publish();
}

/// One turn while another computer renders the images.
void ImageThread::TakeImage() {
  constexpr auto kTurn = std::chrono::milliseconds(2);
  try {
    if (snapshots_.Refresh()) {
      recent_.push_back(snapshots_.Front());
      if (recent_.size() > kRecentSnapshots) recent_.pop_front();
    }
    if (!TakeNewest()) {
      KeepLast();
      std::this_thread::sleep_for(kTurn);
    }
    SetTrouble("");
  } catch (const std::bad_alloc&) {
    SetTrouble("there is no memory for images; close other programs");
    std::this_thread::sleep_for(kTurn);
  }
}

/// False if there is no new image.
bool ImageThread::TakeNewest() {
  const auto made = remote_->Newest();
  if (!made || made->number == taken_ || recent_.empty()) return false;
  taken_ = made->number;
  LiveImage& out = images_.Back();
  if (maker_.Take(SnapshotAt(made->time_ns), *made, out)) Hand(out);
  return true;
}

/// While images are late, the window still shows the current poses of the tools.
void ImageThread::KeepLast() {
  const std::int64_t now_ns = MonotonicNs();
  const bool is_late = statistics_.images > 0 && now_ns - statistics_.last_ns > kLateNs;
  if (!is_late || recent_.empty() || recent_.back().moment.time_ns == kept_ns_) return;
  kept_ns_ = recent_.back().moment.time_ns;
  maker_.Keep(recent_.back(), images_.Back());
  images_.Publish();
}

/// The last snapshot before that time; the oldest one, if that is later.
const LiveSnapshot& ImageThread::SnapshotAt(std::int64_t time_ns) const {
  const auto after = std::ranges::upper_bound(
      recent_, time_ns, {}, [](const LiveSnapshot& snapshot) { return snapshot.moment.time_ns; });
  return after == recent_.begin() ? *after : *std::prev(after);
}

void ImageThread::SetTrouble(const char* what) {
  const bool failed = *what != '\0';
  if (failed) {
    ++statistics_.failed;
    maker_.Forget();  // Parts of it may belong to different times.
  }
  const std::lock_guard lock(trouble_mutex_);
  if (failed || !trouble_.empty()) trouble_ = what;
}

std::string ImageThread::trouble() const {
  const std::lock_guard lock(trouble_mutex_);
  return trouble_;
}

}  // namespace acus::live
