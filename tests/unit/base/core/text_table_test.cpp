#include "acus/base/core/text_table.h"

#include <gtest/gtest.h>
#include <limits>

namespace acus {
namespace {

TEST(TextTable, SetsNumbersFlushRightAndCountsCharactersNotBytes) {
  EXPECT_EQ(
      TextTable({"name", "error mm"}, {{"nase \u00B5", "1.25"}, {"x", "-"}, {"ohr", "12.50"}}),
      "name    error mm\n"
      "------  --------\n"
      "nase \u00B5      1.25\n"
      "x              -\n"
      "ohr        12.50\n");
}

TEST(TextTable, ManagesWithoutRows) {
  EXPECT_EQ(TextTable({"a", "b"}, {}), "a  b\n-  -\n");
}

TEST(FixedText, RoundsToTheDigitsRequested) {
  EXPECT_EQ(FixedText(2.0 / 3, 3), "0.667");
  EXPECT_EQ(FixedText(-1.0, 0), "-1");
  EXPECT_EQ(FixedText(std::numeric_limits<double>::infinity(), 2), "inf");
  EXPECT_EQ(FixedText(-std::numeric_limits<double>::infinity(), 2), "-inf");
  EXPECT_EQ(FixedText(std::nan(""), 2), "nan");
  EXPECT_EQ(FixedText(-1.79e308, 30).size(), 1U + 309U + 1U + 30U);
}

TEST(RoundedText, KeepsTheDigitsRequestedAndAllBeforeThePoint) {
  EXPECT_EQ(RoundedText(2.0 / 3, 3), "0.667");
  EXPECT_EQ(RoundedText(-12.0, 3), "-12");
  EXPECT_EQ(RoundedText(999.4, 3), "999");
  EXPECT_EQ(RoundedText(1234.56, 3), "1235");
  EXPECT_EQ(RoundedText(-123456.0, 3), "-123456");
  EXPECT_EQ(RoundedText(0.0, 3), "0");
  EXPECT_EQ(RoundedText(1000.0, 3), "1000");
  EXPECT_EQ(RoundedText(-999999999.0, 3), "-999999999");
  EXPECT_EQ(RoundedText(1.5e-7, 3), "1.5e-07");
  EXPECT_EQ(RoundedText(2e9, 3), "2e+09");
  EXPECT_EQ(RoundedText(-std::numeric_limits<double>::infinity(), 3), "-inf");
}

}  // namespace
}  // namespace acus
