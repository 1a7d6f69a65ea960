#include "acus/patient/fitting/series_fit.h"

#include <cmath>
#include <gtest/gtest.h>

#include "acus/base/core/random.h"

namespace acus::fitting {
namespace {

/// y = a exp(-b i) at 200 samples.
SeriesModel Decay() {
  return [](std::span<const double> p, std::span<double> predicted) {
    for (std::size_t i = 0; i < predicted.size(); ++i) {
      predicted[i] = p[0] * std::exp(-p[1] * static_cast<double>(i));
    }
  };
}

std::vector<double> Noisy(const SeriesModel& model, const std::vector<double>& truth,
                          std::uint64_t seed, double noise) {
  std::vector<double> y(200);
  model(truth, y);
  RandomStream random(seed, "series");
  for (double& v : y) v += noise * random.Normal();
  return y;
}

TEST(SeriesFit, IntervalsHoldTheTruthAsOftenAsTheySay) {
  int inside = 0;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    const auto y = Noisy(Decay(), {2.0, 0.03}, seed, 0.05);
    const SeriesFit fit = FitSeries(Decay(), y, {{"a", 1.0, 0.0, 10.0}, {"b", 0.1, 0.0, 1.0}});
    ASSERT_TRUE(fit.converged);
    EXPECT_NEAR(fit.parameters[0], 2.0, 0.1);
    EXPECT_FALSE(fit.undetermined[0] || fit.undetermined[1] || fit.at_bound[0]);
    inside += fit.Of(0).Contains(2.0) ? 1 : 0;
  }
  EXPECT_GE(inside, 180);  // 95 % of 200, less three standard deviations.
  EXPECT_LE(inside, 199);
}

TEST(SeriesFit, WeightsThatAreInformationGiveTheSameIntervals) {
  const auto y = Noisy(Decay(), {2.0, 0.03}, 7, 0.05);
  const std::vector<SeriesParameter> start = {{"a", 1.0, 0.0, 10.0}, {"b", 0.1, 0.0, 1.0}};
  const SeriesFit plain = FitSeries(Decay(), y, start);
  const SeriesFit known = FitSeries(
      Decay(), y, start,
      {.weight = std::vector<double>(200, 1.0 / (0.05 * 0.05)), .weight_is_information = true});
  EXPECT_NEAR(known.parameters[0], plain.parameters[0], 1e-6);
  EXPECT_NEAR(known.Of(0).standard_error, plain.Of(0).standard_error,
              0.35 * plain.Of(0).standard_error);
}

TEST(SeriesFit, SaysWhichParametersTheSamplesDoNotDetermine) {
  // Only a + b is seen, and d not at all.
  const SeriesModel model = [](std::span<const double> p, std::span<double> predicted) {
    for (std::size_t i = 0; i < predicted.size(); ++i) {
      predicted[i] = p[0] + p[1] + p[2] * static_cast<double>(i);
    }
  };
  const auto y = Noisy(model, {1.0, 2.0, 0.1, 0.0}, 1, 0.01);
  const SeriesFit fit = FitSeries(
      model, y,
      {{"a", 0.0, -5.0, 5.0}, {"b", 0.0, -5.0, 5.0}, {"c", 0.0, -1.0, 1.0}, {"d", 0.0, -1.0, 1.0}});
  EXPECT_TRUE(fit.undetermined[0]);
  EXPECT_TRUE(fit.undetermined[1]);
  EXPECT_FALSE(fit.undetermined[2]);
  EXPECT_TRUE(fit.undetermined[3]);
  EXPECT_NEAR(fit.parameters[2], 0.1, 1e-3);
  EXPECT_EQ(fit.Bounded(0).low, -5.0);
  EXPECT_EQ(fit.Bounded(0).high, 5.0);
}

TEST(SeriesFit, StaysInsideItsBoundsAndSaysSo) {
  const auto y = Noisy(Decay(), {2.0, 0.03}, 3, 0.01);
  const SeriesFit fit = FitSeries(Decay(), y, {{"a", 1.0, 0.0, 1.5}, {"b", 0.1, 0.1, 0.1}});
  EXPECT_LE(fit.parameters[0], 1.5);
  EXPECT_TRUE(fit.at_bound[0]);
  EXPECT_EQ(fit.parameters[1], 0.1);
  EXPECT_TRUE(fit.undetermined[1]);  // Held.
}

TEST(SeriesFit, ARobustFitForgetsLeaps) {
  auto y = Noisy(Decay(), {2.0, 0.03}, 5, 0.01);
  for (std::size_t i = 20; i < 30; ++i) y[i] += 5.0;
  const std::vector<SeriesParameter> start = {{"a", 1.0, 0.0, 10.0}, {"b", 0.1, 0.0, 1.0}};
  const double plain = FitSeries(Decay(), y, start).parameters[0];
  const double robust = FitSeries(Decay(), y, start, {.robust = true}).parameters[0];
  EXPECT_GT(std::abs(plain - 2.0), 0.3);
  EXPECT_LT(std::abs(robust - 2.0), 0.05);
}

TEST(SeriesFit, TooFewSamplesOrAModelThatIsNotFiniteDoesNotConverge) {
  const std::vector<double> few = {1.0, 0.9, 0.8};
  EXPECT_FALSE(FitSeries(Decay(), few, {{"a", 1.0, 0.0, 10.0}, {"b", 0.1, 0.0, 1.0}}).converged);
  const SeriesModel bad = [](std::span<const double>, std::span<double> predicted) {
    for (double& v : predicted) v = std::nan("");
  };
  EXPECT_FALSE(FitSeries(bad, std::vector<double>(50, 1.0), {{"a", 1.0, 0.0, 10.0}}).converged);
}

}  // namespace
}  // namespace acus::fitting
