#include "acus/rig/tracking/socket.h"

#include <gtest/gtest.h>

#include "acus/base/core/error.h"

namespace acus::tracking {
namespace {

using Address = std::pair<std::string, int>;

TEST(ParseAddress, TakesHostPortBothOrNeither) {
  EXPECT_EQ(ParseAddress("tracker:18945", 18944), Address("tracker", 18945));
  EXPECT_EQ(ParseAddress("tracker", 18944), Address("tracker", 18944));
  EXPECT_EQ(ParseAddress(":18945", 18944), Address("", 18945));
  EXPECT_EQ(ParseAddress("tracker:0", 18944), Address("tracker", 0));
  EXPECT_EQ(ParseAddress("tracker:65535", 18944), Address("tracker", 65535));
}

TEST(ParseAddress, ColonsOfAnAddressStandInBrackets) {
  EXPECT_EQ(ParseAddress("[::1]", 18944), Address("::1", 18944));
  EXPECT_EQ(ParseAddress("[::1]:18945", 18944), Address("::1", 18945));
  EXPECT_EQ(ParseAddress("[fe80::2:3]", 18944), Address("fe80::2:3", 18944));
}

TEST(ParseAddress, RefusesWhatIsNoPort) {
  for (const char* text :
       {"tracker:", "tracker:65536", "tracker:123456", "tracker:-1", "tracker:18a", "[::1]:x"}) {
    EXPECT_THROW(ParseAddress(text, 18944), InputError) << text;
  }
}

}  // namespace
}  // namespace acus::tracking
