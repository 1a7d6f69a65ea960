#include "acus/base/report/residual_plot.h"

#include <gmock/gmock.h>

namespace acus::report {
namespace {

using testing::ElementsAre;

TEST(ResidualPlot, LeavesOutDotsThatHaveNoAnswer) {
  const Plot plot = ResidualPlot("R", {"a", "b", "c"}, {1, 2, 3}, {0.5, std::nullopt, 4.0});
  ASSERT_EQ(plot.series.size(), 2U);
  EXPECT_THAT(plot.series[0].y, ElementsAre(1, 2, 3));
  EXPECT_THAT(plot.series[1].x, ElementsAre(0, 2));
  EXPECT_THAT(plot.series[1].y, ElementsAre(0.5, 4.0));
  EXPECT_EQ(ResidualPlot("R", {}, {1, 2}).series.size(), 1U);
}

}  // namespace
}  // namespace acus::report
