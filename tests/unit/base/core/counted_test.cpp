#include "acus/base/core/counted.h"

#include <gtest/gtest.h>

namespace acus {
namespace {

TEST(Counted, OneIsSingular) {
  EXPECT_EQ(Counted(0, "gap"), "0 gaps");
  EXPECT_EQ(Counted(1, "gap"), "1 gap");
  EXPECT_EQ(Counted(2, "gap"), "2 gaps");
  EXPECT_EQ(Counted(1, "gap# without samples"), "1 gap without samples");
  EXPECT_EQ(Counted(12, "gap# without samples"), "12 gaps without samples");
}

}  // namespace
}  // namespace acus
