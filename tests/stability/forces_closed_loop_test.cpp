// Force models in the loop with a device and a hand: none drives the hand, none buzzes, but for the
// direct method, which shows that the observer sees it.
#include <cstdio>
#include <gmock/gmock.h>

#include "support/force_scenes.h"

namespace acus::forces {
namespace {

using testing_support::Abdomen;
using testing_support::DrivenAlamilla;
using testing_support::DrivenLayered;
using testing_support::DrivenProbe;
using testing_support::DrivenVidal;
using testing_support::LayeredBodyField;
using testing_support::ShippedTable;
using testing_support::Trocar18G;

constexpr double kDuration = 60.0;

struct Report {
  double worst_mj = 0.0;
  double least_taken_mj = 1e300;
};

/// 60 s at random, for three hands.
template <typename MakeLoop>
Report RandomInteraction(const char* name, const RandomHand& motion, MakeLoop make_loop) {
  Report report;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    Hand hand;
    hand.wants_in_ct_mm = RandomMotion(motion, kDuration, seed);
    auto driven = make_loop();
    const LoopResult result = RunClosedLoop({}, hand, driven.Loop(), kDuration);
    report.worst_mj = std::max(report.worst_mj, result.generated_mj);
    report.least_taken_mj = std::min(report.least_taken_mj, result.taken_mj);
    std::printf("  %-22s hand %d: generated %.4f mJ, took %.1f mJ, chatter %.3f N\n", name,
                static_cast<int>(seed), result.generated_mj, result.taken_mj,
                result.ChatterN(1.0, kDuration));
  }
  return report;
}

TEST(ForcesClosedLoop, NoShippedModelGeneratesEnergy) {
  const LayeredBodyField body = Abdomen();
  for (const char* table : {"default.json", "alamilla.json", "vidal.json"}) {
    std::printf(" %s\n", table);
    const NeedleForceModel layered(ShippedTable(table), Trocar18G());
    const AlamillaModel alamilla(ShippedTable(table), Trocar18G());
    const VidalModel vidal(ShippedTable(table), Trocar18G(), body);
    const Report a = RandomInteraction("layered", {}, [&] { return DrivenLayered{layered, body}; });
    EXPECT_LE(a.worst_mj, 1.0);
    EXPECT_GT(a.least_taken_mj, 1.0);
    const Report b = RandomInteraction("alamilla", {}, [&] {
      return DrivenAlamilla{alamilla, body};
    });
    EXPECT_LE(b.worst_mj, 1.0);
    EXPECT_GT(b.least_taken_mj, 1.0);
    const Report c = RandomInteraction("vidal", {}, [&] { return DrivenVidal{vidal, body}; });
    EXPECT_LE(c.worst_mj, 1.0);
    EXPECT_GT(c.least_taken_mj, 1.0);
  }
}

TEST(ForcesClosedLoop, TheProbeGeneratesNoEnergy) {
  const LayeredBodyField body({{0.0, "fat", -100}, {8.0, "bone", 900}});
  const VidalProbe probe(ShippedTable("vidal.json"), body);
  RandomHand motion;
  motion.to_mm = 20.0;
  motion.across_mm = 30.0;
  const Report report = RandomInteraction("probe", motion, [&] { return DrivenProbe{probe}; });
  EXPECT_LE(report.worst_mj, 1.0);
}

}  // namespace
}  // namespace acus::forces
