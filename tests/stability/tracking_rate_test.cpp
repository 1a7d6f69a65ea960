// 30 tools at 1 kHz from another process: nothing is lost and the lag does not grow. 20 s by
// default; ACUS_TRACKING_SECONDS=3600 for an hour.
#include <algorithm>
#include <cstdlib>
#include <gtest/gtest.h>
#include <iostream>
#include <signal.h>
#include <sys/wait.h>
#include <vector>

#include "acus/base/core/cpu_time.h"
#include "acus/base/core/monotonic_time.h"
#include "acus/rig/tracking/igtl_source.h"
#include "acus/rig/tracking/pose_server.h"
#include "support/bound.h"
#include "support/wait_until.h"

namespace acus::tracking {
namespace {

using testing_support::Below;
using testing_support::Exactly;
using testing_support::HardCase;
using testing_support::WaitUntil;

constexpr int kTools = 30;
constexpr std::int64_t kNsPerMs = 1'000'000;

int Seconds() {
  const char* text = std::getenv("ACUS_TRACKING_SECONDS");
  return text != nullptr ? std::max(1, std::atoi(text)) : 20;
}

std::string Tool(int i) {
  return "Tool" + std::to_string(i) + "ToReference";
}

struct Hello {
  int port;
  std::int64_t utc_minus_ours_ns;
};

/// The tracker: 1000 sets of poses a second, at absolute times, so that none is left out.
[[noreturn]] void BeATracker(int pipe_fd, int seconds) {
  PoseServerOptions options;
  options.host = "127.0.0.1";
  options.port = 0;
  options.max_backlog_bytes = 64 * 1024 * 1024;
  PoseServer server(options);
  server.Start();
  const Hello hello{.port = server.port(), .utc_minus_ours_ns = server.UtcNs(0)};
  if (write(pipe_fd, &hello, sizeof(hello)) != sizeof(hello)) _exit(1);
  while (server.status().clients == 0) usleep(1000);
  std::vector<NamedPose> poses;
  for (int i = 0; i < kTools; ++i) poses.push_back({.name = Tool(i)});
  const std::int64_t start_ns = MonotonicNs();
  for (std::int64_t set = 0; set < 1000 * std::int64_t{seconds}; ++set) {
    const std::int64_t due_ns = start_ns + set * kNsPerMs;
    while (MonotonicNs() < due_ns) usleep(100);
    // The number of the set is in the pose: exact in a float up to 16 million.
    const transforms::Pose pose(
        Eigen::Isometry3d(Eigen::Translation3d(static_cast<double>(set), 0.0, 0.0)));
    for (NamedPose& one : poses) one.reference_from_tool = pose;
    server.SendPoses(poses, MonotonicNs());
  }
  sleep(60);  // Until it is ended.
  _exit(0);
}

float Median(std::vector<float> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// What a recorder would see: every reading, with its lag. Memory does not grow by the hour.
class Recorder {
 public:
  Recorder(const Hello& hello, std::int64_t start_ns) : hello_(hello), start_ns_(start_ns) {}

  std::uint64_t readings = 0, gaps = 0;
  std::vector<float> median_ms;  ///< Of each second.
  float largest_ms = 0.0F;

  void Take(std::span<const ToolReading> taken) {
    for (const auto& [tool, pose] : taken) {
      if (!pose.valid) continue;
      const auto set = std::llround(pose.reference_from_tool.translation().x());
      if (set != last_set_[tool] + 1) ++gaps;
      last_set_[tool] = set;
      ++readings;
      const std::int64_t sent_ns = pose.source_time_ns - hello_.utc_minus_ours_ns;
      if ((sent_ns - start_ns_) / 1'000'000'000 > second_) EndSecond();
      const double lag_ms = 1e-6 * static_cast<double>(pose.time_ns - sent_ns);
      this_second_.push_back(static_cast<float>(lag_ms));
      largest_ms = std::max(largest_ms, this_second_.back());
      ++tenths_of_ms_[static_cast<std::size_t>(std::clamp(10.0 * lag_ms, 0.0, 99'999.0))];
    }
  }
  void EndSecond() {
    if (!this_second_.empty()) median_ms.push_back(Median(this_second_));
    this_second_.clear();
    ++second_;
  }
  /// Upper end of the tenth of a ms that holds the quantile.
  double QuantileMs(double fraction) const {
    double sum = 0.0;
    for (std::size_t i = 0; i < tenths_of_ms_.size(); ++i) {
      sum += static_cast<double>(tenths_of_ms_[i]);
      if (sum >= fraction * static_cast<double>(readings)) return 0.1 * static_cast<double>(i + 1);
    }
    return INFINITY;
  }

 private:
  Hello hello_;
  std::int64_t start_ns_;
  std::int64_t second_ = 0;
  std::vector<float> this_second_;
  std::vector<std::uint64_t> tenths_of_ms_ = std::vector<std::uint64_t>(100'000);
  std::vector<std::int64_t> last_set_ = std::vector<std::int64_t>(kTools, -1);
};

TEST(TrackingRate, ThirtyToolsAtOneKilohertzLoseNothingAndLagDoesNotGrow) {
  const HardCase hard(
      "30 tools at 1 kHz over a socket: a receiver a thousandth too slow falls behind.");
  const int seconds = Seconds();
  const std::int64_t sets = 1000 * std::int64_t{seconds};
  int ends[2];
  ASSERT_EQ(pipe(ends), 0);
  const pid_t tracker = fork();
  ASSERT_GE(tracker, 0);
  if (tracker == 0) BeATracker(ends[1], seconds);
  Hello hello{};
  ASSERT_EQ(read(ends[0], &hello, sizeof(hello)), ssize_t{sizeof(hello)});

  IgtlOptions options;
  options.host = "127.0.0.1";
  options.port = hello.port;
  options.lost_after_ms = 5000;
  options.journal_capacity = 60'000;  // Two seconds.
  for (int i = 0; i < kTools; ++i) options.tools.push_back({.tool = Tool(i), .device = Tool(i)});
  IgtlSource source(options);
  const double cpu_before_s = ProcessCpuSeconds();
  const std::int64_t start_ns = MonotonicNs();
  source.Start();
  Recorder recorder(hello, start_ns);
  std::vector<ToolReading> taken(4096);
  const auto has_all = [&] {
    usleep(20'000);
    for (std::size_t count = taken.size(); count == taken.size();) {
      count = source.board().TakeReadings(taken);
      recorder.Take(std::span(taken).first(count));
    }
    return recorder.readings >= static_cast<std::uint64_t>(sets * kTools);
  };
  EXPECT_TRUE(WaitUntil(has_all, seconds + 40.0));
  const double cpu_s = ProcessCpuSeconds() - cpu_before_s;
  const SourceStatus status = source.status();
  kill(tracker, SIGKILL);
  waitpid(tracker, nullptr, 0);
  close(ends[0]);
  close(ends[1]);

  hard.Expect("readings lost", sets * kTools - static_cast<std::int64_t>(recorder.readings),
              Exactly(0));
  hard.Expect("gaps in a tool's readings", recorder.gaps, Exactly(0));
  hard.Expect("readings lost from the journal", status.counts.lost_from_journal, Exactly(0));
  hard.Note("seconds", std::to_string(seconds));
  EXPECT_EQ(status.counts.bad_messages + status.counts.skipped_bytes, 0u);
  EXPECT_EQ(status.counts.fell_silent + status.counts.out_of_order, 0u);

  recorder.EndSecond();
  const std::vector<float>& medians = recorder.median_ms;
  ASSERT_GE(medians.size(), 2u);
  const auto fifth = static_cast<std::ptrdiff_t>(std::max<std::size_t>(1, medians.size() / 5));
  const float first_ms = Median({medians.begin(), medians.begin() + fifth});
  const float last_ms = Median({medians.end() - fifth, medians.end()});
  // In 20 s already, a receiver that is a thousandth too slow would show: 16 ms.
  hard.Expect("growth of the lag from the first to the last fifth", last_ms - first_ms, Below(10.0),
              "ms");
  std::cout << seconds << " s, " << recorder.readings << " readings, lag median " << Median(medians)
            << " ms, 99.9 % below " << recorder.QuantileMs(0.999) << " ms, largest "
            << recorder.largest_ms << " ms; median of the first fifth " << first_ms
            << " ms, of the last " << last_ms << " ms; CPU "
            << 1e6 * cpu_s / static_cast<double>(recorder.readings) << " us a reading; clock drift "
            << status.clock.drift_ppm << " ppm\n";
}

}  // namespace
}  // namespace acus::tracking
