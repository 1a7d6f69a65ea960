#include "acus/rig/tracking/simulators/playback.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <mutex>
#include <poll.h>
#include <thread>

#include "acus/base/core/error.h"
#include "acus/base/core/monotonic_time.h"
#include "acus/base/core/random.h"
#include "acus/rig/tracking/igtl_wire.h"

namespace acus::simulators {
namespace {

using tracking::NamedPose;

constexpr std::int64_t kNsPerS = 1'000'000'000;
constexpr std::int64_t kLongestNapNs = 50'000'000;  // How late a stop is noticed.
constexpr std::int64_t kLateNs = 5'000'000;

bool IsStopped(const RunContext& context) {
  return context.stop != nullptr && context.stop->load(std::memory_order_relaxed);
}

/// Sleeps until the time or a stop. False if it was stopped.
bool SleepUntil(std::int64_t time_ns, const RunContext& context) {
  for (;;) {
    if (IsStopped(context)) return false;
    const std::int64_t left_ns = std::min(time_ns - MonotonicNs(), kLongestNapNs);
    if (left_ns <= 0) return true;
    const timespec nap{.tv_sec = left_ns / kNsPerS, .tv_nsec = left_ns % kNsPerS};
    nanosleep(&nap, nullptr);
  }
}

/// Draws and sends images of the newest poses.
class ImageThread {
 public:
  ImageThread(ImageSource* source, tracking::PoseServer& server) : server_(server) {
    if (source != nullptr) thread_ = std::thread([this, source] { Run(*source); });
  }
  ~ImageThread() {
    stopping_ = true;
    if (thread_.joinable()) thread_.join();
  }

  void Show(const std::vector<NamedPose>& poses, std::int64_t time_ns) {
    const std::lock_guard lock(mutex_);
    for (const NamedPose& pose : poses) newest_[pose.name] = pose;
    time_ns_ = time_ns;
  }
  void Pause(bool paused) { paused_ = paused; }
  std::uint64_t count() const { return count_; }
  /// Why there are no more images; empty if there are.
  std::string error() const {
    const std::lock_guard lock(mutex_);
    return error_;
  }

 private:
  void Run(ImageSource& source) {
    const auto step_ns = static_cast<std::int64_t>(1e9 / std::clamp(source.rate_hz(), 0.1, 200.0));
    RunContext until_stopped;
    until_stopped.stop = &stopping_;
    std::int64_t due_ns = MonotonicNs();
    while (!stopping_) {
      due_ns = std::max(due_ns + step_ns, MonotonicNs());
      SleepUntil(due_ns, until_stopped);
      std::vector<NamedPose> poses;
      std::int64_t time_ns = 0;
      {
        const std::lock_guard lock(mutex_);
        for (const auto& [name, pose] : newest_) poses.push_back(pose);
        time_ns = time_ns_;
      }
      if (stopping_ || paused_ || poses.empty()) continue;
      const std::int64_t taken_ns = MonotonicNs();
      try {
        const std::vector<tracking::Image> drawn = source.Draw(poses, time_ns);
        for (std::size_t i = 0; i < drawn.size(); ++i) {
          server_.SendImage(source.streams()[i], drawn[i], taken_ns);
        }
      } catch (const InputError& error) {
        const std::lock_guard lock(mutex_);
        error_ = error.what();
        return;  // The same would come of the next one.
      }
      ++count_;
    }
  }

  tracking::PoseServer& server_;
  std::atomic<bool> stopping_{false}, paused_{false};
  std::atomic<std::uint64_t> count_{0};
  mutable std::mutex mutex_;
  std::string error_;
  std::map<std::string, NamedPose> newest_;
  std::int64_t time_ns_ = 0;
  std::thread thread_;
};

/// The server with its faults.
class FaultyServer {
 public:
  FaultyServer(const PlaybackOptions& options, std::uint64_t seed)
      : options_(options), server_(options.server), random_(seed, "garbage of a faulty tracker") {}

  tracking::PoseServer& server() { return server_; }

  /// Opens and closes the port as the faults say. @returns whether anything may be sent.
  bool Update(std::int64_t time_ns) {
    const bool drop = IsOn(options_.faults, FaultKind::kDrop, time_ns);
    if (drop && !is_closed_) server_.Stop();
    if (!drop && is_closed_) server_.Start();
    is_closed_ = drop;
    return !drop && !IsOn(options_.faults, FaultKind::kFreeze, time_ns);
  }

