#include "acus/scene/simulation/simulation.h"

#include <algorithm>

namespace acus::simulation {
namespace {

/// Why there is nothing to do for a needle that is in no tissue.
Sleep Outside(Sleep unseen) {
  return unseen == Sleep::kAwake ? Sleep::kNeedleOutside : unseen;
}

}  // namespace

Simulation::Simulation(const Scene& scene)
    : scene_(scene),
      runs_needle_(scene.plan.Has(StageId::kNeedlePose)),
      runs_contact_(scene.plan.Has(StageId::kTissueContact)),
      runs_force_(scene.plan.Has(StageId::kNeedleForce)),
      runs_probe_(scene.plan.Has(StageId::kProbeForce)) {
  if (scene.plan.Has(StageId::kTissueLookup)) {
    lookup_ = scene.labels ? forces::TissueLookup(*scene.labels)
                           : forces::TissueLookup(*scene.hu, *scene.hu_tissues);
  }
  if (scene.force_from_tissue) {
    largest_needle_n_ = scene.tissue->LargestForceN();
  } else if (scene.forces) {
    largest_needle_n_ = scene.forces->table().settings.largest_force_n;
  }
  if (scene.probe_force) largest_probe_n_ = scene.probe_force->LargestForceN();
  if (scene.probe_force_from_tissue) largest_probe_n_ = scene.tissue->LargestForceN();
}

State Simulation::NewState(std::int64_t session_start_ns) const {
  State state;
  state.session_start_ns = session_start_ns;
  if (runs_contact_) state.tissue = scene_.tissue->NewState();
  if (scene_.forces) state.force = scene_.forces->NewState();
  if (scene_.shape) state.shape = scene_.shape->NewState();
  if (scene_.probe_force) state.probe = scene_.probe_force->NewState();
  scene_.listed.Begin(state.effects);
  return state;
}

StepOutput Simulation::Step(State& state, const Sample& sample, StageTimes* times) const noexcept {
  auto watch = Stopwatch::OfStep(times, state.steps);
  ++state.steps;
  state.passed.Clear();
  StepOutput out;
  out.time_ns = sample.time_ns;
  const double time_s = 1e-9 * static_cast<double>(sample.time_ns);
  state.needle_seen |= sample.needle_valid;
  const effects::StepTime effect_time{
      sample.time_ns, 1e-9 * static_cast<double>(sample.time_ns - state.session_start_ns)};
  std::optional<effects::PortValues> ports;  // What one stage of an effect writes, later ones read.
  if (scene_.listed.has_steps()) {
    ports.emplace(scene_.listed.data());
    scene_.listed.Step(false, state.effects, effect_time, *ports, out.effect, watch);
  }
  const Tools tools = ToolsOf(state, sample);
  if (scene_.breathing) {
    watch.EndOf(StageId::kBreathing, tools.tissue_moves ? Sleep::kAwake : Sleep::kAtRest);
  }
  const Sleep unseen = state.needle_seen ? Sleep::kAwake : Sleep::kNeedleUnseen;
  if (runs_needle_) {
    if (state.needle_seen) {
      out.ct_from_needle = scene_.ct_from_reference * sample.reference_from_needle;
    }
    out.needle_at_rest = tools.needle;
    watch.EndOf(StageId::kNeedlePose, unseen);
  }
  const Eigen::Vector3d tip_in_ct_mm = tools.needle.ct_from_tool.translation();
  const Eigen::Vector3d axis_in_ct = tools.needle.ct_from_tool.linear().col(2);
  if (lookup_) {
    // A bent needle's tip is where it was bent to in the step before.
    if (state.needle_seen) {
      out.tissue_at_tip = lookup_->At(
          scene_.shape ? Eigen::Vector3d(tip_in_ct_mm + state.shape.tip_offset_mm) : tip_in_ct_mm);
    }
    watch.EndOf(StageId::kTissueLookup, unseen);
  }
  if (runs_contact_) {
    out.tissue = scene_.tissue->Step(
        state.tissue,
        {.time_s = time_s,
         .needle_valid = sample.needle_valid,
         .tip_in_ct_mm = tip_in_ct_mm,
         .axis_in_ct =
             scene_.shape ? scene_.shape->LockedAxis(state.shape, axis_in_ct) : axis_in_ct,
         .tip_direction_in_ct = state.shape.tip_direction_in_ct,
         .probe_valid = sample.probe_valid,
         .ct_from_probe = PressedProbe(tools, scene_.probe_force_from_tissue)});
    watch.EndOf(StageId::kTissueContact, out.tissue.touched ? Sleep::kAwake : Sleep::kUntouched);
  }
  if (runs_force_ && scene_.force_from_tissue) {
    out.force = out.tissue.needle;
    out.tissue_at_tip = out.tissue.tissue_at_tip;
    watch.EndOf(StageId::kNeedleForce, out.tissue.touched ? Sleep::kAwake : Sleep::kUntouched);
  } else if (runs_force_) {
    // Nothing to do while the needle is in free space; the law itself then returns at once.
    const bool outside = out.tissue_at_tip == 0 && !forces::TrackOf(state.force).in_body;
    forces::SweptTissue swept{.lookup = lookup_ ? &*lookup_ : nullptr};
    if (scene_.shape) swept.tip_offset_mm = state.shape.tip_offset_mm;
    out.force = scene_.forces->StepAlong(state.force,
                                         {.time_s = time_s,
                                          .tip_in_ct_mm = tip_in_ct_mm,
                                          .axis_in_ct = axis_in_ct,
                                          .tissue_at_tip = out.tissue_at_tip,
                                          .valid = sample.needle_valid},
                                         swept, state.passed);
    watch.EndOf(StageId::kNeedleForce, outside ? Outside(unseen) : Sleep::kAwake);
  }
  if (scene_.shape) {
    ShapeNeedle(state, sample, tools, out);
    watch.EndOf(StageId::kNeedleShape,
                scene_.shape->IsAsleep(state.shape) ? Outside(unseen) : Sleep::kAwake);
  }
  if (runs_probe_) {
    if (scene_.probe_force_from_tissue) {
      out.probe = FeltFromTissue(out.tissue);
    } else {
      out.probe = scene_.probe_force->Step(state.probe, {.time_s = time_s,
                                                         .ct_from_probe = PressedProbe(tools, true),
                                                         .valid = sample.probe_valid});
    }
    const Sleep off = sample.probe_valid ? Sleep::kProbeOffSkin : Sleep::kProbeUnseen;
    watch.EndOf(StageId::kProbeForce, out.probe.on_skin ? Sleep::kAwake : off);
  }
  if (tools.tissue_moves || scene_.listed.moves_tissue()) CarryForces(tools, out);
  if (ports) {
    ports->Set(effects::ports::kNeedle, &out.needle_at_rest);
    ports->Set(effects::ports::kTissue, &out.tissue_at_tip);
    ports->Set(effects::ports::kForce, &out.force);
    ports->Set(effects::ports::kProbeForce, &out.probe);
    scene_.listed.Step(true, state.effects, effect_time, *ports, out.effect, watch);
  }
  return out;
}

/// @param pressed  deeper than recorded, as the probe's force asks for.
Eigen::Isometry3d Simulation::PressedProbe(const Tools& tools, bool pressed) const noexcept {
  if (!pressed) return tools.probe.ct_from_tool;
  return tools.probe.ct_from_tool * Eigen::Translation3d(0.0, scene_.probe_press_mm, 0.0);
}

forces::ProbeForce Simulation::FeltFromTissue(const tissue::TissueForce& tissue) const noexcept {
  forces::ProbeForce felt{.force_in_ct_n = tissue.probe_in_ct_n,
                          .on_skin = tissue.num_probe_nodes > 0,
                          .skin_mm = tissue.probe_depth_mm,
                          .torque_in_ct_n_mm = tissue.probe_torque_in_ct_n_mm,
                          .num_on_skin = tissue.num_probe_nodes};
  const double size_n = felt.force_in_ct_n.norm();
  if (size_n > largest_probe_n_) {
    felt.force_in_ct_n *= largest_probe_n_ / size_n;
    felt.torque_in_ct_n_mm *= largest_probe_n_ / size_n;
  }
  return felt;
}

Simulation::Tools Simulation::ToolsOf(State& state, const Sample& sample) const noexcept {
  Tools tools;
  if (state.needle_seen) {
    tools.needle.ct_from_tool = scene_.ct_from_reference * sample.reference_from_needle;
  }
  tools.probe.ct_from_tool = scene_.ct_from_reference * sample.reference_from_probe;
  if (scene_.breathing) LayAtRest(state, sample, tools);
  if (!scene_.listed.moves_tissue()) return tools;
  const auto lay = [&](breathing::ToolAtRest& tool, Eigen::Matrix3d& per_moved) {
    const Eigen::Vector3d place_mm = tool.ct_from_tool.translation();
    const auto rest_of = [&](const Eigen::Vector3d& mm) {
      return scene_.listed.RestInCtMm(state.effects, mm);
    };
    tool.ct_from_tool.translation() = rest_of(place_mm);
    const Eigen::Vector3d moved_mm = place_mm - tool.ct_from_tool.translation();
    if (moved_mm.isZero(0.0) || !moved_mm.allFinite()) return moved_mm;
    constexpr double kHalfMm = 0.25;
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::Vector3d step = kHalfMm * Eigen::Vector3d::Unit(axis);
      per_moved.col(axis) = (rest_of(place_mm + step) - rest_of(place_mm - step)) / (2.0 * kHalfMm);
    }
    const double norm = per_moved.norm();
    if (norm > breathing::ToolAtRest::kMostPerWorld) {
      per_moved *= breathing::ToolAtRest::kMostPerWorld / norm;
    }
    return moved_mm;
  };
  if (runs_needle_ && state.needle_seen) {
    const Eigen::Vector3d moved_mm = lay(tools.needle, tools.needle_per_moved);
    // The shape stays where it was while poses are no numbers.
    if (moved_mm.allFinite()) state.needle_moved_mm = moved_mm;
  }
  if (sample.probe_valid && (runs_probe_ || runs_contact_)) lay(tools.probe, tools.probe_per_moved);
  return tools;
}

