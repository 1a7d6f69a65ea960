// 30 tools at 1 kHz from another process: nothing is lost and the lag does not grow. 20 s by
// default; ACUS_TRACKING_SECONDS=3600 for an hour.
#include <algorithm>
#include <cstdlib>
#include <gtest/gtest.h>
#include <iostream>
#include <signal.h>
#include <sys/wait.h>
#include <vector>

#include "core/cpu_time.h"
#include "core/monotonic_time.h"
#include "support/wait_until.h"
#include "tracking/igtl_source.h"
#include "tracking/pose_server.h"

namespace acus::tracking {
namespace {

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
    const session::Pose pose(
        Eigen::Isometry3d(Eigen::Translation3d(static_cast<double>(set), 0.0, 0.0)));
    for (NamedPose& one : poses) one.reference_from_tool = pose;
    server.SendPoses(poses, MonotonicNs());
  }
  sleep(60);  // Until it is ended.
  _exit(0);
}

/// What a recorder would see: every reading, with its lag.
struct Recorder {
  std::vector<std::vector<float>> lag_ms_by_second;
  std::uint64_t readings = 0, gaps = 0;
  std::vector<std::int64_t> last_set = std::vector<std::int64_t>(kTools, -1);

  void Take(const std::vector<ToolReading>& taken, std::size_t count, const Hello& hello,
            std::int64_t start_ns) {
    for (std::size_t i = 0; i < count; ++i) {
      const TrackedPose& pose = taken[i].pose;
      if (!pose.valid) continue;
      const auto set = std::llround(pose.reference_from_tool.translation().x());
      std::int64_t& last = last_set[taken[i].tool];
      if (set != last + 1) ++gaps;
      last = set;
      ++readings;
      const std::int64_t sent_ns = pose.source_time_ns - hello.utc_minus_ours_ns;
      const auto second = static_cast<std::size_t>((sent_ns - start_ns) / 1'000'000'000);
      if (lag_ms_by_second.size() <= second) lag_ms_by_second.resize(second + 1);
      lag_ms_by_second[second].push_back(
          static_cast<float>(1e-6 * static_cast<double>(pose.time_ns - sent_ns)));
    }
  }
};

float Quantile(std::vector<float> values, double fraction) {
  const auto at = static_cast<std::ptrdiff_t>(fraction * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return values[static_cast<std::size_t>(at)];
}

TEST(TrackingRate, ThirtyToolsAtOneKilohertzLoseNothingAndLagDoesNotGrow) {
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
  Recorder recorder;
  std::vector<ToolReading> taken(4096);
  const auto has_all = [&] {
    usleep(20'000);
    for (std::size_t count = taken.size(); count == taken.size();) {
      count = source.board().TakeReadings(taken);
      recorder.Take(taken, count, hello, start_ns);
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

  EXPECT_EQ(recorder.readings, static_cast<std::uint64_t>(sets * kTools));
  EXPECT_EQ(recorder.gaps, 0u);
  EXPECT_EQ(status.counts.lost_from_journal, 0u);
  EXPECT_EQ(status.counts.bad_messages + status.counts.skipped_bytes, 0u);
  EXPECT_EQ(status.counts.fell_silent + status.counts.out_of_order, 0u);

  std::vector<float> medians, all;
  for (const auto& second : recorder.lag_ms_by_second) {
    if (second.empty()) continue;
    medians.push_back(Quantile(second, 0.5));
    all.insert(all.end(), second.begin(), second.end());
  }
  ASSERT_GE(medians.size(), 2u);
  const auto fifth = static_cast<std::ptrdiff_t>(std::max<std::size_t>(1, medians.size() / 5));
  const float first_ms = Quantile({medians.begin(), medians.begin() + fifth}, 0.5);
  const float last_ms = Quantile({medians.end() - fifth, medians.end()}, 0.5);
  // In 20 s already, a receiver that is a thousandth too slow would show: 16 ms.
  EXPECT_LT(last_ms - first_ms, 10.0F);
  std::cout << seconds << " s, " << recorder.readings << " readings, lag median "
            << Quantile(all, 0.5) << " ms, 99.9 % " << Quantile(all, 0.999) << " ms, largest "
            << *std::max_element(all.begin(), all.end()) << " ms; median of the first fifth "
            << first_ms << " ms, of the last " << last_ms << " ms; CPU "
            << 1e6 * cpu_s / static_cast<double>(recorder.readings) << " us a reading; clock drift "
            << status.clock.drift_ppm << " ppm\n";
}

}  // namespace
}  // namespace acus::tracking
