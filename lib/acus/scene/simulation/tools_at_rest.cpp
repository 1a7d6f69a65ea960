#include "acus/scene/simulation/tools_at_rest.h"

namespace acus::simulation {

Eigen::Isometry3d PressedProbe(const ToolsAtRest& tools, double press_mm) noexcept {
  return tools.probe.ct_from_tool * Eigen::Translation3d(0.0, press_mm, 0.0);
}

ToolMotion::ToolMotion(const Scene& scene)
    : scene_(scene),
      has_needle_(scene.plan.StepReads(effects::ports::kNeedlePoses)),
      has_probe_(scene.plan.StepReads(effects::ports::kProbePoses)) {
  if (scene.force_from_tissue) {
    largest_needle_n_ = scene.tissue->LargestForceN();
  } else if (scene.forces) {
    largest_needle_n_ = scene.forces->table().settings.largest_force_n;
  }
  if (scene.probe_force) largest_probe_n_ = scene.probe_force->LargestForceN();
  if (scene.probe_force_from_tissue) largest_probe_n_ = scene.tissue->LargestForceN();
}

ToolsAtRest ToolMotion::Lay(State& state, const Sample& sample) const noexcept {
  ToolsAtRest tools;
  if (state.needle_seen) {
    tools.needle.ct_from_tool = scene_.ct_from_reference * sample.reference_from_needle;
  }
  tools.probe.ct_from_tool = scene_.ct_from_reference * sample.reference_from_probe;
  if (scene_.breathing) LayInBreath(state, sample, tools);
  if (!scene_.listed.moves_tissue()) return tools;
  if (has_needle_ && state.needle_seen) {
    const Eigen::Vector3d moved_mm = LayInEffects(state, tools.needle, tools.needle_per_moved);
    // The shape keeps its position while poses are not finite.
    if (moved_mm.allFinite()) state.needle_moved_mm = moved_mm;
  }
  if (sample.probe_valid && has_probe_) LayInEffects(state, tools.probe, tools.probe_per_moved);
  return tools;
}

void ToolMotion::LayInBreath(State& state, const Sample& sample,
                             ToolsAtRest& tools) const noexcept {
  const breathing::MotionMap& patient = tools.patient.emplace(scene_.breathing->At(
      1e-9 * static_cast<double>(sample.time_ns - state.session_start_ns), sample.breath));
  tools.tissue_moves = patient.moves();
  if (has_needle_ && state.needle_seen) {
    tools.needle = breathing::AtRest(patient, tools.needle.ct_from_tool, Eigen::Vector3d::UnitZ(),
                                     state.needle_track, scene_.breathing->adds_motion);
  }
  if (sample.probe_valid && has_probe_) {
    tools.probe = breathing::AtRest(patient, tools.probe.ct_from_tool, Eigen::Vector3d::UnitY(),
                                    state.probe_track, scene_.breathing->adds_motion);
  }
}

/// @return  the displacement of the tissue at the tool's tip by the effects.
Eigen::Vector3d ToolMotion::LayInEffects(const State& state, breathing::ToolAtRest& tool,
                                         Eigen::Matrix3d& per_moved) const noexcept {
  const auto rest_of = [&](const Eigen::Vector3d& mm) {
    return scene_.listed.RestInCtMm(state.effects, mm);
  };
  const Eigen::Vector3d place_mm = tool.ct_from_tool.translation();
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
}

void ToolMotion::CarryForces(const ToolsAtRest& tools, StepOutput& out) const noexcept {
  if (!tools.tissue_moves && !scene_.listed.moves_tissue()) return;
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

}  // namespace acus::simulation
