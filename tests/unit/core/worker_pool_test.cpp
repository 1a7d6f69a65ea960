#include "core/worker_pool.h"

#include <atomic>
#include <gtest/gtest.h>
#include <vector>

namespace acus {
namespace {

TEST(WorkerPool, CallsEachPieceOnceInEveryLoop) {
  for (const int threads : {0, 1, 2, 4}) {
    WorkerPool pool(threads);
    EXPECT_GE(pool.num_threads(), 1);
    std::vector<int> calls(257);
    for (int round = 1; round <= 300; ++round) {
      const int count = round % 3 == 0 ? 257 : round % 5;
      for (int& n : calls) n = 0;
      pool.Run(count, [&calls](int i) { ++calls[static_cast<std::size_t>(i)]; });
      for (int i = 0; i < 257; ++i) {
        ASSERT_EQ(calls[static_cast<std::size_t>(i)], i < count ? 1 : 0);
      }
    }
  }
}

TEST(WorkerPool, EndsWithoutEverHavingRun) {
  const WorkerPool pool(3);
  EXPECT_LE(pool.num_threads(), 3);
}

}  // namespace
}  // namespace acus
