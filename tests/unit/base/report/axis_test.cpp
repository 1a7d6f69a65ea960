#include "acus/base/report/axis.h"

#include <cmath>
#include <gmock/gmock.h>

namespace acus::report {
namespace {

using testing::ElementsAre;

Extent Between(double low, double high) {
  Extent extent;
  extent.Add(low);
  extent.Add(high);
  return extent;
}

std::vector<std::string> Labels(const Axis& axis) {
  std::vector<std::string> labels;
  for (const Tick& tick : axis.ticks()) {
    if (!tick.label.empty()) labels.push_back(tick.label);
  }
  return labels;
}

TEST(Axis, StepsBy1Or2Or5) {
  EXPECT_THAT(Labels(Axis(Between(0, 10), false, 0, 5)),
              ElementsAre("0", "2", "4", "6", "8", "10"));
  EXPECT_THAT(Labels(Axis(Between(0, 0.9), false, 0, 5)),
              ElementsAre("0.0", "0.2", "0.4", "0.6", "0.8"));
  EXPECT_THAT(Labels(Axis(Between(-73, 61), false, 0, 4)), ElementsAre("\u221250", "0", "50"));
}

TEST(Axis, MovesLargeAndSmallValuesIntoAnExponent) {
  const Axis small(Between(0, 3e-6), false, 0, 4);
  EXPECT_EQ(small.exponent(), -6);
  EXPECT_THAT(Labels(small), ElementsAre("0", "1", "2", "3"));
  const Axis large(Between(0, 250000), false, 0, 5);
  EXPECT_EQ(large.exponent(), 3);
  EXPECT_THAT(Labels(large), ElementsAre("0", "50", "100", "150", "200", "250"));
  EXPECT_DOUBLE_EQ(large.Fraction(125000), 0.5);
}

TEST(Axis, GivesAConstantRoomOnBothSides) {
  for (const double value : {0.0, 5.0, -1e7, 1e-200}) {
    const Axis axis(Between(value, value), false, 0, 5);
    EXPECT_NEAR(axis.Fraction(value), 0.5, 1e-9) << value;
    EXPECT_GE(axis.ticks().size(), 2U) << value;
  }
}

TEST(Axis, GivesAConstantOnALogarithmicAxisHalfADecadeOnBothSides) {
  for (const double value : {3e-7, 1.0, 250.0}) {
    const Axis axis(Between(value, value), true, 0, 5);
    EXPECT_NEAR(axis.low(), value / std::sqrt(10.0), 1e-9 * value);
    EXPECT_NEAR(axis.high(), value * std::sqrt(10.0), 1e-9 * value);
  }
}

TEST(Axis, LeavesNoRoomBelowZeroWhereBarsStandOnIt) {
  const Axis axis(Between(0, 10), false, 0.05, 5, /*sits_on_zero=*/true);
  EXPECT_EQ(axis.low(), 0.0);
  EXPECT_EQ(axis.high(), 10.5);
  EXPECT_EQ(Axis(Between(-10, 0), false, 0.05, 5, true).high(), 0.0);
  EXPECT_EQ(Axis(Between(0, 10), false, 0.05, 5).low(), -0.5);
}

TEST(Axis, LabelsDecadesOfALogarithmicAxis) {
  const Axis axis(Between(1e-3, 1e2), true, 0, 8);
  EXPECT_THAT(Labels(axis), ElementsAre("10\u207B\u00B3", "10\u207B\u00B2", "10\u207B\u00B9", "1",
                                        "10", "10\u00B2"));
  EXPECT_NEAR(axis.Fraction(std::sqrt(1e-1)), 0.5, 1e-12);
  EXPECT_LE(Labels(Axis(Between(1e-200, 1e200), true, 0, 8)).size(), 9U);
  EXPECT_THAT(Labels(Axis(Between(2, 8), true, 0, 8)),
              ElementsAre("2", "3", "4", "5", "6", "7", "8"));
}

}  // namespace
}  // namespace acus::report
