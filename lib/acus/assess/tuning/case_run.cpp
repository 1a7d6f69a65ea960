#include "acus/assess/tuning/case_run.h"

#include <algorithm>
#include <cmath>

#include "acus/assess/tuning/soundness.h"
#include "acus/base/core/cpu_time.h"
#include "acus/base/core/error.h"
#include "acus/base/math/statistics.h"
#include "acus/data/session/session_import.h"
#include "acus/run/replay/cost_check.h"
#include "acus/run/replay/image_log.h"
#include "acus/run/replay/step_log.h"
#include "acus/scene/simulation/probe_image_renderer.h"
#include "acus/scene/simulation/scene.h"

namespace acus::tuning {
namespace {

using simulation::Scene;
using simulation::Snapshot;

std::int64_t Nanoseconds(double seconds) {
  return std::llround(1e9 * seconds);
}

/// The stream whose samples drive the steps.
session::PoseStream& Clock(session::Session& session) {
  return session.needle.empty() ? session.probe : session.needle;
}

void CutAfter(session::PoseStream& stream, std::int64_t last_ns) {
  const auto end =
      std::ranges::upper_bound(stream, last_ns, {}, [](const auto& s) { return s.time_ns; });
  stream.erase(end, stream.end());
}

/// The measured part of a session.
struct Window {
  std::int64_t from_ns = 0;
  std::int64_t to_ns = 0;

