#include "acus/run/live/image_follower.h"

#include <cmath>

namespace acus::live {
namespace {

using simulation::StageId;

breathing::Breath BreathOf(const session::BreathSample& sample) {
  return {.cycle = sample.cycle, .level = sample.level, .level_per_s = sample.level_per_s};
}

double RateOf(double scene_hz, double least_hz) {
  return scene_hz * std::max(1.0, std::ceil(least_hz / scene_hz));
}

}  // namespace

ImageFollower::ImageFollower(const simulation::Scene& scene, bool has_needle, bool has_probe,
                             double least_rate_hz)
    : scene_(scene),
      simulation_(scene),
      has_probe_(has_probe),
      rate_hz_(RateOf(scene.image_rate_hz, least_rate_hz)) {
  // As LiveCore and acus-replay decide.
  steps_needle_ = has_needle && scene.plan.Has(StageId::kNeedlePose);
  const bool feels_probe = scene.plan.Has(StageId::kProbeForce);
  steps_probe_ = has_probe && (feels_probe || scene.plan.Has(StageId::kTissueContact));
  steps_ = steps_needle_ || feels_probe || scene.listed.has_steps();
}

std::int64_t ImageFollower::MomentNs(std::int64_t number) const {
  return first_ns_ + std::llround(1e9 * static_cast<double>(number) / rate_hz_);
}

void ImageFollower::Step(const StepInput& input) {
  if (!last_) {
    first_ns_ = input.time_ns;
    state_ = simulation_.NewState(first_ns_);
  } else {
    while (MomentNs(next_moment_ + 1) < input.time_ns) {
      ++next_moment_;
      ++passed_over_;
    }
    if (const std::int64_t moment_ns = MomentNs(next_moment_); moment_ns < input.time_ns) {
      ShowMoment(moment_ns, input);
      ++next_moment_;
    }
  }
  last_ = input;
  if (!steps_) return;
  simulation::Sample sample;
  sample.time_ns = input.time_ns;
  if (scene_.plan.breath_from_session()) sample.breath = BreathOf(input.breath);
  if (steps_needle_) {
    sample.reference_from_needle = input.needle.reference_from_tool;
    sample.needle_valid = input.needle.valid;
  }
  if (steps_probe_) {
    sample.reference_from_probe = input.probe.reference_from_tool;
    sample.probe_valid = input.probe.valid;
  }
  output_ = simulation_.Step(state_, sample);
}

void ImageFollower::ShowMoment(std::int64_t time_ns, const StepInput& next) {
  if (is_waiting_) ++passed_over_;
  is_waiting_ = true;
  LiveSnapshot& out = moment_;
  out.moment = {};
  out.moment.time_ns = time_ns;
  out.moment.session_s = 1e-9 * static_cast<double>(time_ns - first_ns_);
  if (scene_.plan.breath_from_session()) {
    out.moment.breath = BreathOf(session::BreathAt({last_->breath, next.breath}, time_ns));
  }
  if (has_probe_) {
    const session::PoseSample probe = session::PoseAt({last_->probe, next.probe}, time_ns);
    out.moment.probe_valid = probe.valid;
    out.moment.ct_from_probe = scene_.ct_from_reference * probe.reference_from_tool;
  } else {
    out.moment.ct_from_probe = scene_.ct_from_reference;
  }
  if (steps_needle_) {
    const session::PoseSample needle = session::PoseAt({last_->needle, next.needle}, time_ns);
    if (needle.valid) {
      out.moment.ct_from_needle = scene_.ct_from_reference * needle.reference_from_tool;
    }
  }
  out.moment.needle_force_in_ct_n = output_.force.force_in_ct_n;
  out.has_shape = scene_.plan.Has(StageId::kNeedleShape) && simulation_.ShapeOf(state_, out.shape);
  out.has_load = scene_.tools_deform_images && simulation_.LoadOf(state_, output_, out.load);
  out.has_memory = scene_.listed.has_steps();
  if (out.has_memory) out.memory = state_.effects;
  out.gain_db = last_->gain_db;
  out.depth_mm = last_->depth_mm;
}

const LiveSnapshot* ImageFollower::TakeMoment() {
  if (!is_waiting_) return nullptr;
  is_waiting_ = false;
  return &moment_;
}

}  // namespace acus::live
