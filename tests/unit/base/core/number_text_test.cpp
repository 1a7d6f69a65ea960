#include "acus/base/core/number_text.h"

#include <cstdint>
#include <gtest/gtest.h>

namespace acus {
namespace {

TEST(NumberText, IsTheWholeWordOrNothing) {
  EXPECT_EQ(ParseNumber<int>("-12"), -12);
  EXPECT_EQ(ParseNumber<double>("2.5e-3"), 2.5e-3);
  for (const char* text : {"", " 1", "1 ", "+1", "1x", "1,5", "x"}) {
    EXPECT_FALSE(ParseNumber<int>(text)) << text;
    EXPECT_FALSE(ParseNumber<double>(text)) << text;
  }
  EXPECT_FALSE(ParseNumber<int>("1.5"));
}

TEST(NumberText, IsNothingOutOfItsRange) {
  EXPECT_EQ(ParseNumber<std::uint8_t>("255"), 255);
  EXPECT_FALSE(ParseNumber<std::uint8_t>("256"));
  EXPECT_FALSE(ParseNumber<std::uint8_t>("-1"));
  EXPECT_FALSE(ParseNumber<double>("1e400"));
}

TEST(NumberText, FiniteExcludesInfinityAndNan) {
  EXPECT_EQ(ParseFinite("-0.25"), -0.25);
  EXPECT_TRUE(ParseNumber<double>("inf"));
  EXPECT_FALSE(ParseFinite("inf"));
  EXPECT_FALSE(ParseFinite("nan"));
}

}  // namespace
}  // namespace acus
