#include "acus/base/core/enough_stack.h"

#include <cstdlib>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <thread>

namespace acus {
namespace {

/// Uses 4 kB of stack for each depth.
int UseStack(int depth) {
  volatile char frame[4096];  // NOLINT: an array on the stack is the point.
  frame[depth % 4096] = 1;
  return depth == 0 ? 0 : UseStack(depth - 1) + frame[depth % 4096];
}

/// 0 if 4 MB can be used, also in a new thread, where the limit is 256 kB.
[[noreturn]] void ExitWithSmallStack() {
  const rlimit low{std::size_t{256} << 10U, std::size_t{256} << 10U};
  ::setrlimit(RLIMIT_STACK, &low);
  int depth = 0;
  int depth_in_thread = 0;
  CallWithEnoughStack([&] {
    depth = UseStack(1000);
    std::thread([&] { depth_in_thread = UseStack(1000); }).join();
  });
  std::_Exit(depth == 1000 && depth_in_thread == 1000 ? 0 : 1);
}

TEST(EnoughStackDeathTest, SufficesWhereTheLimitIsLow) {
  EXPECT_EXIT(ExitWithSmallStack(), ::testing::ExitedWithCode(0), "");
}

TEST(EnoughStack, IsThatOfTheCallerWhereItSuffices) {
  std::thread::id id;
  CallWithEnoughStack([&] { id = std::this_thread::get_id(); });
  EXPECT_EQ(id, std::this_thread::get_id());
}

}  // namespace
}  // namespace acus
