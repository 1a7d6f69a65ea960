#include "acus/physics/forces/models/measured_model.h"

#include <cmath>
#include <gmock/gmock.h>
#include <limits>
#include <nlohmann/json.hpp>

#include "acus/base/core/error.h"
#include "acus/base/core/random.h"
#include "acus/physics/forces/models/force_model.h"
#include "acus/physics/forces/models/measured_forces.h"
#include "references/closed_loop.h"
#include "unit/physics/forces/layered_body.h"

namespace acus::forces {
namespace {

using testing::HasSubstr;

/// 0.3 N + 0.016 N/mm in, 0.2 N + 0.01 N/mm out; half relaxes with 0.8 s, a fifth with 12 s.
MechanicalModel TestLaw() {
  MechanicalModel law;
  law.in = {{0.0, 60.0}, {0.3, 0.3 + 0.016 * 60.0}};
  law.out = {{0.0, 60.0}, {0.2, 0.2 + 0.010 * 60.0}};
  law.surface_mm = 0.0;
  law.buildup_in_mm = 0.9;
  law.buildup_out_mm = 1.2;
  law.relaxing_share = {0.5, 0.2};
  law.relaxation_s = {0.8, 12.0};
  law.punctures = {{.contact_mm = 25.0,
                    .puncture_mm = 4.0,
                    .a1_n_per_mm = 0.05,
                    .a2_n_per_mm2 = 0.02,
                    .recovery_mm = 0.4,
                    .step_n = 0.1}};
  return law;
}

/// A needle along z; the skin is at z = 0.
struct DrivenMeasured {
  MeasuredModel model{SimpleTable(), Trocar(), TestLaw(), 1.27};
  MeasuredState state{};
  double time_s = 0.0;
  double z_mm = -1.0;
  NeedleForce last{};
  int punctures = 0;

