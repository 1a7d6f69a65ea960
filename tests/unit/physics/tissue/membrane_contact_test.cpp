// A tip on a membrane: forces, energy and rest.
#include <cmath>
#include <gtest/gtest.h>

#include "support/fem_needle_scene.h"

namespace acus::tissue {
namespace {

using testing_support::FemScene;
using testing_support::SceneOptions;

SceneOptions Covered(double inner_mpa = 0.0) {
  SceneOptions options;
  options.cells = {10, 10, 10};
  options.inner_below_mm = 30.0;  // A face of the cells, which are even.
  options.jitter = 0.0;
  mechanics::Membrane skin;
  skin.tissue = 4;
  skin.against.set(0);
  skin.youngs_modulus_mpa = 0.13;
  skin.poissons_ratio = 0.45;
  skin.thickness_mm = 2.0;
  options.membranes.push_back(skin);
  if (inner_mpa > 0.0) {
    mechanics::Membrane inner = skin;
    inner.tissue = 5;
    inner.against.reset();
    inner.against.set(4);
    inner.youngs_modulus_mpa = inner_mpa;
    inner.thickness_mm = 0.1;
    options.membranes.push_back(inner);
  }
  return options;
}

TEST(MembraneContact, StiffensUnderTheTip) {
  FemScene scene(Covered());
  scene.StepAt(-1.0);
  double previous_n = 0.0, previous_slope = 0.0;
  for (double depth_mm = 0.02; depth_mm < 20.0; depth_mm += 0.02) {
    const forces::NeedleForce force = scene.StepAt(depth_mm);
    if (scene.state.phase != NeedlePhase::kOnSkin) break;
    const double slope = (force.puncture_n - previous_n) / 0.02;
    EXPECT_GT(slope, 0.0) << depth_mm;
    if (depth_mm > 0.5) {
      EXPECT_GT(slope, 0.8 * previous_slope) << depth_mm;
    }
    previous_n = force.puncture_n;
    previous_slope = slope;
  }
  EXPECT_EQ(scene.state.phase, NeedlePhase::kInside);
  EXPECT_NEAR(previous_n, 1.5, 0.02);
}

TEST(MembraneContact, PressingAndLettingGoIsElastic) {
  FemScene scene(Covered());
  scene.StepAt(-1.0);
  double work_n_mm = 0.0, stored_n_mm = 0.0, before_mm = 0.0;
  for (int n = 0; n <= 8000; ++n) {
    const double depth_mm = 2.5 * (1.0 - std::cos(2.0 * 3.14159265358979 * n / 4000.0)) * 0.5;
    const double force_n = scene.StepAt(depth_mm).puncture_n;
    work_n_mm += force_n * (depth_mm - before_mm);
    stored_n_mm = std::max(stored_n_mm, work_n_mm);
    before_mm = depth_mm;
  }
  ASSERT_EQ(scene.state.phase, NeedlePhase::kOnSkin);
  EXPECT_GT(stored_n_mm, 0.3);
  EXPECT_LT(std::abs(work_n_mm), 0.005 * stored_n_mm);
}

TEST(MembraneContact, AStillTipIsAtRest) {
  FemScene scene(Covered());
  scene.Move(-1.0, 3.0);
  double last_n = 0.0;
  for (int n = 0; n < 300; ++n) last_n = scene.StepAt(3.0).puncture_n;
  for (int n = 0; n < 1000; ++n) EXPECT_NEAR(scene.StepAt(3.0).puncture_n, last_n, 1e-9);
}

TEST(MembraneContact, AJumpComesToTheSameForce) {
  FemScene slow(Covered()), fast(Covered());
  slow.Move(-1.0, 3.0, 0.01);
  fast.StepAt(-1.0);
  double slow_n = 0.0, fast_n = 0.0;
  for (int n = 0; n < 300; ++n) {
    slow_n = slow.StepAt(3.0).puncture_n;
    fast_n = fast.StepAt(3.0).puncture_n;
  }
  EXPECT_NEAR(fast_n, slow_n, 1e-6);
}

TEST(MembraneContact, ACapsuleIsPiercedAtItsForceAndLessDeepIfItIsStiff) {
  const auto depth_of_inner = [](double modulus_mpa) {
    SceneOptions options = Covered(modulus_mpa);
    options.soft_mpa = options.inner_mpa = 0.003;
    FemScene scene(options);
    int punctures = 0;
    double before_n = 0.0;
    for (double depth_mm = -1.0; depth_mm < 55.0; depth_mm += 0.05) {
      const forces::NeedleForce force = scene.StepAt(depth_mm);
      if (force.event == forces::NeedleEvent::kPuncture && ++punctures == 2) {
        EXPECT_NEAR(force.puncture_n + force.cutting_n, 1.2, 0.02);
        return depth_mm;
      }
      before_n = force.puncture_n + force.cutting_n;
    }
    ADD_FAILURE() << "never pierced, " << before_n << " N";
    return 0.0;
  };
  const double soft_mm = depth_of_inner(0.01), stiff_mm = depth_of_inner(20.0);
  EXPECT_GT(soft_mm, 30.0);
  EXPECT_LT(stiff_mm, soft_mm - 0.3);
  EXPECT_GT(stiff_mm, 29.0);
}

TEST(MembraneContact, ACopyContinuesWithTheSameBits) {
  FemScene scene(Covered(5.0));
  scene.Move(-1.0, 2.0);
  FemScene other(Covered(5.0));
  other.state = scene.state;
  other.time_s = scene.time_s;
  for (double depth_mm = 2.0; depth_mm < 40.0; depth_mm += 0.1) {
    EXPECT_EQ(scene.StepAt(depth_mm).force_in_ct_n, other.StepAt(depth_mm).force_in_ct_n);
  }
}

}  // namespace
}  // namespace acus::tissue
