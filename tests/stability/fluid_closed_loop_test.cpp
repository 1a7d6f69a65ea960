// A syringe in the loop with a haptic device and a thumb: it does not drive the thumb.
#include <cstdio>
#include <gtest/gtest.h>
#include <optional>

#include "acus/base/config/json_file.h"
#include "acus/physics/fluid/fluid_model.h"
#include "references/closed_loop.h"
#include "support/bound.h"

namespace acus::fluid {
namespace {

using Eigen::Vector3d;
using testing_support::Above;
using testing_support::AtMost;
using testing_support::HardCase;

constexpr double kLoopSeconds = 30.0;

/// The device's z is the thumb's place along the barrel; the tissue changes each second.
forces::LoopResult PlayLoop(const FluidModel& model, double rate_hz, double coupling_n_per_mm,
                            bool is_blocked, std::uint64_t seed) {
  const int bone = model.table().TissueIndex("bone");
  const int tissues[] = {bone, model.table().TissueIndex("ligament"),
                         model.table().TissueIndex("epidural_lumbar"),
                         model.table().TissueIndex("fat")};
  FluidState state = model.NewState();
  // The thumb meets the plunger where it is: no spring is tense at the start.
  double before_mm = state.plunger_mm;
  std::optional<double> offset_mm;
  const forces::ForceOfPlace force = [&](double time_s, const Vector3d& at_mm) {
    if (!offset_mm) offset_mm = before_mm - at_mm.z();
    const double hand_mm = at_mm.z() + *offset_mm;
    FluidInput input;
    input.drive = Drive::kPosition;
    input.hand_mm = hand_mm;
    input.hand_mm_per_s = (hand_mm - before_mm) * rate_hz;
    before_mm = hand_mm;
    input.coupling_n_per_mm = coupling_n_per_mm;
    input.coupling_n_s_per_mm = CouplingDampingNSPerMm(coupling_n_per_mm, 1.0 / rate_hz);
    input.bevel[0] = {is_blocked ? bone : tissues[static_cast<int>(time_s) % 4], 1.0};
    return Vector3d(0.0, 0.0, -model.Step(state, input, 1.0 / rate_hz).reaction_n);
  };
  forces::HapticDevice device;
  device.rate_hz = rate_hz;
  forces::RandomHand motion;
  motion.from_mm = 20.0;
  motion.to_mm = 45.0;
  motion.across_mm = 0.0;
  forces::Hand hand;
  hand.wants_in_ct_mm = forces::RandomMotion(motion, kLoopSeconds, seed);
  return forces::RunClosedLoop(device, hand, force, kLoopSeconds);
}

TEST(FluidInTheLoop, AThumbGetsLessEnergyThanItGave) {
  const HardCase hard("A blocked syringe is a spring, and its force comes a sample late.");
  const FluidTable table = ReadFluidTable(config::FindConfig("fluid/default.json", "."));
  struct {
    double rate_hz, coupling_n_per_mm;
  } const loops[] = {{4000.0, 2.0}, {1000.0, 2.0}, {1000.0, 0.5}, {250.0, 0.5}};
  for (const double air_share : {0.0, 0.1, 1.0}) {
    const FluidModel model(table, table.SyringeNamed("lor_glass_10ml"), {6.0, air_share},
                           {.inner_diameter_mm = 1.194, .length_mm = 80.0});
    for (const auto& loop : loops) {
      for (const bool is_blocked : {true, false}) {
        const forces::LoopResult result =
            PlayLoop(model, loop.rate_hz, loop.coupling_n_per_mm, is_blocked, 3);
        std::printf("  %4.0f Hz %.1f N/mm air %.1f %s: generated %.4f mJ, took %.1f mJ\n",
                    loop.rate_hz, loop.coupling_n_per_mm, air_share,
                    is_blocked ? "blocked" : "tissues", result.generated_mj, result.taken_mj);
        const std::string of = Message(", ", loop.rate_hz, " Hz, ", loop.coupling_n_per_mm,
                                       " N/mm, air ", air_share, is_blocked ? ", blocked" : "");
        hard.Expect("energy generated" + of, result.generated_mj, AtMost(0.01), "mJ");
        if (!is_blocked) hard.Expect("energy taken" + of, result.taken_mj, Above(1.0), "mJ");
      }
    }
  }
}

}  // namespace
}  // namespace acus::fluid
