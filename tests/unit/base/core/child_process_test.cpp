#include "acus/base/core/child_process.h"

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <gtest/gtest.h>
#include <stdexcept>
#include <thread>
#include <unistd.h>

#include "acus/base/core/error.h"

namespace acus::core {
namespace {

using End = ChildResult::End;

TEST(RunInChild, BringsBytesBack) {
  const std::string bytes(3'000'000, 'x');
  const ChildResult result = RunInChild([&] { return bytes + '\0'; }, {});
  EXPECT_EQ(result.end, End::kDone);
  EXPECT_EQ(result.bytes.size(), bytes.size() + 1);
}

TEST(RunInChild, SurvivesEveryWayToEnd) {
  EXPECT_EQ(RunInChild([]() -> std::string { throw std::runtime_error("no"); }, {}).problem, "no");
  const ChildResult number = RunInChild([]() -> std::string { throw 3; }, {});
  EXPECT_EQ(number.end, End::kThrewNumber);
  EXPECT_EQ(number.problem, "3");
  EXPECT_EQ(RunInChild([]() -> std::string { std::_Exit(0); }, {}).end, End::kCrashed);
  EXPECT_EQ(RunInChild([]() -> std::string { std::_Exit(1); }, {}).end, End::kCrashed);
  EXPECT_EQ(RunInChild([]() -> std::string { std::abort(); }, {}).end, End::kCrashed);
  EXPECT_EQ(RunInChild(
                []() -> std::string {
                  ::raise(SIGSEGV);
                  return {};
                },
                {})
                .end,
            End::kCrashed);
}

TEST(RunInChild, StopsAChildThatHangs) {
  ChildLimits limits;
  limits.time_s = 0.3;
  const auto start = std::chrono::steady_clock::now();
  const auto hang = []() -> std::string {
    for (;;) std::this_thread::sleep_for(std::chrono::milliseconds(50));
  };
  EXPECT_EQ(RunInChild(hang, limits).end, End::kTimedOut);
  limits.time_s = 60.0;
  limits.on_wait = [] { throw Cancelled(); };
  EXPECT_THROW(RunInChild(hang, limits), Cancelled);
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(20));
}

}  // namespace
}  // namespace acus::core
