#include "acus/base/core/machine.h"

#include <gmock/gmock.h>

namespace acus {
namespace {

TEST(MachineName, NamesTheProcessorAndItsThreads) {
  EXPECT_THAT(MachineName(), testing::MatchesRegex(".+, [0-9]+ threads"));
  EXPECT_EQ(MachineName(), MachineName());
}

TEST(ThisMachine, IsDescribed) {
  const Machine machine = ThisMachine();
  EXPECT_GE(machine.threads, 1);
  EXPECT_GT(machine.memory_gb, 0.1);
  EXPECT_LT(machine.memory_gb, 1e5);
  EXPECT_FALSE(machine.processor.empty());
  EXPECT_EQ(machine.processor.find(':'), std::string::npos);
  EXPECT_NE(machine.system, Machine().system);
  EXPECT_EQ(machine.system.find('"'), std::string::npos);
}

}  // namespace
}  // namespace acus
