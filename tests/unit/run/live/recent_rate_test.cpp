#include "acus/run/live/recent_rate.h"

#include <gtest/gtest.h>

namespace acus::live {
namespace {

TEST(RecentRate, ForgetsWhatHasPassed) {
  constexpr std::int64_t kStepNs = 100'000'000;
  RecentRate late(10.0);
  for (int i = 0; i <= 50; ++i) late.Add(i * kStepNs, i < 1 ? 0 : 1);
  EXPECT_EQ(late.recent(), 1) << "one slow step 5 s ago";
  EXPECT_EQ(late.per_s(), 0.0) << "no rate before the window is full";
  for (int i = 51; i <= 200; ++i) late.Add(i * kStepNs, 1);
  EXPECT_EQ(late.recent(), 0);
  RecentRate images(5.0);
  for (int i = 0; i <= 100; ++i) images.Add(i * kStepNs, 3 * i);
  EXPECT_NEAR(images.per_s(), 30.0, 1e-9);
}

}  // namespace
}  // namespace acus::live