  bool Holds(std::int64_t time_ns) const { return time_ns >= from_ns && time_ns <= to_ns; }
};

Window WindowOf(const SweptScene& scene, const session::Session& session) {
  std::int64_t last_ns = session.start_ns();
  for (const auto* stream : {&session.needle, &session.probe}) {
    if (!stream->empty()) last_ns = std::max(last_ns, stream->back().time_ns);
  }
  return {session.start_ns() + Nanoseconds(scene.from_s), last_ns};
}

/// At most `most` of the snapshots, evenly spaced.
std::vector<Snapshot> Moments(const Scene& scene, const session::Session& session,
                              const Window& window, int most) {
  std::vector<Snapshot> all = replay::Snapshots(scene, session, nullptr);
  std::erase_if(all, [&](const Snapshot& moment) { return !window.Holds(moment.time_ns); });
  const std::size_t count = std::min(all.size(), static_cast<std::size_t>(most));
  std::vector<Snapshot> moments;
  for (std::size_t i = 0; i < count; ++i) moments.push_back(all[i * all.size() / count]);
  return moments;
}

/// Forces at the common times: those of the last step until then.
void TakeForces(const replay::StepLog& log, const Window& window, std::int64_t start_ns,
                Series& series) {
  if (log.steps.empty()) return;
  // Times of k / rate are rounded to whole nanoseconds.
  constexpr std::int64_t kSlackNs = 1000;
  const std::int64_t first_ns = std::max(window.from_ns, log.steps.front().time_ns);
  series.first_s = 1e-9 * static_cast<double>(first_ns - start_ns);
  std::size_t step = 0;
  for (std::int64_t time_ns = first_ns; time_ns <= window.to_ns;
       time_ns += Nanoseconds(1e-3 * kCommonStepMs)) {
    while (step + 1 < log.steps.size() && log.steps[step + 1].time_ns <= time_ns + kSlackNs) ++step;
    const Eigen::Vector3d& needle = log.steps[step].force.force_in_ct_n;
    const Eigen::Vector3d& probe = log.steps[step].probe.force_in_ct_n;
    series.force_n.push_back({needle.x(), needle.y(), needle.z(), probe.x(), probe.y(), probe.z()});
  }
  for (const simulation::StepOutput& out : log.steps) {
    if (out.force.event == forces::NeedleEvent::kNone || !window.Holds(out.time_ns)) continue;
    series.event_s.push_back(1e-9 * static_cast<double>(out.time_ns - start_ns));
  }
}

void TakeStepTimes(const replay::StepLog& log, const std::vector<double>& cpu_s,
                   const Window& window, Measured& out) {
  const double clock_s = replay::CpuClockCostSeconds();
  std::vector<double> times_us;
  for (std::size_t i = 0; i < log.steps.size(); ++i) {
    if (!window.Holds(log.steps[i].time_ns)) continue;
    times_us.push_back(1e6 * std::max(0.0, cpu_s[i] - clock_s));
  }
  out.steps = static_cast<std::int64_t>(times_us.size());
  if (times_us.empty()) return;
  out.step_us_median = math::Median(times_us);
  out.step_us_p999 = math::Quantile(times_us, 0.999);
  out.step_us_mean = math::Mean(times_us);
}

/// Renders all snapshots, in one thread.
void RunImages(const Scene& scene, const std::vector<Snapshot>& moments,
               simulation::StageTimes& times, const RunContext& context, CaseRun& out) {
  simulation::ProbeImageRenderer renderer(scene);
  simulation::ProbeImages images;
  // The first image allocates buffers for the others.
  if (!moments.empty()) renderer.Render(moments.front(), images);
  std::vector<double> times_ms;
  for (std::size_t i = 0; i < moments.size(); ++i) {
    if (i % 8 == 0)
      context.Checkpoint("images", static_cast<double>(i) / static_cast<double>(moments.size()));
    const double begin_s = ThreadCpuSeconds();
    renderer.Render(moments[i], images, &times);
    times_ms.push_back(1e3 * (ThreadCpuSeconds() - begin_s));
    const auto& image = images.b_mode.pixels.empty() ? images.ct_slice : images.b_mode;
    out.series.width = image.width;
    out.series.height = image.height;
    out.series.pixels.insert(out.series.pixels.end(), image.pixels.begin(), image.pixels.end());
  }
  out.measured.images = out.series.num_images();
  if (out.measured.images == 0) return;
  out.measured.image_ms_median = math::Median(times_ms);
  out.measured.image_ms_p95 = math::Quantile(times_ms, 0.95);
  out.measured.image_ms_mean = math::Mean(times_ms);
}

std::vector<StageShare> SharesOf(const simulation::EffectPlan& plan,
                                 const simulation::StageTimes& times) {
  const auto total = [&](std::string_view rate) {
    double seconds = 0.0;
    for (const auto& stage : plan.stages()) {
      if (stage.rate == rate) seconds += times.Of(stage).seconds;
    }
    return seconds;
  };
  std::vector<StageShare> shares;
  for (const auto& stage : plan.stages()) {
    const auto& cost = times.Of(stage);
    if (!stage.in || cost.runs == 0) continue;
    shares.push_back({std::string(stage.name), std::string(stage.rate),
                      cost.seconds / std::max(1e-12, total(stage.rate)),
                      static_cast<double>(cost.asleep) / static_cast<double>(cost.runs)});
  }
  return shares;
}

/// Loads a scene, and measures the time and memory before its first step.
Scene LoadTimed(const scenario::Scenario& scenario, const simulation::EffectPlan& plan,
                RunContext& context, Measured& out) {
  const double heap_mb = HeapMb();
  const double begin_s = ProcessCpuSeconds();
  Scene scene = simulation::LoadScene(scenario, plan, context);
  out.preparation_s = ProcessCpuSeconds() - begin_s;
  out.memory_mb = std::max(0.0, HeapMb() - heap_mb);
  // The compliance is mapped from its file: it is not on the heap.
  const auto compliance = scenario.patient.mesh.parent_path() / "compliance.acc";
  if (plan.Writes(effects::ports::kContact) && std::filesystem::exists(compliance)) {
    out.memory_mb += 1e-6 * static_cast<double>(std::filesystem::file_size(compliance));
  }
  return scene;
}

}  // namespace

session::Session ReadSessionOf(const SweptScene& scene, const scenario::Scenario& scenario,
                               const RunContext& context) {
  session::Session session =
      session::ReadAnySession(scene.session, scenario.session, context).session;
  if (scene.to_s > 0.0) {
    const std::int64_t last_ns = session.start_ns() + Nanoseconds(scene.to_s);
    CutAfter(session.needle, last_ns);
    CutAfter(session.probe, last_ns);
  }
  const Window window = WindowOf(scene, session);
  ACUS_REQUIRE(window.to_ns > window.from_ns, scene.session.string(), ": has nothing after ",
               scene.from_s, " s; it is ",
               1e-9 * static_cast<double>(window.to_ns - session.start_ns()), " s long");
  return session;
}

double RecordedRateHz(const session::Session& session) {
  const auto& stream = session.needle.empty() ? session.probe : session.needle;
  if (stream.size() < 2) return 0.0;
  std::vector<double> periods_s;
  for (std::size_t i = 1; i < stream.size(); ++i) {
    periods_s.push_back(1e-9 * static_cast<double>(stream[i].time_ns - stream[i - 1].time_ns));
  }
  const double rate_hz = 1.0 / math::Median(periods_s);
  return rate_hz >= 10.0 ? std::round(rate_hz) : rate_hz;
}

session::Session Resampled(const session::Session& session, double rate_hz) {
  ACUS_REQUIRE(rate_hz >= 10.0 && rate_hz <= 1e5, "step_rate_hz: ", rate_hz,
               " is out of range; 10 to 100000 Hz are allowed");
  session::Session out = session;
  session::PoseStream& clock = Clock(out);
  if (clock.empty()) return out;
  const session::PoseStream recorded = std::move(clock);
  clock.clear();
  for (std::int64_t k = 0;; ++k) {
    const std::int64_t time_ns =
        recorded.front().time_ns + Nanoseconds(static_cast<double>(k) / rate_hz);
    if (time_ns > recorded.back().time_ns) break;
    clock.push_back(session::PoseAt(recorded, time_ns));
    clock.back().time_ns = time_ns;
  }
  return out;
}

std::vector<scenario::Override> SeedChanges(const scenario::Scenario& scenario,
                                            std::uint64_t seed) {
  std::vector<scenario::Override> changes;
  if (scenario.ultrasound) {
    changes.push_back({"/effects/ultrasound/seed", scenario.ultrasound->seed + seed});
  }
  if (!scenario.breathing || !scenario.breathing->signal.empty()) return changes;
  const auto& pattern = scenario.breathing->pattern;
  if (pattern.period_spread > 0.0 || pattern.speed_spread > 0.0 || pattern.level_spread > 0.0) {
    changes.push_back({"/effects/breathing/pattern/seed", pattern.seed + seed});
  }
  return changes;
}

CaseRun RunCase(const SweptScene& swept, const RunSettings& settings, RunContext& context) {
  std::vector<scenario::Override> changes = swept.changes;
  changes.insert(changes.end(), settings.changes.begin(), settings.changes.end());
  auto scenario = scenario::ReadScenario(swept.scenario, changes);
  const auto seeds = SeedChanges(scenario, settings.seed);
  if (!seeds.empty()) {
    changes.insert(changes.end(), seeds.begin(), seeds.end());
    scenario = scenario::ReadScenario(swept.scenario, changes);
  }
  session::Session session = ReadSessionOf(swept, scenario, context);
  const Window window = WindowOf(swept, session);
  if (settings.step_rate_hz > 0.0) session = Resampled(session, settings.step_rate_hz);
  const simulation::EffectPlan plan =
      simulation::PlanEffects(scenario, {.needle_poses = !session.needle.empty(),
                                         .probe_poses = !session.probe.empty(),
                                         .breath = !session.breath.empty()});
  CaseRun out;
  out.measured.seed = settings.seed;
  const Scene scene = LoadTimed(scenario, plan, context, out.measured);
  std::vector<Snapshot> moments = Moments(scene, session, window, swept.most_images);

  std::vector<double> step_cpu_s;
  replay::StepLog log = replay::RunSteps(scene, session, moments, nullptr, context, &step_cpu_s);
  TakeForces(log, window, session.start_ns(), out.series);
  TakeStepTimes(log, step_cpu_s, window, out.measured);
  out.measured.unusable = WhyUnusable(scenario, scene, log);
  simulation::StageTimes times(plan);
  RunImages(scene, moments, times, context, out);
  // Reading the clock at each stage would add to the time of the steps: they run a second time.
  if (!log.steps.empty()) replay::RunSteps(scene, session, {}, &times, context);
  out.measured.stages = SharesOf(plan, times);
  return out;
}

}  // namespace acus::tuning
