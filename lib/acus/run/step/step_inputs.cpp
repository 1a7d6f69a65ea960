#include "acus/run/step/step_inputs.h"

namespace acus::step {

namespace ports = effects::ports;

breathing::Breath BreathOf(const session::BreathSample& sample) noexcept {
  return {.cycle = sample.cycle, .level = sample.level, .level_per_s = sample.level_per_s};
}

double PlungerForce::At(std::int64_t time_ns) noexcept {
  for (; next_ < commands_.size() && commands_[next_].time_ns <= time_ns; ++next_) {
    if (commands_[next_].kind == session::CommandKind::kPlunger) force_n_ = commands_[next_].value;
  }
  return force_n_;
}

StepInputs::StepInputs(const simulation::Scene& scene, const Tools& there)
    : reads_{.needle = there.needle && scene.plan.StepReads(ports::kNeedlePoses),
             .probe = there.probe && scene.plan.StepReads(ports::kProbePoses)},
      steps_(reads_.needle || reads_.probe || scene.listed.has_steps()) {}

simulation::Sample StepInputs::SampleAt(std::int64_t time_ns, const session::PoseSample& needle,
                                        const session::PoseSample& probe,
                                        const breathing::Breath& breath,
                                        double plunger_n) const noexcept {
  simulation::Sample sample;
  sample.time_ns = time_ns;
  sample.breath = breath;
  sample.plunger_n = plunger_n;
  if (reads_.needle) {
    sample.reference_from_needle = needle.reference_from_tool;
    sample.needle_valid = needle.valid;
  }
  if (reads_.probe) {
    sample.reference_from_probe = probe.reference_from_tool;
    sample.probe_valid = probe.valid;
  }
  return sample;
}

}  // namespace acus::step
