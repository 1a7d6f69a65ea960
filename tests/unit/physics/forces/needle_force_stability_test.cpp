// What a real session can throw at the needle law: it stays finite, bounded, repeatable and cheap.
#include <array>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <gmock/gmock.h>
#include <new>

#include "acus/physics/forces/models/needle_force.h"
#include "layered_body.h"
#include "support/wild_hand.h"

namespace {
thread_local long allocation_count = 0;
}

// Counts what the global operator new gives out in this program. Not inlined: GCC would see free()
// of what it takes for another operator new. Sanitizers have operators of their own.
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define ACUS_COUNTS_ALLOCATIONS 1
[[gnu::noinline]] void* operator new(std::size_t size) {
  ++allocation_count;
  if (void* memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* memory) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}
#endif

namespace acus::forces {
namespace {

using testing_support::SameBits;
using testing_support::WildHand;

ForceTable DefaultTable() {
  return ReadForceTable(kConfigs / "forces" / "default.json");
}

TEST(NeedleForceStability, AMillionRandomStepsStayFiniteAndBounded) {
  const NeedleForceModel model(DefaultTable(), Trocar());
  const double bound_n = model.table().settings.largest_force_n;
  constexpr int kNumEvents = static_cast<int>(NeedleEvent::kChannelInterface) + 1;
  std::array<int, kNumEvents> events = {};
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    WildHand hand(seed);
    NeedleForceState state;
    for (int i = 0; i < 100000; ++i) {
      const NeedleForce out = model.Step(state, hand.Next());
      ++events.at(static_cast<std::size_t>(out.event));
      ASSERT_TRUE(out.force_in_ct_n.allFinite() && std::isfinite(out.AxialN()) &&
                  std::isfinite(out.depth_mm))
          << seed << " " << i;
      ASSERT_LE(out.force_in_ct_n.norm(), bound_n * (1.0 + 1e-12)) << seed << " " << i;
      ASSERT_NEAR(state.path.direction_in_ct.norm(), 1.0, 1e-9);
      ASSERT_LE(state.path.num_segments, NeedlePath::kMaxSegments);
      ASSERT_GE(out.bone_n, 0.0);
      ASSERT_GE(out.puncture_n, 0.0);
      ASSERT_GE(out.cutting_n, 0.0);
    }
    EXPECT_GT(state.num_rejected, 0);
    EXPECT_GT(state.num_time_back, 0);
  }
  for (int event = 1; event < kNumEvents; ++event) {
    EXPECT_GT(events[static_cast<std::size_t>(event)], 10) << event;  // All were met.
  }
}

TEST(NeedleForceStability, TheSameSamplesGiveTheSameBits) {
  const NeedleForceModel model(DefaultTable(), Trocar());
  WildHand a(3);
  WildHand b(3);
  NeedleForceState state_a;
  NeedleForceState state_b;
  NeedleForceState saved;
  for (int i = 0; i < 50000; ++i) {
    ASSERT_TRUE(SameBits(model.Step(state_a, a.Next()), model.Step(state_b, b.Next()))) << i;
    if (i == 20000) saved = state_b;
  }
  // A saved state goes on as if nothing had happened.
  WildHand c(3);
  for (int i = 0; i <= 20000; ++i) c.Next();
  NeedleForceState replay;
  WildHand d(3);
  for (int i = 0; i <= 20000; ++i) model.Step(replay, d.Next());
  for (int i = 0; i < 1000; ++i) {
    ASSERT_TRUE(SameBits(model.Step(saved, c.Next()), model.Step(replay, d.Next())));
  }
}

TEST(NeedleForceStability, StepAllocatesNothing) {
#ifndef ACUS_COUNTS_ALLOCATIONS
  GTEST_SKIP() << "a sanitizer build does not count allocations";
#endif
  const NeedleForceModel model(DefaultTable(), Trocar());
  WildHand hand(5);
  NeedleForceState state;
  model.Step(state, hand.Next());
  const long before = allocation_count;
  for (int i = 0; i < 20000; ++i) model.Step(state, hand.Next());
  EXPECT_EQ(allocation_count - before, 0);
}

// A hand with a tremor of 0.1 mm at 8 Hz that stands still in tissue: the force moves with it by no
// more than the stiffest spring in play allows, from sample to sample.
TEST(NeedleForceStability, TremorDoesNotChatter) {
  const NeedleForceModel model(DefaultTable(), Trocar());
  for (const double depth_mm : {3.0, 12.0, 30.0, 45.0}) {
    Insertion drive{model,
                    {{{0.0, volume::LabelOf("skin")},
                      {2.0, volume::LabelOf("fat")},
                      {12.0, volume::LabelOf("muscle")},
                      {30.0, volume::LabelOf("liver")}}}};
    drive.MoveTo(depth_mm, 10.0);
    double before_n = drive.last.AxialN();
    for (int i = 0; i < 5000; ++i) {
      const double z_mm = depth_mm + 0.1 * std::sin(2.0 * 3.14159 * 8.0 * 0.001 * i);
      const double step_mm = std::abs(z_mm - drive.z_mm);
      drive.StepTo(z_mm);
      const double friction_stiffness =
          drive.state.path.FrictionN(std::max(0.0, drive.last.depth_mm)) / 0.5;
      const double stiffest = 2.0 + 2.0 * friction_stiffness + 3.0;  // Wall, bristles, membrane.
      ASSERT_LE(std::abs(drive.last.AxialN() - before_n), stiffest * step_mm + 0.03)
          << depth_mm << " mm, step " << i;
      before_n = drive.last.AxialN();
    }
  }
}

// Printed for the record; the bound is a hundred times what it takes, for busy machines.
TEST(NeedleForceStability, StepIsCheap) {
  const NeedleForceModel model(DefaultTable(), Trocar());
  std::vector<NeedleInput> inputs;
  WildHand hand(7);
  for (int i = 0; i < 100000; ++i) inputs.push_back(hand.Next());
  NeedleForceState state;
  double sum_n = 0.0;
  const auto begin = std::chrono::steady_clock::now();
  for (const NeedleInput& input : inputs) sum_n += model.Step(state, input).AxialN();
  const std::chrono::duration<double, std::nano> took = std::chrono::steady_clock::now() - begin;
  const double ns = took.count() / static_cast<double>(inputs.size());
  std::printf("  NeedleForceModel::Step takes %.0f ns (mean of 100000; sum %.3f N)\n", ns, sum_n);
  EXPECT_LT(ns, 50000.0);
}

TEST(NeedlePath, FoldsItsShallowestTissuesWhenFull) {
  NeedlePath path;
  double expected_n = 0.0;
  for (int i = 0; i < 300; ++i) {
    const double friction = 0.01 * (1 + i % 5);
    path.Append(static_cast<volume::Label>(1 + i % 5), friction, 0.5 * friction);
    path.ExtendTo(0.4 * (i + 1));
    expected_n += 0.4 * friction;
  }
  EXPECT_EQ(path.num_segments, NeedlePath::kMaxSegments);
  EXPECT_NEAR(path.FrictionN(0.4 * 300), expected_n, 1e-9);
  EXPECT_NEAR(path.WithdrawalFrictionN(0.4 * 300), 0.5 * expected_n, 1e-9);
  EXPECT_NEAR(path.EndMm(), 120.0, 1e-9);
  path.CutOffAt(110.0);
  EXPECT_NEAR(path.EndMm(), 110.0, 1e-12);
  EXPECT_EQ(path.FrictionN(0.0), 0.0);
  EXPECT_EQ(path.FrictionN(-5.0), 0.0);
}

}  // namespace
}  // namespace acus::forces
