#include "acus/scene/simulation/simulation.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "acus/scene/simulation/coupled/coupled_effect.h"

namespace acus::simulation {

Simulation::Simulation(const Scene& scene)
    : scene_(scene), tools_(scene), runs_contact_(scene.plan.Writes(effects::ports::kContact)) {
  for (const PlannedStage& stage : scene.plan.stages()) {
    if (!stage.in) continue;
    for (const CoupledEffect* effect : CoupledEffects()) {
      if (effect->key() != stage.owner) continue;
      if (auto work = effect->NewStage(stage.writes.front(), scene)) {
        stages_.push_back({stage.number, std::move(work)});
      }
    }
  }
}

State Simulation::NewState(std::int64_t session_start_ns) const {
  State state;
  state.session_start_ns = session_start_ns;
  for (const Stage& stage : stages_) stage.work->Begin(state);
  scene_.listed.Begin(state.effects);
  return state;
}

StepOutput Simulation::Step(State& state, const Sample& sample, StageTimes* times) const noexcept {
  auto watch = Stopwatch::OfStep(times, state.steps);
  ++state.steps;
  state.passed.Clear();
  StepOutput out;
  out.time_ns = sample.time_ns;
  state.needle_seen |= sample.needle_valid;
  const effects::StepTime effect_time{
      sample.time_ns, 1e-9 * static_cast<double>(sample.time_ns - state.session_start_ns)};
  std::optional<effects::PortValues> ports;  // What one stage of an effect writes, later ones read.
  if (scene_.listed.has_steps()) {
    ports.emplace(scene_.listed.data());
    ports->Set(effects::ports::kPlungerForce, &sample.plunger_n);
    scene_.listed.Step(false, state.effects, effect_time, *ports, out.effect, watch);
  }
  const ToolsAtRest tools = tools_.Lay(state, sample);
  StepFrame frame{.sample = sample, .tools = tools, .state = state, .out = out};
  for (const Stage& stage : stages_) watch.EndOf(stage.number, stage.work->Step(frame));
  tools_.CarryForces(tools, out);
  if (ports) {
    ports->Set(effects::ports::kNeedle, &out.needle_at_rest);
    ports->Set(effects::ports::kTissue, &out.tissue_at_tip);
    ports->Set(effects::ports::kForce, &out.force);
    ports->Set(effects::ports::kProbeForce, &out.probe);
    scene_.listed.Step(true, state.effects, effect_time, *ports, out.effect, watch);
    if (scene_.listed.adds_force()) {
      out.added_in_ct_n = scene_.listed.AddedForceInCtN(state.effects);
      out.force.force_in_ct_n += out.added_in_ct_n;
      // A tracker may give a direction that is no number.
      const double along_n = out.added_in_ct_n.dot(out.ct_from_needle.linear().col(2));
      out.force.added_n = std::isfinite(along_n) ? -along_n : 0.0;
    }
  }
  return out;
}

bool Simulation::ShapeOf(const State& state, math::Polyline& out) const noexcept {
  if (!scene_.shape || !scene_.shape->ShapeOf(state.shape, out)) return false;
  if (scene_.listed.moves_tissue()) {
    for (int n = 0; n < out.num_points; ++n) {
      out.point_mm[static_cast<std::size_t>(n)] += state.needle_moved_mm;
    }
  }
  const breathing::ToolTrack& track = state.needle_track;
  if (!track.started) return true;
  for (int n = 0; n < out.num_points; ++n) {
    Eigen::Vector3d& point_mm = out.point_mm[static_cast<std::size_t>(n)];
    point_mm = track.world_mm + track.world_from_rest * (point_mm - track.rest_mm);
  }
  return true;
}

bool Simulation::LoadOf(const State& state, const StepOutput& output,
                        tissue::TissueLoad& out) const noexcept {
  if (runs_contact_) return scene_.tissue->LoadOf(state.tissue, out);
  const forces::NeedleTrack& needle = forces::TrackOf(state.force);
  if (!needle.in_body) return false;
  out = {};
  out.needle = {.in_contact = true,
                .pierced = needle.pierced,
                .entry_in_ct_mm = needle.path.entry_in_ct_mm,
                .tip_in_ct_mm = output.needle_at_rest.ct_from_tool.translation(),
                .axis_in_ct = needle.path.direction_in_ct,
                .pre_puncture_n = std::max(0.0, output.force.puncture_n),
                .cutting_n = std::max(0.0, output.force.cutting_n),
                .friction_n = output.force.friction_n};
  return true;
}

}  // namespace acus::simulation
