#include "acus/rig/tracking/socket.h"

#include <chrono>
#include <gtest/gtest.h>
#include <thread>
#include <vector>

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

TEST(Transfers, NeverWait) {
  const Descriptor listener = ListenTcp("127.0.0.1", 0);
  const Connection there = ConnectTcp("127.0.0.1", PortOf(listener), 5000, WakeUp());
  const Descriptor here = AcceptTcp(listener);
  ASSERT_TRUE(here.valid());
  std::vector<std::uint8_t> bytes(1 << 20, 7);
  const Transfer nothing = Receive(here, bytes);
  EXPECT_EQ(nothing.state, TransferState::kWouldBlock);
  EXPECT_EQ(nothing.bytes, 0U);
  EXPECT_EQ(nothing.error, "");
  // The other side does not read: its buffer becomes full. Nothing of that is lost.
  std::size_t sent = 0;
  Transfer transfer;
  while ((transfer = Send(here, bytes)).state == TransferState::kOk) sent += transfer.bytes;
  EXPECT_EQ(transfer.state, TransferState::kWouldBlock);
  sent += transfer.bytes;
  std::size_t received = 0;
  for (int i = 0; received < sent && i < 1000; ++i) {
    received += Receive(there.socket, bytes).bytes;
    if (received < sent) std::this_thread::sleep_for(std::chrono::microseconds(100));
  }
  EXPECT_EQ(received, sent);
}

}  // namespace
}  // namespace acus::tracking