  const NeedleForce& StepTo(double new_z_mm, double dt_s = 0.001) {
    z_mm = new_z_mm;
    time_s += dt_s;
    const volume::Label label = volume::LabelOf(z_mm >= 0.0 ? "liver" : "outside");
    last = model.Step(state, {time_s, {0.0, 0.0, z_mm}, Eigen::Vector3d::UnitZ(), label, true});
    punctures += last.event == NeedleEvent::kPuncture ? 1 : 0;
    return last;
  }
  const NeedleForce& MoveTo(double end_mm, double speed_mm_per_s = 5.0) {
    const double begin_mm = z_mm;
    const int steps = static_cast<int>(std::abs(end_mm - begin_mm) / speed_mm_per_s * 1e3) + 1;
    for (int i = 1; i <= steps; ++i) StepTo(begin_mm + (end_mm - begin_mm) * i / steps);
    return last;
  }
};

TEST(MeasuredModel, IsTheFittedLawByDepthSinceTheSkin) {
  DrivenMeasured needle;
  MechanicalState alone;
  const MechanicalModel law = TestLaw();
  alone.Advance(law, 0.0, 0.0);
  needle.MoveTo(-0.0025);
  double largest_n = 0.0;
  const auto compare = [&](double to_mm) {
    needle.StepTo(to_mm);
    const ContactStrain strain = alone.Advance(law, needle.time_s, needle.state.depth_mm);
    const double law_n = alone.ForceN(law, strain, needle.state.depth_mm);
    largest_n = std::max(largest_n, std::abs(needle.last.AxialN() - law_n));
  };
  for (int i = 1; i <= 8000; ++i) compare(0.005 * i);         // In to 40 mm,
  for (int i = 0; i < 20000; ++i) compare(40.0);              // hold for 20 s,
  for (int i = 1; i <= 7800; ++i) compare(40.0 - 0.005 * i);  // out.
  EXPECT_LT(largest_n, 1e-3);
  EXPECT_EQ(needle.punctures, 1);
}

TEST(MeasuredModel, RelaxesInAHoldAndIsDrawnBackWithItsOwnFriction) {
  DrivenMeasured needle;
  const double in_n = needle.MoveTo(40.0).AxialN();
  EXPECT_NEAR(in_n, 0.3 + 0.016 * 40.0 + 0.1, 0.02);
  for (int i = 0; i < 60000; ++i) needle.StepTo(40.0);
  // Shares 0.5 and 0.2 of S relax: about 0.3 is left, and steady sliding is normalised to 1.
  EXPECT_NEAR(needle.last.AxialN() / in_n, 0.3 / TestLaw().SteadyStrain(true), 0.01);
  needle.MoveTo(30.0);
  EXPECT_NEAR(needle.last.AxialN(), -(0.2 + 0.010 * 30.0), 0.02);
  needle.MoveTo(-1.0);
  EXPECT_EQ(needle.last.AxialN(), 0.0);
  EXPECT_FALSE(needle.state.in_body);
}

TEST(MeasuredModel, ANewPathIsUncutAndOldDepthIsNot) {
  DrivenMeasured needle;
  needle.MoveTo(35.0);
  needle.MoveTo(26.0);
  needle.MoveTo(35.0);
  EXPECT_EQ(needle.punctures, 1);  // The membrane is cut.
  needle.MoveTo(-1.0);
  needle.MoveTo(35.0);
  EXPECT_EQ(needle.punctures, 2);
}

TEST(MeasuredModel, BadSamplesAreTreatedAsByTheLayeredModel) {
  DrivenMeasured needle;
  needle.MoveTo(20.0);
  const double before_n = needle.last.AxialN();
  NeedleInput lost{needle.time_s + 0.001, {0, 0, 20}, Eigen::Vector3d::UnitZ(), 1, false};
  EXPECT_EQ(needle.model.Step(needle.state, lost).AxialN(), before_n);
  lost.time_s += 10.0;
  EXPECT_EQ(needle.model.Step(needle.state, lost).AxialN(), 0.0);
  NeedleInput bad = lost;
  bad.valid = true;
  bad.time_s += 0.001;
  bad.tip_in_ct_mm.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(needle.model.Step(needle.state, bad).AxialN(), 0.0);
  EXPECT_EQ(needle.state.num_rejected, 1);
  needle.time_s = bad.time_s;
  EXPECT_TRUE(std::isfinite(needle.StepTo(20.5).AxialN()));
}

TEST(MeasuredModel, AMillionRandomStepsStayFiniteAndBounded) {
  DrivenMeasured needle;
  RandomStream random(4, "wild");
  const double bound_n = needle.model.table().settings.largest_force_n;
  for (int i = 0; i < 1'000'000; ++i) {
    NeedleInput input;
    input.time_s = 1e-3 * i * random.Uniform(0.9, 1.1);
    input.tip_in_ct_mm = {random.Normal(), random.Normal(), random.Uniform(-50.0, 150.0)};
    input.axis_in_ct = {0.1 * random.Normal(), 0.0, 1.0};
    input.tissue_at_tip = static_cast<volume::Label>(random.Uniform(0.0, 20.0));
    input.valid = random.Uniform() > 0.05;
    if (random.Uniform() < 0.01) input.tip_in_ct_mm.z() = 1e300;
    const NeedleForce force = needle.model.Step(needle.state, input);
    ASSERT_TRUE(force.force_in_ct_n.allFinite()) << i;
    ASSERT_LE(force.force_in_ct_n.norm(), bound_n * (1.0 + 1e-12)) << i;
  }
}

TEST(MeasuredModel, TheSameSamplesGiveTheSameBits) {
  DrivenMeasured a;
  a.MoveTo(18.0);
  DrivenMeasured b = a;
  for (int i = 0; i < 3000; ++i) {
    const double z = 18.0 + 5.0 * std::sin(0.01 * i);
    EXPECT_EQ(a.StepTo(z).AxialN(), b.StepTo(z).AxialN());
  }
}

// In a place of constant resistance each branch of the contact is a spring that slips and creeps:
// it never gives back more than it took, wherever it turns round.
TEST(MeasuredModel, NoLoopInUniformTissueGivesWork) {
  for (const double amplitude_mm : {0.02, 0.1, 0.5, 2.0, 8.0}) {
    for (const double buildup_out_mm : {0.3, 0.9, 3.0}) {
      MechanicalModel law = TestLaw();
      law.punctures.clear();
      law.in.force_n = {1.0, 1.0};
      law.out.force_n = {0.4, 0.4};
      law.buildup_out_mm = buildup_out_mm;
      MechanicalState contact;
      RandomStream random(7, "loops");
      double work_n_mm = 0.0;
      double taken_n_mm = 0.0;
      double least_n_mm = 0.0;
      double depth_mm = 30.0;
      contact.Advance(law, 0.0, depth_mm);
      double force_n = 0.0;
      double time_s = 0.0;
      for (int loop = 0; loop < 400; ++loop) {
        const double to_mm = 30.0 + amplitude_mm * random.Uniform(-1.0, 1.0);
        for (int i = 1; i <= 200; ++i) {
          const double before_mm = contact.depth_mm;
          depth_mm += (to_mm - depth_mm) / (201 - i);
          time_s += 0.002;
          const ContactStrain strain = contact.Advance(law, time_s, depth_mm);
          const double now_n = contact.ForceN(law, strain, contact.depth_mm);
          const double step = 0.5 * (force_n + now_n) * (contact.depth_mm - before_mm);
          work_n_mm += step;
          taken_n_mm = std::max(taken_n_mm, work_n_mm);
          least_n_mm = std::min(least_n_mm, work_n_mm);
          force_n = now_n;
        }
      }
      EXPECT_GE(least_n_mm, -1e-6) << amplitude_mm << " " << buildup_out_mm;
      EXPECT_GT(work_n_mm, 0.0) << amplitude_mm;
    }
  }
}

TEST(MeasuredForces, AreReadAndWrittenTheSame) {
  const nlohmann::json law = LawJson(TestLaw());
  const nlohmann::json document = {
      {"format", "acus-measured-force/1"},
      {"needle_diameter_mm", 1.0},
      {"mean", law},
      {"recordings", {{{"name", "a"}, {"law", law}}, {{"name", "b"}, {"law", law}}}}};
  const MeasuredForces forces = MeasuredForcesFromJson(document, "f.json");
  EXPECT_EQ(LawJson(forces.Law("b")), law);
  EXPECT_EQ(LawJson(forces.Drawn(0)), law);
  // Recordings that do not differ have nothing to vary.
  EXPECT_NEAR(forces.Drawn(9).in.ForceN(30.0), forces.mean.in.ForceN(30.0), 1e-12);
  try {
    forces.Law("c");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("no recording is named 'c'; there are: mean, a, b"));
  }
  nlohmann::json bad = document;
  bad["mean"]["in"]["depth_mm"] = {5.0, 5.0};
  EXPECT_THROW(MeasuredForcesFromJson(bad, "f.json"), InputError);
  bad = document;
  bad["mean"]["relaxing_share"] = {0.8, 0.7};
  EXPECT_THROW(MeasuredForcesFromJson(bad, "f.json"), InputError);
}

TEST(MeasuredForces, DrawsHaveTheSpreadOfTheRecordings) {
  MeasuredForces forces;
  forces.mean = TestLaw();
  const std::vector<double> levels = {-0.2, -0.1, 0.0, 0.05, 0.25};
  for (const double level : levels) {
    MechanicalModel law = TestLaw();
    for (double& force : law.in.force_n) force += level;
    forces.recordings.push_back({"r", law});
  }
  double sum = 0.0;
  double squares = 0.0;
  const int draws = 2000;
  for (int seed = 1; seed <= draws; ++seed) {
    const double drawn =
        forces.Drawn(static_cast<std::uint64_t>(seed)).in.ForceN(30.0) - TestLaw().in.ForceN(30.0);
    sum += drawn;
    squares += drawn * drawn;
  }
  // Their own standard deviation is 0.170 N.
  EXPECT_NEAR(sum / draws, 0.0, 0.015);
  EXPECT_NEAR(std::sqrt(squares / draws), 0.170, 0.01);
  EXPECT_EQ(LawJson(forces.Drawn(3)), LawJson(forces.Drawn(3)));
}

TEST(ForceModel, HoldsAMeasuredModelToo) {
  const ForceModel model(MeasuredModel(SimpleTable(), Trocar(), TestLaw(), 1.27));
  ForceState state = model.NewState();
  model.Step(state, {0.0, {0, 0, -1}, Eigen::Vector3d::UnitZ(), 0, true});
  const volume::Label liver = volume::LabelOf("liver");
  model.Step(state, {0.1, {0, 0, 0}, Eigen::Vector3d::UnitZ(), liver, true});
  const NeedleForce force =
      model.Step(state, {2.1, {0, 0, 10}, Eigen::Vector3d::UnitZ(), liver, true});
  EXPECT_NEAR(force.AxialN(), 0.3 + 0.16, 0.03);
  EXPECT_TRUE(TrackOf(state).in_body);
}

}  // namespace
}  // namespace acus::forces
