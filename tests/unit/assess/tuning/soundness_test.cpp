#include "acus/assess/tuning/soundness.h"

#include <gmock/gmock.h>
#include <limits>

#include "support/layered_scene.h"

namespace acus::tuning {
namespace {

using Eigen::Vector3d;
using ::testing::AllOf;
using ::testing::HasSubstr;

/// Steps of a millisecond at which the needle is held with a force.
class SoundnessTest : public ::testing::Test {
 protected:
  void Step(const Vector3d& tip_mm, const Vector3d& needle_n, const Vector3d& probe_n = {0, 0, 0}) {
    simulation::StepOutput step;
    step.time_ns = 1'000'000LL * static_cast<long long>(log_.steps.size());
    step.ct_from_needle.translation() = tip_mm;
    step.force.force_in_ct_n = needle_n;
    step.probe.force_in_ct_n = probe_n;
    log_.steps.push_back(step);
  }
  std::string Why() const { return WhyUnusable({}, scene_, log_); }

  const simulation::Scene scene_ =
      testing_support::LayeredScene(testing_support::PlanOf(true, false, false, true), true);
  const double most_n_ = scene_.forces->table().settings.largest_force_n;
  replay::StepLog log_;
};

TEST_F(SoundnessTest, ForcesUpToTheLimitAreUsable) {
  Step({0, 0, 0}, {0, 0, -most_n_});
  Step({0, 0, 1}, {0, 0, -most_n_});
  EXPECT_EQ(Why(), "");
}

TEST_F(SoundnessTest, AForceAboveTheLimitIsNamedWithItsTime) {
  Step({0, 0, 0}, {0, 0, -1});
  Step({0, 0, 0}, {0, 0, -1.01 * most_n_});
  EXPECT_THAT(Why(),
              AllOf(HasSubstr("needle's force"), HasSubstr("is above"), HasSubstr("0.001 s")));
}

TEST_F(SoundnessTest, AForceThatIsNotFiniteIsNamed) {
  Step({0, 0, 0}, {0, 0, 0}, {std::numeric_limits<double>::quiet_NaN(), 0, 0});
  EXPECT_THAT(Why(), HasSubstr("the probe's force is not finite"));
  log_.steps.clear();
  Step({0, 0, 0}, {0, std::numeric_limits<double>::infinity(), 0});
  EXPECT_THAT(Why(), HasSubstr("the needle's force is not finite"));
}

// Held over a step: what the hand gives is the force against its way.
TEST_F(SoundnessTest, WorkGivenToTheHandIsWeighedAgainstWhatItSpent) {
  Step({0, 0, 0}, {0, 0, -2});
  for (int mm = 1; mm <= 20; ++mm) Step({0, 0, 1.0 * mm}, {0, 0, -2});   // It gives 40 mJ,
  for (int mm = 19; mm >= -1; --mm) Step({0, 0, 1.0 * mm}, {0, 0, -2});  // and gets 42 back.
  EXPECT_EQ(Why(), "") << "2 mJ are less than a tenth";
  for (int mm = -2; mm >= -4; --mm) Step({0, 0, 1.0 * mm}, {0, 0, -2});
  EXPECT_THAT(Why(), HasSubstr("it gave the hand 8 mJ more than it took"));
}

}  // namespace
}  // namespace acus::tuning
