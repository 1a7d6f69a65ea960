#include "acus/run/live/image_follower.h"

#include <cmath>

namespace acus::live {
namespace {

double RateOf(double scene_hz, double least_hz) {
  return scene_hz * std::max(1.0, std::ceil(least_hz / scene_hz));
}

}  // namespace

ImageFollower::ImageFollower(const simulation::Scene& scene, bool has_needle, bool has_probe,
                             double least_rate_hz)
    : scene_(scene),
      simulation_(scene),
      inputs_(scene, {.needle = has_needle, .probe = has_probe}),
      has_probe_(has_probe),
      rate_hz_(RateOf(scene.image_rate_hz, least_rate_hz)) {}

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
  if (!inputs_.steps()) return;
  const bool from_session = scene_.plan.breath_from_session();
  output_ = simulation_.Step(
      state_, inputs_.SampleAt(input.time_ns, input.needle, input.probe,
                               from_session ? step::BreathOf(input.breath) : breathing::Breath{},
                               input.plunger_n));
}

void ImageFollower::ShowMoment(std::int64_t time_ns, const StepInput& next) {
  if (is_waiting_) ++passed_over_;
  is_waiting_ = true;
  LiveSnapshot& out = moment_;
  out.moment = {};
  out.moment.time_ns = time_ns;
  out.moment.session_s = 1e-9 * static_cast<double>(time_ns - first_ns_);
  if (scene_.plan.breath_from_session()) {
    out.moment.breath = step::BreathOf(session::BreathAt({last_->breath, next.breath}, time_ns));
  }
  if (has_probe_) {
    const session::PoseSample probe = session::PoseAt({last_->probe, next.probe}, time_ns);
    out.moment.probe_valid = probe.valid;
    out.moment.ct_from_probe = scene_.ct_from_reference * probe.reference_from_tool;
  } else {
    out.moment.ct_from_probe = scene_.ct_from_reference;
  }
  if (inputs_.reads_needle()) {
    const session::PoseSample needle = session::PoseAt({last_->needle, next.needle}, time_ns);
    if (needle.valid) {
      out.moment.ct_from_needle = scene_.ct_from_reference * needle.reference_from_tool;
    }
  }
  out.moment.needle_force_in_ct_n = output_.force.force_in_ct_n;
  out.has_shape =
      scene_.plan.Writes(effects::ports::kShape) && simulation_.ShapeOf(state_, out.shape);
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
