#include "acus/scene/simulation/breathing_scene.h"

#include <algorithm>

namespace acus::simulation {
namespace {

breathing::BreathSource::Signal SignalOf(const scenario::BreathingEffect& effect,
                                         const breathing::PatientMotion& motion,
                                         RunContext& context) {
  if (effect.signal.empty()) {
    breathing::PatternSettings pattern = effect.pattern;
    if (pattern.period_s == 0.0) pattern.period_s = motion.period_s;
    return breathing::BreathingPattern(pattern);
  }
  context.provenance.AddInput(effect.signal);
  return breathing::RecordedBreath(breathing::ReadBreathSignal(effect.signal, effect.signal_file),
                                   effect.recorded);
}

}  // namespace

breathing::MotionMap Breathing::At(double session_s,
                                   const breathing::Breath& of_session) const noexcept {
  if (amplitude == 0.0) return {motion.model.field(), {}};  // Independent of the breath.
  breathing::Breath breath = from_session ? of_session : source.At(session_s);
  const auto* recorded =
      from_session ? nullptr : std::get_if<breathing::RecordedBreath>(&source.signal());
  if (recorded != nullptr && normalise) breath = recorded->Normalised(breath);
  if (recorded == nullptr || normalise) breath = motion.InTermsOfSignal(breath);
  return {motion.model.field(), motion.model.WeightsAt(breath, amplitude)};
}

breathing::Breath Breathing::NormalAt(double session_s) const noexcept {
  const breathing::Breath breath = source.At(session_s);
  const auto* recorded = std::get_if<breathing::RecordedBreath>(&source.signal());
  if (recorded == nullptr) return breath;
  return normalise ? recorded->Normalised(breath) : motion.Normal(breath);
}

Breathing LoadBreathing(const scenario::Scenario& scenario, bool from_session,
                        RunContext& context) {
  const scenario::BreathingEffect& effect = *scenario.breathing;
  breathing::PatientMotion motion = breathing::ReadPatientMotion(effect.motion);
  context.provenance.AddInput(effect.motion);
  breathing::BreathSource::Signal signal = breathing::BreathingPattern({});
  if (!from_session) signal = SignalOf(effect, motion, context);
  return {
      .motion = std::move(motion),
      .source = breathing::BreathSource(
          std::move(signal), from_session ? std::vector<breathing::BreathHold>() : effect.holds),
      .amplitude = effect.amplitude,
      .normalise = effect.normalise,
      .image = effect.image,
      .warp_spacing_mm = effect.warp_spacing_mm,
      .inverse_iterations = effect.inverse_iterations,
      .adds_motion = effect.adds_motion,
      .from_session = from_session};
}

Eigen::Vector3d BreathingRest::RestInCtMm(const Eigen::Vector3d& place_in_ct_mm,
                                          const Eigen::Vector3d& guess_in_ct_mm) const noexcept {
  const math::InverseSettings settings{.max_iterations = iterations_, .tolerance_mm = 0.02};
  const Eigen::Vector3d rest_mm = map_.RestOf(place_in_ct_mm, guess_in_ct_mm, settings).rest_mm;
  return deformed_ == nullptr ? rest_mm : deformed_->RestInCtMm(rest_mm, rest_mm);
}

double BreathingRest::SpacingMm() const noexcept {
  return deformed_ == nullptr ? spacing_mm_ : std::min(spacing_mm_, deformed_->SpacingMm());
}

}  // namespace acus::simulation
