#include "acus/patient/fitting/indentation_fit.h"

#include <cmath>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "acus/base/core/random.h"
#include "acus/patient/fitting/csv_number.h"

namespace acus::fitting {
namespace {

/// fung with b 2; 0.25 with 0.3 s, 0.2 with 2 s, 0.15 with 15 s.
IndentationShape TrueShape() {
  IndentationShape shape{.law = HyperelasticLaw::kFung, .parameters = {1.0, 2.0}, .relaxation = {}};
  shape.relaxation.share = {0.25, 0.2, 0.15};
  shape.relaxation.time_s = {0.3, 2.0, 15.0};
  shape.relaxation.num_terms = 3;
  return shape;
}

/// 12 mm thick, met at 0.5 mm; 1 mm/s to 5 mm, held for 10 s; 10 Hz.
IndentationTest Press(const IndentationShape& shape, double stiffness_n, double noise_n,
                      std::uint64_t seed) {
  IndentationTest test{.name = std::to_string(seed),
                       .thickness_mm = 12.0,
                       .time_s = {},
                       .depth_mm = {},
                       .force_n = {}};
  for (int i = 0; i <= 160; ++i) {
    test.time_s.push_back(0.1 * i);
    test.depth_mm.push_back(std::clamp(0.1 * (i - 5), 0.0, 5.0));
  }
  test.force_n = ReplayIndentation(shape, test, 0.5);
  RandomStream noise(seed, "press");
  for (double& force : test.force_n) force = stiffness_n * force + noise_n * noise.Normal();
  return test;
}

// Uniaxial compression is dW/dlambda too.
TEST(Indentation, PressureIsTheSlopeOfTheEnergy) {
  for (const double stretch : {0.98, 0.8, 0.5}) {
    const double b = 1.5;
    const auto energy = [&](double l) {
      return 0.5 / b * (std::exp(b * (l * l + 2.0 / l - 3.0)) - 1.0);
    };
    const double slope = (energy(stretch + 1e-6) - energy(stretch - 1e-6)) / 2e-6;
    const std::vector<double> p = {1.0, b};
    EXPECT_NEAR(CompressiveStressMpa(HyperelasticLaw::kFung, p, stretch), -slope,
                1e-6 * std::max(1.0, -slope));
    EXPECT_EQ(NominalStressMpa(HyperelasticLaw::kFung, p, stretch), 0.0);
  }
}

// A step that is held: S times 1 - sum share (1 - exp(-t / time)); however it is sampled.
TEST(Indentation, AHeldStepFallsByItsPronySeries) {
  IndentationTest test{
      .name = "step", .thickness_mm = 10.0, .time_s = {}, .depth_mm = {}, .force_n = {}};
  for (const double t : {0.0, 1e-6, 0.2, 1.0, 7.0, 30.0}) {
    test.time_s.push_back(t);
    test.depth_mm.push_back(t > 0.0 ? 4.0 : 0.0);
  }
  const std::vector<double> force = ReplayIndentation(TrueShape(), test, 0.0);
  const double stress = CompressiveStressMpa(HyperelasticLaw::kFung, TrueShape().parameters, 0.6);
  for (std::size_t i = 1; i < force.size(); ++i) {
    const double t = test.time_s[i];
    const double left = 1.0 + 0.25 * std::expm1(-t / 0.3) + 0.2 * std::expm1(-t / 2.0) +
                        0.15 * std::expm1(-t / 15.0);
    EXPECT_NEAR(force[i] / stress, left, 1e-5) << t;
  }
}

TEST(Indentation, TheShapeIsFoundAgain) {
  std::vector<IndentationTest> tests;
  std::vector<IndentationFit> fits;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    tests.push_back(Press(TrueShape(), 0.05 * static_cast<double>(seed), 0.001, seed));
    fits.push_back(FitIndentation(tests.back()));
    ASSERT_TRUE(fits.back().converged) << fits.back().message;
    EXPECT_LT(fits.back().relative_rms, 0.01);
  }
  const IndentationShape shared = FitSharedShape(tests, fits);
  // A specimen that was not among them, from its contact and stiffness alone.
  const IndentationTest other = Press(TrueShape(), 0.3, 0.0, 9);
  const IndentationFit fit = FitWithShape(other, shared);
  ASSERT_TRUE(fit.converged);
  EXPECT_LT(fit.relative_rms, 0.01);
  EXPECT_LT(fit.relative_rms_hold, 0.01);
  EXPECT_NEAR(fit.contact_mm.value, 0.5, 0.3);
  double relaxed = 0.0;
  for (int k = 0; k < 3; ++k) relaxed += shared.relaxation.share[k];
  EXPECT_NEAR(relaxed, 0.6, 0.08);
  // Neo-Hookean tissue does not stiffen so.
  IndentationShape soft = shared;
  soft.law = HyperelasticLaw::kNeoHookean;
  soft.parameters = {1.0};
  EXPECT_GT(FitWithShape(other, soft).relative_rms, 0.03);
}

TEST(Indentation, ASavedShapeIsReadAgain) {
  const nlohmann::json saved = ShapeJson(TrueShape());
  EXPECT_EQ(ShapeJson(ShapeFromJson(saved, "fit.json")), saved);
  nlohmann::json wrong = saved;
  wrong["law"] = "ogden";
  EXPECT_ANY_THROW(ShapeFromJson(wrong, "fit.json"));
  wrong = saved;
  wrong.erase("relaxation");
  EXPECT_ANY_THROW(ShapeFromJson(wrong, "fit.json"));
}

TEST(Indentation, WithoutAHoldHasNoAnswer) {
  IndentationTest test = Press(TrueShape(), 0.1, 0.0, 1);
  test.time_s.resize(56);
  test.depth_mm.resize(56);
  test.force_n.resize(56);
  const IndentationFit fit = FitIndentation(test);
  EXPECT_FALSE(fit.converged);
  EXPECT_THAT(fit.message, testing::HasSubstr("10 of each"));
}

}  // namespace
}  // namespace acus::fitting