void Simulation::LayAtRest(State& state, const Sample& sample, Tools& tools) const noexcept {
  const breathing::MotionMap& patient = tools.patient.emplace(scene_.breathing->At(
      1e-9 * static_cast<double>(sample.time_ns - state.session_start_ns), sample.breath));
  tools.tissue_moves = patient.moves();
  if (runs_needle_ && state.needle_seen) {
    tools.needle = breathing::AtRest(patient, tools.needle.ct_from_tool, Eigen::Vector3d::UnitZ(),
                                     state.needle_track);
  }
  if (sample.probe_valid && (runs_probe_ || runs_contact_)) {
    tools.probe = breathing::AtRest(patient, tools.probe.ct_from_tool, Eigen::Vector3d::UnitY(),
                                    state.probe_track);
  }
}

/// From the tissue at rest to the patient, by the same work: what effects of the list moved, then
/// breath. No larger than the models' own limits.
void Simulation::CarryForces(const Tools& tools, StepOutput& out) const noexcept {
  if (scene_.listed.moves_tissue()) {
    out.force.force_in_ct_n = tools.needle_per_moved.transpose() * out.force.force_in_ct_n;
    out.probe.force_in_ct_n = tools.probe_per_moved.transpose() * out.probe.force_in_ct_n;
  }
  if (tools.tissue_moves) {
    breathing::CarryToWorld(*tools.patient, tools.needle, out.force.force_in_ct_n,
                            out.force.torque_in_ct_n_mm);
    breathing::CarryToWorld(*tools.patient, tools.probe, out.probe.force_in_ct_n,
                            out.probe.torque_in_ct_n_mm);
  }
  const auto limit = [](Eigen::Vector3d& force_n, Eigen::Vector3d& torque_n_mm, double most_n) {
    const double size_n = force_n.norm();
    if (!(size_n > most_n)) return;
    force_n *= most_n / size_n;
    torque_n_mm *= most_n / size_n;
  };
  limit(out.force.force_in_ct_n, out.force.torque_in_ct_n_mm, largest_needle_n_);
  limit(out.probe.force_in_ct_n, out.probe.torque_in_ct_n_mm, largest_probe_n_);
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

namespace {

/// Breath, as a needle that is drawn as at rest sees it: what its tip does is taken off.
class BreathOnPath : public needle::PathMotion {
 public:
  BreathOnPath(const breathing::MotionMap& patient, const breathing::ToolTrack& track)
      : patient_(patient), track_(track) {}
  Eigen::Vector3d NowMm(const Eigen::Vector3d& rest_mm) const noexcept override {
    return track_.rest_mm +
           track_.world_from_rest.conjugate() * (patient_.WorldMm(rest_mm) - track_.world_mm);
  }

 private:
  const breathing::MotionMap& patient_;
  const breathing::ToolTrack& track_;
};

}  // namespace

void Simulation::ShapeNeedle(State& state, const Sample& sample, const Tools& tools,
                             StepOutput& out) const noexcept {
  NeedleShapeInput input{.time_s = 1e-9 * static_cast<double>(sample.time_ns),
                         .valid = sample.needle_valid,
                         .ct_from_needle = out.needle_at_rest.ct_from_tool,
                         .tissue_at_tip = out.tissue_at_tip,
                         .pierced = out.tissue.pierced};
  PathLine path;
  if (!scene_.force_from_tissue) {
    const forces::NeedleTrack& track = forces::TrackOf(state.force);
    path = {track.in_body && track.pierced, track.path.entry_in_ct_mm, track.path.direction_in_ct};
    input.path = &path;
  }
  std::optional<BreathOnPath> motion;
  if (tools.tissue_moves && state.needle_track.started) {
    input.motion = &motion.emplace(*tools.patient, state.needle_track);
  }
  scene_.shape->Step(state.shape, input, out.force);
  out.shape = state.shape.shape;
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
