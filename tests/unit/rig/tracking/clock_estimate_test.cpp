#include "acus/rig/tracking/clock_estimate.h"

#include <cmath>
#include <gtest/gtest.h>

#include "acus/base/core/random.h"

namespace acus::tracking {
namespace {

constexpr std::int64_t kSecond = 1'000'000'000;
constexpr std::int64_t kMs = 1'000'000;

// A source whose clock is `offset` behind and runs slow by `ppm`; messages take 0.5 ms and an
// exponential jitter of 2 ms on top, and never overtake each other.
struct Peer {
  std::int64_t offset_ns = 1'700'000'000 * kSecond;
  double ppm = 0.0;
  double jitter_ms = 2.0;
  RandomStream random{5, "delay"};
  std::int64_t last_arrival_ns = 0;

  std::int64_t SourceNs(std::int64_t time_ns) const {
    return time_ns - offset_ns - std::llround(1e-6 * ppm * static_cast<double>(time_ns));
  }
  std::int64_t Arrival(std::int64_t sent_ns) {
    const double jitter = -jitter_ms * std::log(1.0 - random.Uniform());
    last_arrival_ns =
        std::max(last_arrival_ns + 1, sent_ns + kMs / 2 + std::int64_t{std::llround(1e6 * jitter)});
    return last_arrival_ns;
  }
};

TEST(ClockEstimate, FindsOffsetAndDriftUnderJitter) {
  for (const double ppm : {0.0, 50.0, -50.0}) {
    Peer peer{.ppm = ppm};
    ClockEstimate clock;
    double worst_ms = 0.0;
    for (std::int64_t i = 0; i < 100 * 60; ++i) {  // A minute at 100 Hz.
      const std::int64_t sent_ns = 10 * kSecond + i * 10 * kMs;
      const std::int64_t source_ns = peer.SourceNs(sent_ns), arrival_ns = peer.Arrival(sent_ns);
      clock.Observe(source_ns, arrival_ns);
      const auto error_ns = clock.OursNs(source_ns, arrival_ns) - (sent_ns + kMs / 2);
      if (i > 100 * 15) worst_ms = std::max(worst_ms, std::abs(1e-6 * double(error_ns)));
    }
    EXPECT_LT(worst_ms, 0.15) << ppm << " ppm: a twentieth of what single arrivals are off by";
    EXPECT_NEAR(clock.drift_ppm(), ppm, 5.0);
    EXPECT_EQ(clock.times_set(), 0);
  }
}

TEST(ClockEstimate, AnInstantNeverLiesAfterItsArrival) {
  Peer peer{.ppm = -200.0};
  ClockEstimate clock;
  for (std::int64_t i = 0; i < 5000; ++i) {
    const std::int64_t sent_ns = kSecond + i * 7 * kMs;
    const std::int64_t source_ns = peer.SourceNs(sent_ns), arrival_ns = peer.Arrival(sent_ns);
    clock.Observe(source_ns, arrival_ns);
    ASSERT_LE(clock.OursNs(source_ns, arrival_ns), arrival_ns);
  }
}

TEST(ClockEstimate, ShowsAGrowingLagRatherThanHidingIt) {
  // Ten seconds of punctual messages, then each is 1 ms later than the one before: the sender or
  // the network cannot keep up.
  Peer peer{.jitter_ms = 0.1};
  ClockEstimate clock;
  std::int64_t late_ns = 0, shown_ns = 0;
  for (std::int64_t i = 0; i < 1300; ++i) {
    const std::int64_t sent_ns = kSecond + i * 10 * kMs;
    if (i > 1000) late_ns += kMs;
    const std::int64_t source_ns = peer.SourceNs(sent_ns);
    const std::int64_t arrival_ns = peer.Arrival(sent_ns) + late_ns;
    clock.Observe(source_ns, arrival_ns);
    shown_ns = arrival_ns - clock.OursNs(source_ns, arrival_ns);
  }
  // Over three seconds 0.1 % may pass for drift: 3 ms, and the jitter.
  EXPECT_NEAR(double(shown_ns), double(late_ns), 5e6);
}

TEST(ClockEstimate, FollowsAClockThatIsSet) {
  for (const std::int64_t step_ns : {-3600 * kSecond, 3600 * kSecond}) {
    Peer peer;
    ClockEstimate clock;
    for (std::int64_t i = 0; i < 1000; ++i) {
      const std::int64_t sent_ns = kSecond + i * 10 * kMs;
      if (i == 500) peer.offset_ns += step_ns;
      clock.Observe(peer.SourceNs(sent_ns), peer.Arrival(sent_ns));
    }
    EXPECT_EQ(clock.times_set(), 1);
    EXPECT_NEAR(double(clock.OffsetNs(11 * kSecond) - peer.offset_ns), 0.5e6, 1e6);
  }
}

TEST(ClockEstimate, OneLateMessageIsNoClockThatWasSet) {
  Peer peer;
  ClockEstimate clock;
  for (std::int64_t i = 0; i < 1000; ++i) {
    const std::int64_t sent_ns = kSecond + i * 10 * kMs;
    const std::int64_t stall_ns = i == 500 ? 2 * kSecond : 0;
    clock.Observe(peer.SourceNs(sent_ns), peer.Arrival(sent_ns) + stall_ns);
  }
  EXPECT_EQ(clock.times_set(), 0);
}

}  // namespace
}  // namespace acus::tracking
