#include "acus/run/live/session_request.h"

#include <gmock/gmock.h>

#include "acus/base/core/error.h"

namespace acus::live {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

TEST(SessionRequest, HasTheDefaultsOfTheCommandLine) {
  const SessionRequest request =
      ParseSessionRequest(R"({"format": "acus-session-request/1", "output": "s"})");
  EXPECT_EQ(request.output, "s");
  EXPECT_TRUE(request.scenario.empty() && request.exercise.empty() && request.hand.empty());
  EXPECT_TRUE(request.screenshot.empty() && request.caption.empty());
  EXPECT_EQ(request.duration_s, 0.0);
  EXPECT_EQ(request.trial, 1);
  EXPECT_FALSE(request.left_handed);
}

TEST(SessionRequest, IsRefusedWithTheReason) {
  const auto reading = [](const char* line) { return [line] { ParseSessionRequest(line); }; };
  EXPECT_THAT(reading(""), ThrowsMessage<InputError>(HasSubstr("is no JSON object")));
  EXPECT_THAT(reading("[1]"), ThrowsMessage<InputError>(HasSubstr("is no JSON object")));
  EXPECT_THAT(reading(R"({"format": "acus-session-request/1"})"),
              ThrowsMessage<InputError>(HasSubstr("/output: missing")));
  EXPECT_THAT(reading(R"({"format": "acus-session-request/1", "output": "s", "trial": 0})"),
              ThrowsMessage<InputError>(HasSubstr("/trial")));
  EXPECT_THAT(reading(R"({"format": "acus-session-request/1", "output": "s", "exercize": ""})"),
              ThrowsMessage<InputError>(HasSubstr("exercise")));
}

}  // namespace
}  // namespace acus::live
