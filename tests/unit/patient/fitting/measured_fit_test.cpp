#include "acus/patient/fitting/measured_fit.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "acus/base/core/error.h"
#include "unit/patient/fitting/synthetic_recording.h"

namespace acus::fitting {
namespace {

using testing::HasSubstr;

/// A recording of one tissue: its own level in and out, the same law otherwise.
forces::ForceCurve OfTissue(std::uint64_t seed) {
  const DriveMotion drive{.rate_hz = 100.0, .end_mm = 40.0, .hold_s = 10.0};
  MechanicalModel truth = PlainTruth(drive);
  RandomStream random(seed, "level of tissue");
  const double factor = std::exp(0.2 * random.Normal());
  for (ResistanceProfile* profile : {&truth.in, &truth.out}) {
    for (double& force : profile->force_n) force *= factor;
  }
  return Recording(truth, drive, 0.01, seed, "t" + std::to_string(seed));
}

std::vector<FittedCurve> FittedTissue(std::uint64_t count) {
  std::vector<FittedCurve> fitted;
  for (std::uint64_t k = 0; k < count; ++k) {
    fitted.push_back(FitModelsTo(OfTissue(k), FitModels::FromNames({"mechanical"})));
  }
  return fitted;
}

/// Through the file, as the program does.
SavedFit Saved(const nlohmann::json& document) {
  const std::string path = testing::TempDir() + "measured_fit_test.json";
  std::ofstream(path) << document;
  return ReadSavedFit(path);
}

TEST(MeasuredFit, TheSpreadIsLinearBetweenItsPlaces) {
  const ResidualSpread spread{.x = {1.0, 2.0, 5.0}, .sd_n = {0.1, 0.3, 0.0}};
  EXPECT_DOUBLE_EQ(spread.At(-3.0), 0.1);
  EXPECT_DOUBLE_EQ(spread.At(1.0), 0.1);
  EXPECT_DOUBLE_EQ(spread.At(1.25), 0.15);
  EXPECT_DOUBLE_EQ(spread.At(2.0), 0.3);
  EXPECT_DOUBLE_EQ(spread.At(4.0), 0.1);
  EXPECT_DOUBLE_EQ(spread.At(9.0), 0.0);
}

TEST(MeasuredFit, BoundsCoverOtherRecordingsOfTheTissue) {
  const SavedFit fit = Saved(MeasuredJson(FittedTissue(8), 1.27));
  EXPECT_EQ(fit.band.recordings, 8);
  double covered = 0.0;
  const int others = 30;
  for (std::uint64_t seed = 100; seed < 100 + others; ++seed) {
    const PredictedCurve predicted = Predict(fit, OfTissue(seed));
    covered += predicted.all_coverage / others;
    for (std::size_t k = 0; k < predicted.mean_n.size(); ++k) {
      ASSERT_LE(predicted.low_n[k], predicted.high_n[k]);
    }
  }
  std::printf("  %.3f of the samples of %d other recordings\n", covered, others);
  EXPECT_GE(covered, 0.93);
}

TEST(MeasuredFit, TheMeanAndEachRecordingAreInTheFile) {
  const std::vector<FittedCurve> fitted = FittedTissue(4);
  const forces::MeasuredForces forces =
      forces::MeasuredForcesFromJson(MeasuredJson(fitted, 1.0), "file");
  ASSERT_EQ(forces.recordings.size(), 4u);
  EXPECT_EQ(forces.needle_diameter_mm, 1.0);
  double mean_n = 0.0;
  for (const FittedCurve& f : fitted) {
    const double own_n = f.mechanical->eventful.in.ForceN(20.0);
    EXPECT_NEAR(forces.Law(f.curve.name).in.ForceN(20.0), own_n, 1e-9);
    mean_n += own_n / 4.0;
  }
  EXPECT_NEAR(forces.mean.in.ForceN(20.0), mean_n, 0.03);
}

TEST(MeasuredFit, TooFewRecordingsGiveForcesButNoBounds) {
  const nlohmann::json document = MeasuredJson(FittedTissue(2), 1.27);
  EXPECT_THAT(document["prediction"]["why_not"].get<std::string>(), HasSubstr("there are 2"));
  EXPECT_THROW(Saved(document), InputError);
  FittedCurve none = FitModelsTo(OfTissue(1), FitModels::FromNames({"none"}));
  EXPECT_THROW(MeasuredJson({&none, 1}, 1.27), NoAnswerError);
}

TEST(MeasuredFit, ASlipInTheHoldIsFound) {
  const DriveMotion drive{.rate_hz = 100.0, .end_mm = 40.0, .hold_s = 30.0};
  MechanicalModel truth = PlainTruth(drive);
  truth.slips = {{.after_s = 12.0, .share = 0.4}};
  const FittedCurve fitted =
      FitModelsTo(Recording(truth, drive, 0.01, 2), FitModels::FromNames({"mechanical"}));
  ASSERT_FALSE(fitted.mechanical->eventful.slips.empty());
  EXPECT_NEAR(fitted.mechanical->eventful.slips[0].after_s, 12.0, 0.1);
  EXPECT_NEAR(fitted.mechanical->eventful.slips[0].share, 0.4, 0.05);
  EXPECT_LT(fitted.mechanical->eventful_rms.hold_n, 0.02);
  truth.slips.clear();
  const FittedCurve plain =
      FitModelsTo(Recording(truth, drive, 0.01, 2), FitModels::FromNames({"mechanical"}));
  EXPECT_TRUE(plain.mechanical->eventful.slips.empty());
}

}  // namespace
}  // namespace acus::fitting
