#include "core/parallel.h"

#include <atomic>
#include <gmock/gmock.h>
#include <stdexcept>
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

TEST(ParallelFor, SaysNothingWhenThereAreFewerCoresThanThreads) {
  testing::internal::CaptureStderr();
  Squares(1000, 64);
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

}  // namespace
}  // namespace acus
