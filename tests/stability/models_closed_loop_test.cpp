// The models of deformable tissue in the loop with a device and a hand: none drives the hand, none
// buzzes. (Models without tissue: forces_closed_loop_test.cpp; the bendable needle of scenes:
// with the simulation.)
#include <cstdio>
#include <gmock/gmock.h>

#include "benchmarks/force_model_cases.h"
#include "references/closed_loop.h"
#include "support/bound.h"

namespace acus::benchmarks {
namespace {

using Eigen::Vector3d;
using forces::Hand;
using forces::HapticDevice;
using forces::LoopResult;
using testing_support::Above;
using testing_support::AtMost;
using testing_support::HardCase;

constexpr double kSeconds = 60.0;

bool IsOfTissue(const ForceModelCase& model) {
  return model.name == "springs" || model.name == "fe_2d" || model.name == "fe_3d";
}

/// A needle of this model, as the loop asks for it: its axis stays.
forces::ForceOfPlace LoopOf(const ForceModelCase& model) {
  return [step = model.begin()](double time_s, const Vector3d& tip_mm) {
    tissue::ToolSample sample;
    sample.time_s = time_s;
    sample.tip_in_ct_mm = tip_mm;
    sample.axis_in_ct = -Vector3d::UnitZ();
    return step(sample).force_in_ct_n;
  };
}

class ModelsInTheLoop : public testing::Test {
 protected:
  const std::vector<ForceModelCase> levels_ = ForceModelCases({.element_mm = 6.0}, {});
};

TEST_F(ModelsInTheLoop, RandomInteractionGeneratesNoEnergy) {
  const HardCase hard(
      "Deformable tissue stores energy: it must not give a hand more than it took.");
  for (const ForceModelCase& model : levels_) {
    if (!IsOfTissue(model)) continue;
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      forces::RandomHand motion;
      motion.axis_in_ct = -Vector3d::UnitZ();
      Hand hand;
      hand.wants_in_ct_mm = RandomMotion(motion, kSeconds, seed);
      const LoopResult result = RunClosedLoop({}, hand, LoopOf(model), kSeconds);
      std::printf("  %-8s hand %d: generated %.4f mJ, took %.1f mJ, chatter %.3f N\n",
                  model.name.c_str(), static_cast<int>(seed), result.generated_mj, result.taken_mj,
                  result.ChatterN(1.0, kSeconds));
      const std::string of = Message(", ", model.name, ", hand ", seed);
      hard.Expect("energy generated" + of, result.generated_mj, AtMost(1.0), "mJ");
      hard.Expect("energy taken" + of, result.taken_mj, Above(1.0), "mJ");
    }
  }
}

TEST_F(ModelsInTheLoop, StandingStillInTissueThereIsNoLimitCycle) {
  const HardCase hard("Standing still at 25 mm: stick and slip of many nodes could take turns.");
  for (const ForceModelCase& model : levels_) {
    if (!IsOfTissue(model)) continue;
    for (const double dry_friction_n : {0.0, 0.05}) {
      HapticDevice device;
      device.dry_friction_n = dry_friction_n;
      Hand hand;
      hand.wants_in_ct_mm = [](double t) {
        const double s = std::clamp(t / 3.0, 0.0, 1.0);
        const double share = s * s * s * (10.0 + s * (-15.0 + 6.0 * s));
        return Vector3d(0.0, 0.0, 2.0 - 27.0 * share);
      };
      const LoopResult held = RunClosedLoop(device, hand, LoopOf(model), 12.0);
      std::printf("  %-8s at 25 mm, dry friction %.2f N: swing %.5f mm, chatter %.5f N\n",
                  model.name.c_str(), dry_friction_n, held.SwingMm(8.0, 12.0),
                  held.ChatterN(8.0, 12.0));
      hard.Expect(Message("swing, ", model.name, ", dry friction ", dry_friction_n, " N"),
                  held.SwingMm(8.0, 12.0), AtMost(dry_friction_n > 0.0 ? 1e-6 : 0.04), "mm");
    }
  }
}

}  // namespace
}  // namespace acus::benchmarks
