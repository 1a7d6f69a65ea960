#include "acus/run/replay/step_log.h"

#include <algorithm>
#include <fstream>
#include <limits>

#include "acus/base/core/cpu_time.h"
#include "acus/run/step/step_inputs.h"

namespace acus::replay {
namespace {

/// Gives images the load and the needle's shape of their time, as the steps pass it.
class ImageStates {
 public:
  ImageStates(const simulation::Scene& scene, const simulation::Simulation& simulation,
              std::span<simulation::Snapshot> images, StepLog& log)
      : simulation_(simulation),
        log_(log),
        loads_(scene.tools_deform_images),
        shapes_(scene.plan.Writes(effects::ports::kShape)),
        memories_(scene.listed.has_steps()),
        forces_(scene.plan.Writes(effects::ports::kForce)) {
    if (loads_ || shapes_ || memories_ || forces_) images_ = images;
  }

  /// Gives all images before `time_ns` the state after the last step.
  void GiveBefore(std::int64_t time_ns) {
    while (!images_.empty() && images_.front().time_ns < time_ns) {
      if (!log_.steps.empty()) Give(images_.front());
      images_ = images_.subspan(1);
    }
  }

 private:
  void Give(simulation::Snapshot& image) {
    image.needle_force_in_ct_n = log_.steps.back().force.force_in_ct_n;
    if (loads_ && simulation_.LoadOf(log_.final_state, log_.steps.back(), load_)) {
      log_.loads.push_back(load_);
      image.load = &log_.loads.back();
    }
    if (shapes_ && simulation_.ShapeOf(log_.final_state, shape_)) {
      log_.shapes.push_back(shape_);
      image.needle_shape = &log_.shapes.back();
    }
    if (memories_) {
      log_.memories.push_back(log_.final_state.effects);
      image.memory = &log_.memories.back();
    }
  }

  const simulation::Simulation& simulation_;
  StepLog& log_;
  bool loads_;
  bool shapes_;
  bool memories_;
  bool forces_;
  std::span<simulation::Snapshot> images_;
  tissue::TissueLoad load_;
  math::Polyline shape_;
};

void KeepPassed(StepLog& log) {
  const forces::PassedEvents& passed = log.final_state.passed;
  for (int i = 0; i < passed.num; ++i) {
    log.passed.push_back({log.steps.size() - 1, passed.event[static_cast<std::size_t>(i)]});
  }
}

/// Keeps the needle's shape at its largest deflection.
void KeepMostBent(const simulation::Simulation& simulation, StepLog& log) {
  const simulation::NeedleShape& shape = log.steps.back().shape;
  const double most_mm =
      log.most_bent.empty() ? 0.0 : log.steps[log.most_bent_step].shape.tip_deflection_mm;
  if (!shape.bent || shape.tip_deflection_mm <= most_mm) return;
  simulation.ShapeOf(log.final_state, log.most_bent);
  log.most_bent_step = log.steps.size() - 1;
}

template <typename Append>
void WriteRows(const std::filesystem::path& path, const std::string& header, const StepLog& log,
               const Append& append) {
  std::ofstream out(path, std::ios::binary);
  out << header << '\n';
  std::string row;
  for (const simulation::StepOutput& step : log.steps) {
    row.clear();
    append(row, step);
    out << row;
  }
  out.close();
  ACUS_REQUIRE(out, path.string(), ": cannot be written; is the disk full?");
}

}  // namespace

breathing::Breath BreathOf(const session::Session& session, std::int64_t time_ns) {
  if (session.breath.empty()) return {};
  return step::BreathOf(session::BreathAt(session.breath, time_ns));
}

StepLog RunSteps(const simulation::Scene& scene, const session::Session& session,
                 std::span<simulation::Snapshot> images, simulation::StageTimes* times,
                 const RunContext& context, std::vector<double>* step_cpu_s) {
  StepLog log;
  const step::StepInputs inputs(
      scene, {.needle = !session.needle.empty(), .probe = !session.probe.empty()});
  if (!inputs.steps()) return log;
  const simulation::Simulation simulation(scene);
  log.final_state = simulation.NewState(session.start_ns());
  ImageStates states(scene, simulation, images, log);
  // The needle's samples come at the rate of forces. If no stage reads it, the probe's are used.
  const bool by_needle = inputs.reads_needle() || session.probe.empty();
  const session::PoseStream& clock = by_needle ? session.needle : session.probe;
  const std::size_t count = clock.size();
  log.steps.reserve(count);
  const std::size_t piece = count / 50 + 1;
  step::PlungerForce plunger(session.commands);
  const double begin_s = ThreadCpuSeconds();
  for (std::size_t i = 0; i < count; ++i) {
    if (i % piece == 0) {
      context.Checkpoint("forces", static_cast<double>(i) / static_cast<double>(count));
    }
    const std::int64_t time_ns = clock[i].time_ns;
    const bool between = inputs.reads_probe() && by_needle;  // The probe has other sample times.
    const simulation::Sample sample = inputs.SampleAt(
        time_ns, clock[i], between ? session::PoseAt(session.probe, time_ns) : clock[i],
        BreathOf(session, time_ns), plunger.At(time_ns));
    states.GiveBefore(sample.time_ns);
    const double step_begin_s = step_cpu_s != nullptr ? ThreadCpuSeconds() : 0.0;
    log.steps.push_back(simulation.Step(log.final_state, sample, times));
    if (step_cpu_s != nullptr) step_cpu_s->push_back(ThreadCpuSeconds() - step_begin_s);
    KeepPassed(log);
    KeepMostBent(simulation, log);
  }
  states.GiveBefore(std::numeric_limits<std::int64_t>::max());
  log.cpu_s = ThreadCpuSeconds() - begin_s;
  return log;
}

const simulation::StepOutput* StepAt(const StepLog& log, std::int64_t time_ns) {
  const auto after =
      std::ranges::upper_bound(log.steps, time_ns, {}, &simulation::StepOutput::time_ns);
  return after == log.steps.begin() ? nullptr : &*(after - 1);
}

std::string EventWords(std::string_view name) {
  std::string words(name);
  std::ranges::replace(words, '_', ' ');
  return words;
}

void WriteForces(const std::filesystem::path& path, const StepLog& log,
                 const simulation::Scene& scene) {
  WriteRows(path, ForceHeader(scene), log,
            [&scene](std::string& row, const auto& step) { AppendForceRow(row, step, scene); });
}

void WriteListedEffects(const std::filesystem::path& folder, const StepLog& log,
                        const simulation::Scene& scene) {
  for (const simulation::ListedEffect& other : scene.listed.all()) {
    if (other.columns.empty()) continue;
    WriteRows(folder / Message(other.key, ".csv"), EffectHeader(other), log,
              [&other](std::string& row, const auto& step) { AppendEffectRow(row, step, other); });
  }
}

void WriteProbeForces(const std::filesystem::path& path, const StepLog& log,
                      const simulation::Scene& scene) {
  WriteRows(path, ProbeForceHeader(), log, [&scene](std::string& row, const auto& step) {
    AppendProbeForceRow(row, step, scene);
  });
}

}  // namespace acus::replay
