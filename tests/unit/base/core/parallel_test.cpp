#include "acus/base/core/parallel.h"

#include <atomic>
#include <gmock/gmock.h>
#include <stdexcept>
#include <thread>
#include <vector>

namespace acus {
namespace {

std::vector<int> Squares(int count, int num_threads) {
  std::vector<int> squares(static_cast<std::size_t>(count), -1);
  ParallelFor(count, num_threads, [&](int i) { squares[static_cast<std::size_t>(i)] = i * i; });
  return squares;
}

TEST(ParallelFor, CallsEachIndexOnceOnAnyNumberOfThreads) {
  for (const int count : {0, 1, 2, 1000}) {
    const std::vector<int> expected = Squares(count, 1);
    for (const int num_threads : {2, 4, 16}) {
      std::atomic<int> calls{0};
      ParallelFor(count, num_threads, [&](int /*i*/) { ++calls; });
      EXPECT_EQ(calls, count);
      EXPECT_EQ(Squares(count, num_threads), expected);
    }
  }
}

TEST(ParallelFor, RethrowsAndStops) {
  for (const int num_threads : {1, 4}) {
    EXPECT_THROW(ParallelFor(100, num_threads,
                             [](int i) {
                               if (i == 50) throw std::runtime_error("fifty");
                             }),
                 std::runtime_error);
  }
}

TEST(ParallelFor, LoopsWithinLoopsAndBesideLoopsCallEachIndexOnce) {
  constexpr int kOuter = 6;
  constexpr int kInner = 50;
  std::vector<int> calls(kOuter * kInner, 0);
  const auto inner = [&calls](int o) {
    ParallelFor(kInner, 3,
                [&calls, o](int i) { ++calls[static_cast<std::size_t>(o * kInner + i)]; });
  };
  ParallelFor(kOuter, 3, inner);
  EXPECT_THAT(calls, testing::Each(1));
  {
    // Threads of the caller's own, at the same time, again and again.
    std::vector<std::jthread> callers;
    for (int o = 0; o < kOuter; ++o) {
      callers.emplace_back([&inner, o] {
        for (int n = 0; n < 100; ++n) inner(o);
      });
    }
  }
  EXPECT_THAT(calls, testing::Each(101));
}

TEST(ParallelFor, SaysNothingWhenThereAreFewerCoresThanThreads) {
  testing::internal::CaptureStderr();
  Squares(1000, 64);
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

}  // namespace
}  // namespace acus
