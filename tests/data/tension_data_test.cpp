// Strips of pig tissue under tension, of three animals: how far a law of one is from another.
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <gtest/gtest.h>
#include <map>
#include <string>
#include <vector>

#include "acus/base/math/statistics.h"
#include "acus/patient/fitting/tension_fit.h"
#include "support/shared_data.h"

namespace acus::fitting {
namespace {

struct Strip {
  std::string animal;
  double stress_mpa = 0.0;  ///< At a stretch of 1.3, by the law of Yeoh.
  double fung_b = 0.0;
};

/// By tissue: the letter in the middle of "04-p-1".
std::map<std::string, std::vector<Strip>> StripsOf(const std::filesystem::path& root) {
  std::map<std::string, std::vector<Strip>> strips;
  for (const char* folder : {"tension_pork", "tension_pork_more"}) {
    if (!std::filesystem::exists(root / folder)) continue;
    for (const auto& entry : std::filesystem::directory_iterator(root / folder)) {
      const TensionFit fit = FitTension(ReadTensionTest(entry.path()));
      const std::string name = entry.path().stem().string();
      Strip strip{.animal = name.substr(0, 2)};
      for (const LawFit& law : fit.laws) {
        std::vector<double> parameters;
        for (const Estimate& estimate : law.parameters) parameters.push_back(estimate.value);
        if (law.law == HyperelasticLaw::kYeoh)
          strip.stress_mpa = NominalStressMpa(law.law, parameters, 1.3);
        if (law.law == HyperelasticLaw::kFung) strip.fung_b = parameters[1];
      }
      strips[name.substr(3, 1)].push_back(strip);
    }
  }
  return strips;
}

TEST(PulledPork, ALawOfOneAnimalIsNotThatOfAnother) {
  const auto root = testing_support::SharedData("mechanics");
  if (!root) GTEST_SKIP() << "test data mechanics is not here";
  const auto strips = StripsOf(*root);
  std::vector<double> logs;
  for (const auto& [tissue, of_tissue] : strips) {
    double largest = 0.0;
    for (const Strip& a : of_tissue) {
      for (const Strip& b : of_tissue) {
        if (a.animal == b.animal) continue;
        logs.push_back(std::log(a.stress_mpa / b.stress_mpa));
        largest = std::max(largest, logs.back());
      }
    }
    std::printf("  tissue %s: stress of %zu animals differs by up to a factor of %.1f\n",
                tissue.c_str(), of_tissue.size(), std::exp(largest));
  }
  const double factor = std::exp(math::RootMeanSquare(logs));
  std::printf("  all tissues: factor %.2f (geometric standard deviation)\n", factor);
  EXPECT_NEAR(factor, 3.7, 0.1);  // As TensionTable and docs/models/force_fit.md state.
  // Skin, as configs/elasticity/default.json states.
  std::vector<double> exponents;
  for (const Strip& strip : strips.at("p")) exponents.push_back(strip.fung_b);
  EXPECT_NEAR(math::Mean(exponents), 1.2, 0.1);
}

}  // namespace
}  // namespace acus::fitting