  void Send(std::vector<NamedPose> poses, std::int64_t time_ns, std::int64_t now_ns) {
    const auto on = [&](FaultKind kind) { return IsOn(options_.faults, kind, time_ns); };
    if (on(FaultKind::kGarbage)) SendGarbage();
    if (on(FaultKind::kNan)) return SendNan(poses, now_ns);
    for (NamedPose& pose : poses) {
      if (on(FaultKind::kOcclude)) pose.valid = false;
      if (on(FaultKind::kJump)) {
        pose.reference_from_tool =
            Eigen::Translation3d(kJumpMm, 0.0, 0.0) * pose.reference_from_tool.isometry();
      }
    }
    server_.SendPoses(poses, now_ns);
  }

 private:
  void SendGarbage() {
    tracking::Bytes bytes(random_.Next() % 400);
    for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random_.Next());
    server_.SendRaw(bytes);
  }

  void SendNan(const std::vector<NamedPose>& poses, std::int64_t now_ns) {
    const Eigen::Matrix4d nan = Eigen::Matrix4d::Constant(std::numeric_limits<double>::quiet_NaN());
    for (const NamedPose& pose : poses) {
      server_.SendRaw(tracking::PackMatrix(pose.name, server_.UtcNs(now_ns), nan));
    }
  }

  const PlaybackOptions& options_;
  tracking::PoseServer server_;
  RandomStream random_;
  bool is_closed_ = false;
};

bool WaitForClient(const tracking::PoseServer& server, const RunContext& context) {
  while (server.status().clients == 0) {
    if (!SleepUntil(MonotonicNs() + 5'000'000, context)) return false;
  }
  return true;
}

}  // namespace

PlaybackReport Play(const ToolMotion& motion, ImageSource* images, const PlaybackOptions& options,
                    const RunContext& context) {
  ACUS_REQUIRE(options.speed >= 0.01 && options.speed <= 100.0, "speed is ", options.speed,
               "; allowed are 0.01 to 100");
  FaultyServer faulty(options, context.seed);
  tracking::PoseServer& server = faulty.server();
  server.Start();
  if (options.on_listening) options.on_listening(server.port());
  PlaybackReport report;
  if (options.wait_for_client && !WaitForClient(server, context)) return report;

  ImageThread image_thread(images, server);
  const std::int64_t start_ns = MonotonicNs();
  std::int64_t end_ns = INT64_MAX;
  if (options.seconds) end_ns = start_ns + std::llround(1e9 * *options.seconds);
  const auto due = [&](std::int64_t motion_ns) {
    return start_ns + std::int64_t{std::llround(static_cast<double>(motion_ns) / options.speed)};
  };
  for (auto at = motion.Next(-1); at && due(*at) < end_ns; at = motion.Next(*at)) {
    if (!SleepUntil(due(*at), context)) break;
    const std::int64_t now_ns = MonotonicNs();
    const std::int64_t late_ns = now_ns - due(*at);
    report.late += late_ns > kLateNs ? 1 : 0;
    report.worst_late_ms = std::max(report.worst_late_ms, 1e-6 * static_cast<double>(late_ns));
    ++report.sent;
    std::vector<NamedPose> poses = motion.At(*at);
    image_thread.Show(poses, *at);
    const bool may_send = faulty.Update(now_ns - start_ns);
    image_thread.Pause(!may_send);
    if (may_send) faulty.Send(std::move(poses), now_ns - start_ns, now_ns);
  }
  if (options.seconds) SleepUntil(end_ns, context);
  report.played_s = 1e-9 * static_cast<double>(MonotonicNs() - start_ns);
  report.images = image_thread.count();
  if (const std::string error = image_thread.error(); !error.empty()) {
    context.Warn("no more images were drawn: " + error);
  }
  report.server = server.status();
  return report;
}

std::string Text(const PlaybackReport& report) {
  const tracking::PoseServerStatus& server = report.server;
  std::string text = Message(
      "played ", report.played_s, " s: ", report.sent, " instants, ", report.late,
      " of them late, the latest by ", report.worst_late_ms, " ms; ", report.images, " images\n",
      "clients: ", server.connects, " connected, ", server.too_slow, " too slow, ", server.rubbish,
      " sent invalid messages; ", server.images_replaced, " images replaced\n");
  return text;
}

}  // namespace acus::simulators
