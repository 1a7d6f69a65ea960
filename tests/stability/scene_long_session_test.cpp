// A long session: the patient breathes, the needle goes in and out. 36 s by default, an hour with
// developer/stability --full. Nothing drifts, nothing grows, no step gets slower.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <malloc.h>
#include <span>

#include "acus/base/core/cpu_time.h"
#include "acus/base/math/statistics.h"
#include "support/bending_scene.h"
#include "support/bound.h"
#include "support/breathing_patients.h"
#include "support/stability_length.h"

namespace acus::simulation {
namespace {

using Eigen::Vector3d;
using scenario::NeedleForceModelKind;
using testing_support::AtMost;
using testing_support::Below;
using testing_support::BendingScene;
using testing_support::BoundPlot;
using testing_support::HardCase;
using testing_support::Largest;
using testing_support::NeedleAt;

constexpr int kStrokeSteps = 12'000;  // Three breaths of four seconds.
constexpr int kCompareEvery = 10;

Scene BreathingScene(NeedleForceModelKind force) {
  BendingScene bending;
  bending.force = force;
  Scene scene = bending.Make();
  testing_support::BreathingPatient patient{.kind = breathing::MotionKind::kSurrogate,
                                            .nodes_per_axis = 32};
  patient.box.size.setConstant(301);
  patient.box.origin_mm = Vector3d(-150.0, -150.0, -90.0);
  patient.largest_mm = 15.0;
  patient.towards = {0.0, 1.0, 0.3};
  scene.breathing.emplace(patient.Make());
  scene.breathing->source =
      breathing::BreathSource(breathing::BreathingPattern({.period_s = 4.0, .exponent = 2}), {});
  return scene;
}

/// In to 50 mm, leaning aside, a while there, out again, and a while in air.
Sample OnStroke(std::int64_t step) {
  const double s = 1e-3 * static_cast<double>(step % kStrokeSteps);
  const auto ease = [](double x) {
    const double t = std::clamp(x, 0.0, 1.0);
    return t * t * (3.0 - 2.0 * t);
  };
  const double in = ease((s - 0.5) / 3.0) - ease((s - 8.0) / 2.5);
  const double lean = ease((s - 4.0) / 1.0) - ease((s - 6.5) / 1.0);
  Sample sample = NeedleAt(0.0, {0.0, 0.0, -20.0 + 70.0 * in}, {0.0, 0.15 * lean, 0.0});
  sample.time_ns = step * 1'000'000;
  return sample;
}

double BytesInUse() {
  const auto info = mallinfo2();
  return static_cast<double>(info.uordblks + info.hblkhd);
}

struct Session {
  Largest force_n;
  Largest drift_n;                ///< Against the second stroke, at equal poses.
  double grown_bytes = 0.0;       ///< Since the second stroke.
  std::vector<double> stroke_us;  ///< Mean CPU time of a step in each stroke.
  BoundPlot::Curve drift;
};

Session RunFor(const Scene& scene, std::int64_t num_strokes) {
  const Simulation simulation(scene);
  State state = simulation.NewState();
  std::vector<Vector3d> reference_n(kStrokeSteps / kCompareEvery, Vector3d::Zero());
  Session session;
  session.stroke_us.reserve(static_cast<std::size_t>(num_strokes));
  session.drift.x.reserve(static_cast<std::size_t>(num_strokes));
  session.drift.y.reserve(static_cast<std::size_t>(num_strokes));
  double begin_bytes = 0.0;
  for (std::int64_t stroke = 0; stroke < num_strokes; ++stroke) {
    if (stroke == 2) begin_bytes = BytesInUse();
    const double begin_s = ThreadCpuSeconds();
    Largest drift_n;
    for (int i = 0; i < kStrokeSteps; ++i) {
      const Vector3d force_n =
          simulation.Step(state, OnStroke(stroke * kStrokeSteps + i)).force.force_in_ct_n;
      session.force_n.Add(force_n.norm());
      if (i % kCompareEvery != 0) continue;
      Vector3d& reference = reference_n[static_cast<std::size_t>(i / kCompareEvery)];
      if (stroke < 2) reference = force_n;
      drift_n.Add((force_n - reference).norm());
    }
    session.stroke_us.push_back(1e6 / kStrokeSteps * (ThreadCpuSeconds() - begin_s));
    if (stroke < 2) continue;
    session.drift_n.Add(drift_n);
    session.drift.Add(1e-3 * kStrokeSteps * static_cast<double>(stroke), drift_n);
  }
  session.grown_bytes = BytesInUse() - begin_bytes;
  return session;
}

TEST(LongSession, NothingDriftsGrowsOrSlowsDown) {
  const HardCase hard(
      "In and out of a patient who breathes, each stroke as the one before, for long.");
  const double seconds = testing_support::StabilitySessionSeconds(60.0);
  const auto num_strokes = static_cast<std::int64_t>(1e3 * seconds / kStrokeSteps);
  BoundPlot plot{.title = "Force against the second stroke, at equal poses",
                 .x_label = "time [s]",
                 .y_label = "largest difference in a stroke [N]"};
  for (const auto& [name, force] : {std::pair{"layered", NeedleForceModelKind::kLayered},
                                    std::pair{"alamilla", NeedleForceModelKind::kAlamilla},
                                    std::pair{"springs", NeedleForceModelKind::kTissue}}) {
    const std::string of = Message(", ", name);
    Session session = RunFor(BreathingScene(force), num_strokes);
    EXPECT_GT(session.force_n, 0.5) << name;
    hard.Expect("largest force" + of, session.force_n, AtMost(30.0), "N");
    hard.Expect("drift of the force at equal poses" + of, session.drift_n, Below(1e-9), "N");
    hard.Expect("memory taken from the third stroke on" + of, session.grown_bytes, AtMost(0.0),
                "bytes");
    const auto& us = session.stroke_us;
    const std::size_t part = std::max<std::size_t>(1, us.size() / 5);
    // CPU time on a machine that others use: caches that are cold count.
    hard.Expect("time of a step in the last fifth, of that in the first" + of,
                math::Median(std::span(us).last(part)) / math::Median(std::span(us).first(part)),
                Below(2.0));
    hard.Note("time of a step" + of, Message(std::lround(math::Median(us)), " us"));
    session.drift.name = name;
    plot.curves.push_back(std::move(session.drift));
  }
  hard.Note("simulated time of each session", Message(seconds, " s"));
  hard.Plot(plot);
}

}  // namespace
}  // namespace acus::simulation
