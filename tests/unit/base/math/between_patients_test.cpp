#include "acus/base/math/between_patients.h"

#include <cmath>
#include <gtest/gtest.h>
#include <vector>

#include "acus/base/math/statistics.h"

namespace acus::math {
namespace {

TEST(PatientFactor, IsOneForTheMedianPatientAndWithoutScatter) {
  EXPECT_EQ(PatientFactor(1.4, 0, 7), 1.0);
  EXPECT_EQ(PatientFactor(1.0, 3, 7), 1.0);
  EXPECT_EQ(PatientFactor(0.0, 3, 7), 1.0);
}

TEST(PatientFactor, ScattersAsStatedAboutOne) {
  constexpr double kGsd = 1.4;
  std::vector<double> logarithms;
  int inside = 0;
  for (std::uint64_t seed = 1; seed <= 4000; ++seed) {
    const double factor = PatientFactor(kGsd, seed, 7);
    logarithms.push_back(std::log(factor));
    if (factor > 1.0 / kGsd && factor < kGsd) ++inside;
  }
  // Four standard errors: 1/sqrt(4000) of the SD for the mean, 1/sqrt(8000) for the SD.
  EXPECT_NEAR(Mean(logarithms), 0.0, 4.0 * std::log(kGsd) / std::sqrt(4000.0));
  EXPECT_NEAR(StandardDeviation(logarithms) / std::log(kGsd), 1.0, 4.0 / std::sqrt(8000.0));
  EXPECT_NEAR(inside / 4000.0, 0.6827, 4.0 * std::sqrt(0.6827 * 0.3173 / 4000.0));
}

TEST(PatientFactor, TissuesAndPatientsAreIndependentAndScatterIsTheOnlyScale) {
  std::vector<double> products;
  for (std::uint64_t seed = 1; seed <= 4000; ++seed) {
    products.push_back(std::log(PatientFactor(std::exp(1.0), seed, 7)) *
                       std::log(PatientFactor(std::exp(1.0), seed, 8)));
  }
  EXPECT_NEAR(Mean(products), 0.0, 4.0 / std::sqrt(4000.0));
  // The same patient is as far from the median on any scale.
  EXPECT_NEAR(std::log(PatientFactor(2.0, 5, 7)) / std::log(PatientFactor(1.2, 5, 7)),
              std::log(2.0) / std::log(1.2), 1e-12);
}

}  // namespace
}  // namespace acus::math
