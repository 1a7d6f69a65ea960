// What threads hand to one another without waiting.
#include <gtest/gtest.h>
#include <thread>

#include "acus/run/live/duration_histogram.h"
#include "acus/run/live/force_mailbox.h"
#include "acus/run/live/ring.h"
#include "acus/run/live/triple_buffer.h"

namespace acus::live {
namespace {

TEST(Ring, GivesWhatItWasGivenInOrderAndRefusesWhatDoesNotFit) {
  Ring<int> ring(3);
  EXPECT_EQ(ring.Front(), nullptr);
  for (int round = 0; round < 5; ++round) {
    for (int i = 0; i < 3; ++i) EXPECT_TRUE(ring.Push(10 * round + i));
    EXPECT_FALSE(ring.Push(99));
    EXPECT_EQ(ring.size(), 3U);
    for (int i = 0; i < 3; ++i) {
      ASSERT_NE(ring.Front(), nullptr);
      EXPECT_EQ(*ring.Front(), 10 * round + i);
      ring.Pop();
    }
  }
}

TEST(Ring, LosesNothingBetweenTwoThreads) {
  Ring<std::int64_t> ring(64);
  constexpr std::int64_t kCount = 200'000;
  std::thread producer([&ring] {
    for (std::int64_t i = 0; i < kCount;) {
      if (ring.Push(i)) {
        ++i;
      } else {
        std::this_thread::yield();
      }
    }
  });
  for (std::int64_t i = 0; i < kCount;) {
    const std::int64_t* next = ring.Front();
    if (next == nullptr) {
      std::this_thread::yield();
      continue;
    }
    ASSERT_EQ(*next, i++);
    ring.Pop();
  }
  producer.join();
}

TEST(TripleBuffer, NeverShowsHalfAValueAndNeverAnOlderOne) {
  struct Value {
    std::int64_t first = 0;
    std::array<std::int64_t, 60> between{};
    std::int64_t last = 0;
  };
  TripleBuffer<Value> buffer;
  EXPECT_FALSE(buffer.Refresh());
  constexpr std::int64_t kCount = 200'000;
  std::thread writer([&buffer] {
    for (std::int64_t i = 1; i <= kCount; ++i) {
      Value& value = buffer.Back();
      value.first = i;
      value.between.fill(i);
      value.last = i;
      buffer.Publish();
    }
  });
  std::int64_t newest = 0;
  while (newest < kCount) {
    if (!buffer.Refresh()) {
      std::this_thread::yield();
      continue;
    }
    const Value& value = buffer.Front();
    ASSERT_EQ(value.first, value.last);
    ASSERT_EQ(value.between[30], value.first);
    ASSERT_GT(value.first, newest);
    newest = value.first;
  }
  writer.join();
  EXPECT_FALSE(buffer.Refresh());
}

TEST(ForceMailbox, GivesNoForceThatIsOldOrWasNeverPut) {
  ForceMailbox mailbox;
  EXPECT_EQ(mailbox.Get(0, 1000).force_n, Eigen::Vector3d::Zero());
  mailbox.Put({.force_n = {1, 2, 3}, .torque_nmm = {4, 5, 6}}, 100);
  EXPECT_EQ(mailbox.Get(150, 50).force_n, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(mailbox.Get(150, 50).torque_nmm, Eigen::Vector3d(4, 5, 6));
  EXPECT_EQ(mailbox.Get(151, 50).force_n, Eigen::Vector3d::Zero());
}

TEST(DurationHistogram, KnowsPercentilesToItsBins) {
  DurationHistogram histogram;
  EXPECT_EQ(histogram.QuantileNs(0.5), 0.0);
  for (int us = 1; us <= 1000; ++us) histogram.Add(us * 1000);
  EXPECT_EQ(histogram.count(), 1000);
  EXPECT_NEAR(histogram.QuantileNs(0.5), 500e3, 0.1 * 500e3);
  EXPECT_NEAR(histogram.QuantileNs(0.99), 990e3, 0.1 * 990e3);
  EXPECT_EQ(histogram.QuantileNs(1.0), 1000e3);
  EXPECT_EQ(histogram.max_ns(), 1'000'000);
  histogram.Add(-5);
  histogram.Add(std::int64_t{1} << 60);
  EXPECT_EQ(histogram.count(), 1002);
  EXPECT_LE(histogram.QuantileNs(0.0), 110.0);
}

}  // namespace
}  // namespace acus::live
