// Hard cases of the 2D model of 2010, each with its bound.
#include <Eigen/Cholesky>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <gtest/gtest.h>

#include "acus/base/core/random.h"
#include "acus/physics/tissue/plane_model_2010.h"
#include "support/bound.h"
#include "support/layered_tissue.h"
#include "support/stability_length.h"

namespace acus::tissue {
namespace {

using Eigen::Vector3d;
using testing_support::Above;
using testing_support::AtMost;
using testing_support::Below;
using testing_support::BoundPlot;
using testing_support::Exactly;
using testing_support::HardCase;
using testing_support::Largest;
using testing_support::Layers;
using testing_support::ModelInsertion;
using Insertion = ModelInsertion<PlaneModel2010>;

const Layers kBody{{{0, "skin"},
                    {2, "fat"},
                    {20, "liver"},
                    {45, "vessel"},
                    {47, "liver"},
                    {70, "bone"},
                    {80, "fat"}}};

PlaneModel2010 Body(const PlaneSettings& settings = {}) {
  return PlaneModel2010(settings, {}, testing_support::RoundForces(), testing_support::Trocar18(),
                        testing_support::RoundElasticity(), kBody.At());
}

/// Elastic energy in the tissue and forces per node: what a solver that diverges would blow up.
double EnergyNmm(const PlaneState& state) {
  double energy = 0.0;
  for (int i = 0; i < 2 * state.num_nodes; ++i) {
    energy += 0.5 * state.contact.ForceN(i) * state.contact.DisplacementMm(i);
  }
  return energy;
}

int NumSticking(const PlaneContact& contact) {
  int num = 0;
  for (int i = 0; i < contact.size(); ++i) num += contact.Status(i) == SlotStatus::kStick ? 1 : 0;
  return num;
}

/// Largest difference of a force to a new factorisation for the same set of sticking nodes.
double ErrorOfFreshSolveN(const PlaneContact& contact) {
  std::vector<int> stick;
  for (int i = 0; i < contact.size(); ++i) {
    if (contact.Status(i) == SlotStatus::kStick) stick.push_back(i);
  }
  const int m = static_cast<int>(stick.size());
  if (m == 0) return 0.0;
  Eigen::MatrixXd c(m, m);
  Eigen::VectorXd right(m);
  for (int i = 0; i < m; ++i) {
    right[i] = contact.TargetMm(stick[i]);
    for (int j = 0; j < m; ++j) c(i, j) = contact.Compliance(stick[i], stick[j]);
    for (int j = 0; j < contact.size(); ++j) {
      if (contact.Status(j) == SlotStatus::kStick) continue;
      right[i] -= contact.Compliance(stick[i], j) * contact.ForceN(j);
    }
  }
  const Eigen::VectorXd force = c.llt().solve(right);
  double worst = 0.0;
  for (int i = 0; i < m; ++i) {
    worst = std::max(worst, std::abs(force[i] - contact.ForceN(stick[i])));
  }
  return worst;
}

ToolSample Wild(RandomStream& random, double& time_s) {
  ToolSample sample;
  time_s += random.Uniform() < 0.01 ? -0.5 : random.Uniform(1e-4, 1e-2);
  sample.time_s = random.Uniform() < 0.01 ? std::nan("") : time_s;
  sample.needle_valid = random.Uniform() > 0.02;
  sample.tip_in_ct_mm =
      Vector3d(random.Uniform(-5, 5), random.Uniform(-5, 5), random.Uniform(-10, 80));
  if (random.Uniform() < 0.01) sample.tip_in_ct_mm.x() = std::nan("");
  if (random.Uniform() < 0.01) sample.tip_in_ct_mm *= 1e6;
  sample.axis_in_ct = Vector3d(random.Normal(), random.Normal(), 3.0);
  if (random.Uniform() < 0.01) sample.axis_in_ct.setZero();
  return sample;
}

TEST(TissueModelsPlane, RandomSamplesStayFiniteAndBounded) {
  const HardCase hard("Jumps, broken numbers, time that goes back, lost poses, at random.");
  Largest force_n;
  Largest energy_n_mm;
  Largest error_n;
  Largest moved_mm;
  const int num_steps = testing_support::StabilitySteps(50'000);
  PlaneSettings coarse;
  coarse.spacing_mm = 5.0;
  const PlaneModel2010 model = Body(coarse);
  PlaneState state = model.NewState();
  RandomStream random(1, "wild");
  TissueLoad load;
  PlaneField2010 field(model);
  double time_s = 0.0;
  for (int n = 0; n < num_steps; ++n) {
    const auto force = model.Step(state, Wild(random, time_s));
    force_n.Add(force.force_in_ct_n.norm());
    energy_n_mm.Add(std::abs(EnergyNmm(state)));
    if (n % 50 != 0) continue;
    error_n.Add(ErrorOfFreshSolveN(state.contact));
    model.LoadOf(state, load);
    field.Update(load);
    moved_mm.Add(field.DisplacementMm(Vector3d(1, 1, random.Uniform(-10, 80))).norm());
  }
  hard.Expect("largest force", force_n,
              AtMost(model.table().settings.largest_force_n * (1 + 1e-12)), "N");
  hard.Expect("elastic energy", energy_n_mm, Below(100.0), "mJ");
  hard.Expect("force against a new factorisation", error_n, Below(1e-9), "N");
  hard.Expect("largest displacement in the image", moved_mm, Below(20.0), "mm");
  hard.Note("wild steps", std::to_string(num_steps));
  EXPECT_GT(state.gate.num_rejected, 100);
  EXPECT_GT(state.gate.num_time_back, 100);
  EXPECT_EQ(state.contact.num_unresolved(), 0);
}

// One million swaps by a needle that goes to and fro: by so much that all nodes slip at once, and
// by so little that many stick.
TEST(TissueModelsPlane, AMillionSwapsKeepTheForcesOfAFreshSolve) {
  const HardCase hard("A million changes between stick and slip by a needle that goes to and fro.");
  const PlaneModel2010 model = Body();
  Insertion insertion{model};
  insertion.MoveToDepth(60.0);
  Largest worst_n;
  Largest largest_n;
  Largest largest_energy;
  BoundPlot plot{.title = "Elastic energy in the tissue during a million changes",
                 .x_label = "changes between stick and slip",
                 .y_label = "energy [mJ]",
                 .curves = {{}}};
  RandomStream random(7, "strokes");
  double z = 60.0;
  std::int64_t num_sticking = 0;
  for (int n = 0; insertion.state.contact.num_swaps() < 1'000'000; ++n) {
    ASSERT_LT(n, 400'000);
    const double stroke_mm = n % 2 == 0 ? random.Uniform(2.0, 8.0) : random.Uniform(0.01, 0.4);
    z += z > 52.0 ? -stroke_mm : stroke_mm;
    num_sticking += NumSticking(insertion.state.contact);
    insertion.StepTo(Vector3d(random.Uniform(-0.5, 0.5), 0, z));
    const double energy_n_mm = EnergyNmm(insertion.state);
    largest_n.Add(insertion.last.force_in_ct_n.norm());
    largest_energy.Add(std::abs(energy_n_mm));
    worst_n.Add(ErrorOfFreshSolveN(insertion.state.contact));
    insertion.log.clear();
    if (n % 50 != 0) continue;
    plot.curves[0].Add(static_cast<double>(insertion.state.contact.num_swaps()), energy_n_mm);
  }
  hard.Expect("force against a new factorisation", worst_n, AtMost(1e-9), "N");
  EXPECT_GT(num_sticking, 100'000);
  hard.Expect("steps without an answer",
              static_cast<double>(insertion.state.contact.num_unresolved()), Exactly(0));
  hard.Expect("largest force", largest_n, Below(20.0), "N");
  hard.Expect("elastic energy", largest_energy, Below(100.0), "mJ");
  hard.Note("new inverses", std::to_string(insertion.state.contact.num_rebuilds()));
  hard.Plot(plot);
}

TEST(TissueModelsPlane, ACopyContinuesWithTheSameBits) {
  const HardCase hard("A state that is saved in the middle of wild samples goes on as the other.");
  int num_differ = 0;
  for (const PlaneUpdate update : {PlaneUpdate::kRestricted, PlaneUpdate::kFull}) {
    PlaneSettings coarse;
    coarse.spacing_mm = 9.0;
    coarse.update = update;
    const PlaneModel2010 model = Body(coarse);
    PlaneState state = model.NewState();
    RandomStream random(2, "wild");
    double time_s = 0.0;
    for (int n = 0; n < 300; ++n) model.Step(state, Wild(random, time_s));
    PlaneState copy = state;
    for (int n = 0; n < 1000; ++n) {
      const ToolSample sample = Wild(random, time_s);
      const Vector3d a = model.Step(state, sample).force_in_ct_n;
      const Vector3d b = model.Step(copy, sample).force_in_ct_n;
      num_differ += std::memcmp(a.data(), b.data(), sizeof(double) * 3) == 0 ? 0 : 1;
    }
  }
  hard.Expect("forces that differ in a bit, of 2000", num_differ, Exactly(0));
}

TEST(TissueModelsPlane, TheForceDoesNotDependOnTheStep) {
  const HardCase hard("Steps of 0.1 to 10 ms, and 50 mm in one step.");
  const PlaneModel2010 model = Body();
  double force_n[4] = {};
  int i = 0;
  for (const double dt_s : {1e-4, 1e-3, 1e-2}) {
    Insertion insertion{model};
    insertion.MoveToDepth(62.0, 20.0, dt_s);
    force_n[i++] = insertion.last.AxialN();
  }
  Insertion jumps{model};
  for (const double z : {-1.0, 12.0, 62.0, 62.0}) jumps.StepTo(Vector3d(0, 0, z));
  force_n[3] = jumps.last.AxialN();
  Largest off_n;
  for (const double other_n : force_n) off_n.Add(std::abs(other_n - force_n[0]));
  hard.Expect("force against that at 0.1 ms", off_n, AtMost(0.03), "N");
  EXPECT_GT(force_n[0], 1.0);
}

TEST(TissueModelsPlane, StandingStillComesToRestAndKeepsItsBits) {
  const HardCase hard(
      "A needle that stands still, in tissue, in a vessel and on bone, feels no change.");
  Largest relaxed_n;
  Largest change_n;
  const PlaneModel2010 model = Body();
  for (const double depth_mm : {4.0, 33.3, 46.0, 71.0}) {
    Insertion insertion{model};
    insertion.MoveToDepth(depth_mm);
    const double moving_n = insertion.last.AxialN() - insertion.last.bone_n;
    for (int n = 0; n < 100; ++n) insertion.StepTo(insertion.tip_mm);
    const Vector3d force = insertion.last.force_in_ct_n;
    relaxed_n.Add(std::abs(insertion.last.AxialN() - insertion.last.bone_n - moving_n));
    for (int n = 0; n < 1000; ++n) {
      insertion.StepTo(insertion.tip_mm);
      change_n.Add((insertion.last.force_in_ct_n - force).norm());
    }
  }
  hard.Expect("change within 0.1 s after it stopped", relaxed_n, AtMost(0.05), "N");
  hard.Expect("change in a second after that", change_n, Below(1e-9), "N");
}

TEST(TissueModelsPlane, ALostNeedleKeepsItsForceAndLetsGoSlowly) {
  const PlaneModel2010 model = Body();
  Insertion insertion{model};
  insertion.MoveToDepth(33.0);
  const Vector3d before = insertion.last.force_in_ct_n;
  ToolSample lost;
  lost.needle_valid = false;
  lost.time_s = insertion.time_s + 0.001;
  EXPECT_EQ(model.Step(insertion.state, lost).force_in_ct_n, before);
  lost.time_s = insertion.time_s + 100.0;
  EXPECT_EQ(model.Step(insertion.state, lost).force_in_ct_n.norm(), 0.0);
  EXPECT_GT(insertion.StepTo(insertion.tip_mm, 101.0).force_in_ct_n.norm(), 0.1);
}

TEST(TissueModelsPlane, GoesInAndOutAndSidewaysAHundredTimes) {
  const HardCase hard("Torn sideways through tissue a hundred times: nothing may be left of it.");
  Largest drift_n;
  Largest lateral_n;
  PlaneSettings coarse;
  coarse.spacing_mm = 5.0;
  const PlaneModel2010 model = Body(coarse);
  Insertion insertion{model};
  double first_n = 0.0;
  insertion.tip_mm.z() = -1.5;
  for (int n = 0; n < 100; ++n) {
    insertion.MoveToDepth(40.0, 400.0);
    if (n == 0) first_n = insertion.last.AxialN();
    drift_n.Add(std::abs(insertion.last.AxialN() - first_n));
    insertion.MoveTo(Vector3d(15, 0, 40), 400.0);  // Torn through the tissue.
    lateral_n.Add(insertion.last.lateral_n);
    insertion.MoveTo(Vector3d(0, 0, 40), 400.0);
    insertion.MoveToDepth(-1.5, 400.0);
    EXPECT_EQ(insertion.state.num_nodes, 0) << n;
  }
  hard.Expect("force at 40 mm against the first time", drift_n, AtMost(1e-6), "N");
  hard.Expect("force sideways", lateral_n, AtMost(model.table().settings.lateral_limit_n + 1e-12),
              "N");
  hard.Expect("work of the hand", insertion.work_n_mm, Above(0.0), "mJ");
}

// 1000:1 between the layers, and islands that hang on nothing.
TEST(TissueModelsPlane, HighContrastAndIslandsAreNoTrouble) {
  const HardCase hard("Layers of 1 kPa and 1 MPa, and an island of tissue in the air.");
  const auto elasticity = mechanics::ElasticityTableFromJson(nlohmann::json::parse(R"({
    "format": "acus-elasticity/1", "tissues": [
      {"tissue": "fat", "source": "test", "youngs_modulus_kpa": 1},
      {"tissue": "liver", "source": "test", "youngs_modulus_kpa": 1000}]})"),
                                                             "contrast");
  const volume::Label fat = volume::LabelOf("fat");
  const volume::Label liver = volume::LabelOf("liver");
  const PlaneModel2010 model({}, {}, testing_support::RoundForces(), testing_support::Trocar18(),
                             elasticity, [=](const Vector3d& p) -> volume::Label {
                               if (p.z() < -4 && p.z() > -9 && std::abs(p.x()) < 4)
                                 return liver;  // An island in the air.
                               if (p.z() < 0) return 0;
                               return static_cast<int>(p.z() / 7) % 2 == 0 ? fat : liver;
                             });
  Insertion insertion{model};
  insertion.tip_mm.x() = 20.0;
  insertion.MoveToDepth(60.0, 50.0);
  EXPECT_EQ(insertion.state.contact.num_unresolved(), 0);
  hard.Expect("force against a new factorisation", ErrorOfFreshSolveN(insertion.state.contact),
              Below(1e-9), "N");
  Largest force_n;
  for (const forces::NeedleForce& force : insertion.log) force_n.Add(force.force_in_ct_n.norm());
  hard.Expect("largest force", force_n, Below(4.0), "N");
}

}  // namespace
}  // namespace acus::tissue
