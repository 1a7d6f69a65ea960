#include "acus/patient/fitting/joint_fit.h"

#include <cmath>
#include <gtest/gtest.h>

#include "unit/patient/fitting/synthetic_recording.h"

namespace acus::fitting {
namespace {

/// Several recordings of one tissue: each with its own level, the same profile.
class Recordings {
 public:
  Recordings(const MechanicalModel& truth, int count, double level_sd_n) {
    const DriveMotion drive{.rate_hz = 100.0, .hold_s = 10.0};
    for (int k = 0; k < count; ++k) {
      RandomStream random(static_cast<std::uint64_t>(k), "level");
      MechanicalModel own = truth;
      const double level = level_sd_n * random.Normal();
      for (double& force : own.in.force_n) force += level;
      curves_.push_back(
          Recording(own, drive, 0.02, static_cast<std::uint64_t>(k), "tissue" + std::to_string(k)));
    }
    for (const forces::ForceCurve& curve : curves_) punctures_.push_back(FitPunctureCurve(curve));
    for (std::size_t k = 0; k < curves_.size(); ++k) {
      fits_.push_back(FitMechanical(curves_[k], punctures_[k], {.find_events = false}));
    }
  }

  std::vector<JointRecording> All() const {
    std::vector<JointRecording> all;
    for (std::size_t k = 0; k < curves_.size(); ++k) {
      all.push_back({&curves_[k], &punctures_[k].phases, &fits_[k]});
    }
    return all;
  }

 private:
  std::vector<forces::ForceCurve> curves_;
  std::vector<PunctureCurveFit> punctures_;
  std::vector<MechanicalFit> fits_;
};

MechanicalModel JointFitTruth() {
  return PlainTruth({});
}

TEST(JointFit, TwoConstantsWhereTheTissueIsUniform) {
  const Recordings recordings(JointFitTruth(), 5, 0.0);
  const JointModel joint = FitJoint(recordings.All());
  EXPECT_LE(joint.knots_in, 4);
  EXPECT_NEAR(joint.model.in.ForceN(10.0), 0.3 + 0.16, 0.02);
  EXPECT_NEAR(joint.model.in.ForceN(50.0), 0.3 + 0.8, 0.02);
  EXPECT_NEAR(joint.model.out.ForceN(30.0), 0.2 + 0.3, 0.02);
  EXPECT_NEAR(joint.model.buildup_in_mm, 0.9, 0.2);
}

TEST(JointFit, LayersWhereItIsNot) {
  MechanicalModel truth = JointFitTruth();
  truth.in = {{0.0, 20.0, 30.0, 60.0}, {0.3, 0.5, 1.2, 1.4}};
  const Recordings recordings(truth, 5, 0.05);
  const JointModel joint = FitJoint(recordings.All());
  EXPECT_GE(joint.knots_in, 6);
  EXPECT_NEAR(joint.model.in.ForceN(10.0), 0.4, 0.08);
  EXPECT_NEAR(joint.model.in.ForceN(45.0), 1.3, 0.08);
  EXPECT_EQ(FitJoint(recordings.All(), 2).knots_in, 2);
}

TEST(JointFit, ForetellsAsWellAsTheMeanOfTheOthers) {
  const Recordings recordings(JointFitTruth(), 6, 0.1);
  const std::vector<Prediction> predictions = LeaveOneOut(recordings.All());
  ASSERT_EQ(predictions.size(), 6u);
  for (const Prediction& p : predictions) {
    EXPECT_GT(p.mean_curve.insertion_n, 0.015);  // At least the noise.
    EXPECT_LT(p.model.insertion_n, 1.1 * p.mean_curve.insertion_n) << p.name;
    EXPECT_LT(p.model.retraction_n, 1.1 * p.mean_curve.retraction_n) << p.name;
  }
}

TEST(JointFit, TwoRecordingsShareTwoKnotsAndForetellNothing) {
  const Recordings recordings(JointFitTruth(), 2, 0.05);
  EXPECT_EQ(FitJoint(recordings.All()).knots_in, 2);
  EXPECT_TRUE(LeaveOneOut(recordings.All()).empty());
}

TEST(JointFit, RecordingsWithoutAFitTakeNoPart) {
  const Recordings recordings(JointFitTruth(), 3, 0.05);
  std::vector<JointRecording> all = recordings.All();
  const MechanicalFit failed;
  all[1].fit = &failed;
  EXPECT_FALSE(all[1].IsUsable());
  EXPECT_TRUE(LeaveOneOut(all).empty());
  EXPECT_NEAR(FitJoint(all).model.in.ForceN(30.0), 0.78, 0.15);
}

}  // namespace
}  // namespace acus::fitting
