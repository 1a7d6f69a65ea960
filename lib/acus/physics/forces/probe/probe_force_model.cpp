#include "acus/physics/forces/probe/probe_force_model.h"

namespace acus::forces {

const SampleGate& GateOf(const ProbeForceState& state) noexcept {
  return std::visit([](const auto& gate) -> const SampleGate& { return gate; }, state);
}

ProbeForceState ProbeForceModel::NewState() const {
  if (std::holds_alternative<MultiProxyProbe>(model_)) return MultiProxyState();
  return VidalProbeState();
}

ProbeForce ProbeForceModel::Step(ProbeForceState& state, const ProbeInput& input) const noexcept {
  if (const auto* vidal = std::get_if<VidalProbe>(&model_)) {
    return vidal->Step(*std::get_if<VidalProbeState>(&state), input);
  }
  return std::get_if<MultiProxyProbe>(&model_)->Step(*std::get_if<MultiProxyState>(&state), input);
}

double ProbeForceModel::LargestForceN() const noexcept {
  return std::visit([](const auto& model) { return model.largest_force_n(); }, model_);
}

}  // namespace acus::forces
