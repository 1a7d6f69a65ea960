#include "acus/patient/fitting/fit_models.h"

#include <algorithm>
#include <cmath>
#include <gmock/gmock.h>
#include <map>
#include <nlohmann/json.hpp>

#include "acus/base/core/error.h"
#include "unit/patient/fitting/synthetic_recording.h"

namespace acus::fitting {
namespace {

using testing::HasSubstr;

MechanicalModel WithPuncture(const DriveMotion& drive) {
  MechanicalModel truth = PlainTruth(drive);
  truth.punctures = {{.contact_mm = 18.0,
                      .puncture_mm = 4.0,
                      .a1_n_per_mm = 0.1,
                      .a2_n_per_mm2 = 0.03,
                      .recovery_mm = 0.4,
                      .step_n = 0.0}};
  return truth;
}

TEST(FitModels, NamesAreChecked) {
  EXPECT_TRUE(FitModels::FromNames({"all"}).lugre);
  EXPECT_FALSE(FitModels::FromNames({"none"}).gaussians);
  const FitModels two = FitModels::FromNames({"gaussians", "hu-table"});
  EXPECT_TRUE(two.gaussians && two.hu_table && !two.mechanical && !two.lugre);
  try {
    FitModels::FromNames({"gausians"});
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("no model is named 'gausians'; allowed: gaussians"));
  }
}

TEST(FitModels, AkaikeChoosesTheModelThatMadeTheRecording) {
  const DriveMotion drive{.rate_hz = 200.0, .hold_s = 10.0};
  const FittedCurve fitted =
      FitModelsTo(Recording(WithPuncture(drive), drive, 0.01, 1), FitModels{});
  const std::vector<ModelScore> scores = ScoreInsertion(fitted);
  ASSERT_EQ(scores.size(), 4u);
  const auto best = std::ranges::min_element(scores, {}, &ModelScore::aic);
  EXPECT_EQ(best->name, "mechanical with punctures");
  for (const ModelScore& s : scores) EXPECT_GE(s.rms_n, 0.009) << s.name;
}

TEST(FitModels, FortmeierParametersFollowFromInsertionAndWithdrawal) {
  const DriveMotion drive{.rate_hz = 200.0, .hold_s = 20.0};
  const FittedCurve fitted =
      FitModelsTo(Recording(WithPuncture(drive), drive, 0.01, 2), FitModels{});
  const auto fit = Fortmeier(fitted, 2.0);
  ASSERT_TRUE(fit.has_value());
  // The puncture is inside: nothing is said of the capsule.
  ASSERT_TRUE(fitted.puncture.converged && fitted.puncture.starts_in_tissue);
  EXPECT_NEAR(fitted.puncture.puncture_n->value, 0.1 * 4.0 + 0.03 * 16.0, 0.1);
  EXPECT_FALSE(fit->capsule_cut_n || fit->a1_n_per_mm || fit->a2_n_per_mm2);
  // 0.3 N in, 0.2 N out at the start; the puncture leans on the line of the way in.
  EXPECT_TRUE(fit->cut_n.Contains(0.1));
  EXPECT_NEAR(fit->cut_n.value, 0.1, 0.1);
  EXPECT_NEAR(fit->friction_n.value, 2.0 * 0.010, 0.002);  // R of a node for 2 mm of shaft.
  EXPECT_NEAR(fit->stiffness_n_per_mm.value, 2.0 * 0.010 / 1.2, 0.005);
  EXPECT_FALSE(Fortmeier(FitModelsTo(fitted.curve, FitModels::FromNames({"none"}))).has_value());
}

/// A needle from outside through a capsule (0.46 N), then through a stronger vessel inside.
forces::ForceCurve CapsuleThenVessel() {
  const DriveMotion drive{.rate_hz = 200.0, .hold_s = 5.0};
  MechanicalModel truth = PlainTruth(drive);
  truth.in = {{10.0, drive.end_mm}, {0.15, 0.15 + 0.012 * 50.0}};
  truth.out = truth.in;
  truth.surface_mm = 10.0;
  truth.punctures = {{.contact_mm = 10.0,
                      .puncture_mm = 4.0,
                      .a1_n_per_mm = 0.06,
                      .a2_n_per_mm2 = 0.014,
                      .recovery_mm = 0.2},
                     {.contact_mm = 35.0,
                      .puncture_mm = 5.0,
                      .a1_n_per_mm = 0.1,
                      .a2_n_per_mm2 = 0.03,
                      .recovery_mm = 0.3}};
  return Recording(truth, drive, 0.01, 5);
}

TEST(FitModels, AVesselInsideDoesNotPassForTheCapsule) {
  const FittedCurve fitted = FitModelsTo(CapsuleThenVessel(), FitModels{});
  ASSERT_TRUE(fitted.puncture.converged) << fitted.puncture.message;
  EXPECT_TRUE(fitted.puncture.is_entry);
  // The larger fall is the vessel's, at 40 mm; the one that is fitted is the capsule's, at 14 mm.
  const auto& events = fitted.puncture.phases.punctures;
  const auto largest = std::ranges::max_element(events, {}, &PunctureEvent::drop_n);
  EXPECT_NEAR(fitted.curve.depth_mm[largest->peak], 40.0, 0.5);
  EXPECT_NEAR(fitted.curve.depth_mm[events[fitted.puncture.main].peak], 14.0, 0.5);
  const auto fortmeier = Fortmeier(fitted);
  ASSERT_TRUE(fortmeier && fortmeier->capsule_cut_n);
  EXPECT_LT(fortmeier->capsule_cut_n->value, 0.75);  // 0.46 N and what the tip resists.
}

TEST(FitModels, OneModelWithoutAnAnswerLeavesTheOthersTheirs) {
  const DriveMotion drive{.rate_hz = 100.0, .hold_s = 10.0};
  const FittedCurve fitted = FitModelsTo(Recording(PlainTruth(drive), drive, 0.01, 3), FitModels{});
  std::map<std::string, bool> answered;
  for (const ModelAnswer& answer : AnswersOf(fitted)) {
    answered[answer.model] = answer.has_answer;
    EXPECT_EQ(answer.why_not.empty(), answer.has_answer) << answer.model;
  }
  EXPECT_FALSE(answered.at("puncture"));  // There is none.
  for (const char* model : {"retraction", "hold", "gaussians", "mechanical"}) {
    EXPECT_TRUE(answered.at(model)) << model;
  }
  const nlohmann::json json = CurveJson(fitted);
  EXPECT_FALSE(json["answers"]["puncture"]["answered"].get<bool>());
  EXPECT_THAT(json["answers"]["puncture"]["why_not"].get<std::string>(), HasSubstr("no puncture"));
  EXPECT_THAT(MissingAnswers("x.csv", fitted), HasSubstr("\n  x.csv: puncture: no puncture"));
}

TEST(FitModels, AReversedSignIsDeclinedModelByModel) {
  const DriveMotion drive{.rate_hz = 100.0, .hold_s = 5.0};
  forces::ForceCurve curve = Recording(WithPuncture(drive), drive, 0.01, 3);
  for (double& force : curve.force_n) force = -force;
  const FittedCurve fitted = FitModelsTo(curve, FitModels{});
  EXPECT_THAT(fitted.puncture.message, HasSubstr("is its sign reversed?"));
  EXPECT_THAT(fitted.mechanical->message, HasSubstr("is its sign reversed?"));
  EXPECT_TRUE(fitted.gaussians->converged);  // A description, whatever the sign.
}

TEST(FitModels, DocumentsHaveABlockForEachModel) {
  const DriveMotion drive{.rate_hz = 100.0, .end_mm = 30.0, .hold_s = 5.0};
  std::vector<FittedCurve> fitted;
  for (std::uint64_t k = 0; k < 3; ++k) {
    fitted.push_back(
        FitModelsTo(Recording(WithPuncture(drive), drive, 0.01, k, "r" + std::to_string(k)),
                    FitModels::FromNames({"all"})));
  }
  const nlohmann::json one = CurveJson(fitted[0]);
  for (const char* key : {"gaussians", "mechanical", "lugre", "fortmeier", "insertion_models"}) {
    EXPECT_TRUE(one.contains(key)) << key;
  }
  EXPECT_EQ(one["gaussians"]["terms"].size(), 8u);
  EXPECT_GE(one["mechanical"]["events"]["punctures"].size(), 1u);
  const nlohmann::json together = TogetherJson(fitted, FitModels::FromNames({"all"}));
  EXPECT_EQ(together["leave_one_out_predictions"].size(), 3u);
  EXPECT_EQ(together["joint"]["recordings"], 3);
  EXPECT_FALSE(together["hu_table"]["converged"].get<bool>());
  EXPECT_THAT(ModelTable(fitted), HasSubstr("r2"));
  EXPECT_EQ(DepthPlots(fitted[0]).size(), 2u);
  EXPECT_GE(DepthPlots(fitted[0])[0].series.size(), 5u);
  EXPECT_EQ(TimePlots(fitted[0])[0].series.size(), 3u);
}

/// Friction that grows with depth, and a sensor's offset: what is exported repeats the fit.
TEST(FitModels, TheExportedFrictionIsTheWholeLaw) {
  const LuGreParameters truth{.sigma0_n_per_mm = 2.5,
                              .coulomb_n = 0.8,
                              .static_n = 0.8,
                              .stribeck_mm_per_s = 1.0,
                              .growth_per_mm = 0.02,
                              .middle_mm = 20.0,
                              .offset_n = 0.3};
  forces::ForceCurve curve;
  RandomStream noise(1, "law");
  for (int i = 0; i < 1000; ++i) {
    curve.time_s.push_back(0.01 * i);
    curve.depth_mm.push_back(20.0 + 10.0 * std::sin(6.0 * curve.time_s.back()));
  }
  curve.force_n = ReplayLuGre(truth, curve.time_s, curve.depth_mm);
  for (double& force : curve.force_n) force += 0.01 * noise.Normal();
  const FittedCurve fitted = FitModelsTo(curve, FitModels::FromNames({"lugre"}));
  ASSERT_TRUE(fitted.lugre->converged);
  const nlohmann::json law = CurveJson(fitted)["lugre"]["law"];
  LuGreParameters p;
  p.sigma0_n_per_mm = law["sigma0_n_per_mm"];
  p.sigma1_n_s_per_mm = law["sigma1_n_s_per_mm"];
  p.sigma2_n_s_per_mm = law["sigma2_n_s_per_mm"];
  p.coulomb_n = law["coulomb_n"];
  p.static_n = law["static_n"];
  p.stribeck_mm_per_s = law["stribeck_mm_per_s"];
  p.growth_per_mm = law["growth_per_mm"];
  p.middle_mm = law["middle_mm"];
  p.offset_n = law["offset_n"];
  const std::vector<double> again = ReplayLuGre(p, curve.time_s, curve.depth_mm);
  double squares = 0.0;
  for (std::size_t i = 0; i < again.size(); ++i)
    squares += std::pow(again[i] - curve.force_n[i], 2);
  EXPECT_LT(std::sqrt(squares / static_cast<double>(again.size())), 0.015);
  EXPECT_NEAR(p.growth_per_mm, truth.growth_per_mm, 0.002);
  EXPECT_NEAR(p.offset_n, truth.offset_n, 0.02);
}

/// Whatever a reader lets through must be fitted or declined: no crash, no endless loop, finite
/// JSON.
TEST(FitModels, OddRecordingsAreFittedOrDeclined) {
  const DriveMotion drive{.rate_hz = 50.0, .rest_s = 0.5, .end_mm = 30.0, .hold_s = 3.0};
  const forces::ForceCurve sound = Recording(WithPuncture(drive), drive, 0.01, 1);
  for (int kind = 0; kind < 20; ++kind) {
    RandomStream random(static_cast<std::uint64_t>(kind), "odd");
    forces::ForceCurve odd = sound;
    const auto some = [&] {
      return static_cast<std::size_t>(random.Uniform() * 0.999 * static_cast<double>(odd.size()));
    };
    switch (kind % 10) {
      case 0:
        for (double& f : odd.force_n) f = 0.0;
        break;
      case 1:
        for (double& f : odd.force_n) f = 1000.0 * random.Normal() / 5.0;
        break;
      case 2:
        for (double& d : odd.depth_mm) d = random.Uniform(-2000.0, 2000.0);
        break;
      case 3:
        for (double& d : odd.depth_mm) d = -d;
        break;
      case 4:
        for (int n = 0; n < 8; ++n) odd.force_n[some()] = random.Uniform(-1000.0, 1000.0);
        break;
      case 5:
        for (int n = 0; n < 8; ++n) odd.depth_mm[some()] = random.Uniform(-2000.0, 2000.0);
        break;
      case 6:
        for (double& f : odd.force_n) f = -f;
        break;
      case 7:
        for (double& t : odd.time_s) t *= 1e6;
        break;
      case 8:
        for (double& t : odd.time_s) t *= 1e-6;
        break;
      default: {
        const std::size_t size = 20 + some() / 4;
        for (auto* column : {&odd.time_s, &odd.depth_mm, &odd.force_n}) column->resize(size);
      }
    }
    const FittedCurve fitted = FitModelsTo(std::move(odd), FitModels::FromNames({"all"}));
    // A number that is not finite is written as null.
    EXPECT_EQ(CurveJson(fitted).dump().find("null,\"high_95"), std::string::npos) << kind;
    TogetherJson({&fitted, 1}, FitModels::FromNames({"all"}));
    DepthPlots(fitted);
    TimePlots(fitted);
  }
}

}  // namespace
}  // namespace acus::fitting
