#include "acus/assess/tuning/pareto.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>

#include "acus/base/core/random.h"

namespace acus::tuning {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

bool IsBeaten(const CostAndError& a, std::span<const CostAndError> others) {
  for (const CostAndError& b : others) {
    if (b.cost <= a.cost && b.error <= a.error && (b.cost < a.cost || b.error < a.error)) {
      return true;
    }
  }
  return false;
}

TEST(ParetoFront, IsWhatNoOtherSettingBeats) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    RandomStream random(seed, "pareto");
    std::vector<CostAndError> settings;
    const auto count = 1 + random.Next() % 40;
    for (std::size_t i = 0; i < count; ++i) {
      // Few different values, so that there are ties of all kinds.
      settings.push_back(
          {1.0 + static_cast<double>(random.Next() % 12), static_cast<double>(random.Next() % 12)});
      if (random.Next() % 10 == 0) settings.back().error = kNan;
      if (random.Next() % 10 == 0) settings.back().cost = kNan;
    }
    const std::vector<std::size_t> front = ParetoFront(settings);
    for (std::size_t n = 0; n < front.size(); ++n) {
      const CostAndError& on = settings[front[n]];
      ASSERT_FALSE(std::isnan(on.cost) || std::isnan(on.error));
      EXPECT_FALSE(IsBeaten(on, settings)) << "seed " << seed;
      if (n > 0) {
        EXPECT_GT(on.cost, settings[front[n - 1]].cost);
        EXPECT_LT(on.error, settings[front[n - 1]].error);
      }
    }
    for (const CostAndError& setting : settings) {
      if (std::isnan(setting.cost) || std::isnan(setting.error)) continue;
      if (IsBeaten(setting, settings)) continue;
      const auto is_same = [&](std::size_t i) {
        return settings[i].cost == setting.cost && settings[i].error == setting.error;
      };
      EXPECT_EQ(std::ranges::count_if(front, is_same), 1) << "seed " << seed;
    }
  }
}

TEST(ParetoFront, OfEqualSettingsTakesTheFirst) {
  const std::vector<CostAndError> settings = {{2.0, 1.0}, {1.0, 2.0}, {1.0, 2.0}, {2.0, 1.0}};
  EXPECT_EQ(ParetoFront(settings), (std::vector<std::size_t>{1, 0}));
}

TEST(ParetoFront, HasAnInfiniteErrorOnlyWhereNothingIsCheaper) {
  const std::vector<CostAndError> settings = {{3.0, kInfinity}, {1.0, kInfinity}, {2.0, 0.5}};
  EXPECT_EQ(ParetoFront(settings), (std::vector<std::size_t>{1, 2}));
}

TEST(ParetoFront, OfNothingIsEmpty) {
  EXPECT_TRUE(ParetoFront({}).empty());
  const std::vector<CostAndError> settings = {{kNan, 1.0}, {1.0, kNan}};
  EXPECT_TRUE(ParetoFront(settings).empty());
}

}  // namespace
}  // namespace acus::tuning
