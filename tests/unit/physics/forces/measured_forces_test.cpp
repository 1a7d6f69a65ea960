#include "acus/physics/forces/models/measured_forces.h"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>

#include "acus/base/core/random.h"
#include "acus/base/math/statistics.h"

namespace acus::forces {
namespace {

/// Recordings of needles that all meet the same in the end: where a membrane leaves more behind,
/// the profile beside it is lower; a stiff tissue is stiff in and out.
MeasuredForces Recordings() {
  MeasuredForces forces;
  RandomStream random(1, "recordings");
  for (int k = 0; k < 12; ++k) {
    MechanicalModel law;
    const double step_n = 0.5 + 0.2 * random.Normal();
    const double level_n = 1.5 + 0.15 * random.Normal();
    law.in = {{0.0, 10.0, 11.0, 40.0}, {level_n, level_n, level_n - step_n, level_n - step_n}};
    law.out = {{0.0, 40.0}, {0.5 * level_n, 0.5 * level_n}};
    law.punctures.push_back({.contact_mm = 8.0,
                             .puncture_mm = 2.0,
                             .a1_n_per_mm = 0.5 * step_n,
                             .a2_n_per_mm2 = 0.0,
                             .recovery_mm = 0.2,
                             .step_n = step_n});
    law.buildup_in_mm = std::exp(0.2 * random.Normal());
    law.relaxing_share = {0.3 + 0.1 * (level_n - 1.5), 0.0, 0.0};
    forces.recordings.push_back({"r" + std::to_string(k), law});
  }
  forces.mean = forces.recordings.front().law;
  return forces;
}

double InN(const MechanicalModel& law, double depth_mm) {
  return law.ResistanceInN(depth_mm, -std::numeric_limits<double>::infinity());
}

/// What is measured of a law, over the recordings and over seeds.
template <typename Measure>
void ExpectTheSameScatter(const MeasuredForces& forces, const char* what, const Measure& measure) {
  std::vector<double> recorded, drawn;
  for (const RecordedLaw& r : forces.recordings) recorded.push_back(measure(r.law));
  for (std::uint64_t seed = 1; seed <= 1000; ++seed) drawn.push_back(measure(forces.Drawn(seed)));
  const double sd = math::StandardDeviation(recorded);
  // 1000 draws give the mean to 3 % of the SD, and the SD to 2 %.
  EXPECT_NEAR(math::Mean(drawn), math::Mean(recorded), 0.12 * sd) << what;
  EXPECT_NEAR(math::StandardDeviation(drawn), sd, 0.15 * sd) << what;
}

TEST(MeasuredForces, SeedsScatterAsTheRecordingsDo) {
  const MeasuredForces forces = Recordings();
  ExpectTheSameScatter(forces, "before the membrane",
                       [](const MechanicalModel& law) { return InN(law, 5.0); });
  ExpectTheSameScatter(forces, "behind the membrane",
                       [](const MechanicalModel& law) { return InN(law, 30.0); });
  ExpectTheSameScatter(forces, "on the way out",
                       [](const MechanicalModel& law) { return law.ResistanceOutN(20.0); });
  ExpectTheSameScatter(forces, "build-up",
                       [](const MechanicalModel& law) { return std::log(law.buildup_in_mm); });
  ExpectTheSameScatter(forces, "left after a hold", [](const MechanicalModel& law) {
    return InN(law, 30.0) * (1.0 - law.relaxing_share[0]);
  });
}

TEST(MeasuredForces, ASeedIsOneDrawAndTwoSeedsAreTwo) {
  const MeasuredForces forces = Recordings();
  EXPECT_EQ(forces.Drawn(7).in.force_n, forces.Drawn(7).in.force_n);
  EXPECT_NE(forces.Drawn(7).in.force_n, forces.Drawn(8).in.force_n);
  EXPECT_EQ(forces.Drawn(0).in.force_n, forces.mean.in.force_n);
}

}  // namespace
}  // namespace acus::forces
