#include "acus/rig/tracking/igtl_link.h"

#include <gtest/gtest.h>

namespace acus::tracking {
namespace {

class IgtlLinkTest : public testing::Test {
 protected:
  Descriptor listener_ = ListenTcp("127.0.0.1", 0);
  Connection there_ = ConnectTcp("127.0.0.1", PortOf(listener_), 5000, WakeUp());
  IgtlLink link_{AcceptTcp(listener_)};
  WakeUp wake_;

  std::optional<IgtlMessage> Receiving(const Bytes& bytes) {
    Send(there_.socket, bytes);
    link_.Exchange(5000, wake_);
    return link_.Next();
  }
};

TEST_F(IgtlLinkTest, OneByteTooManyEndsIt) {
  const Bytes message = PackQuery("STP_TDATA", "x");
  const auto whole = Receiving(message);
  ASSERT_TRUE(whole);
  EXPECT_EQ(whole->header.device, "x");
  EXPECT_TRUE(link_.ok());
  Bytes shifted = message;
  shifted.insert(shifted.begin(), 0xFF);
  EXPECT_FALSE(Receiving(shifted));
  EXPECT_NE(link_.trouble().find("no OpenIGTLink message"), std::string::npos) << link_.trouble();
}

}  // namespace
}  // namespace acus::tracking
