// The force on a probe by any of the models, chosen by the scene.
#pragma once

#include <variant>

#include "acus/physics/forces/probe/multi_proxy_probe.h"
#include "acus/physics/forces/probe/vidal_probe.h"

namespace acus::forces {

/// All that a model remembers. A plain value: copy it to save, assign it to restore.
using ProbeForceState = std::variant<VidalProbeState, MultiProxyState>;

/// What all states share: what was wrong with samples.
const SampleGate& GateOf(const ProbeForceState& state) noexcept;

/// One of the models. Const after construction: any number of states may step side by side.
class ProbeForceModel {
 public:
  using Model = std::variant<VidalProbe, MultiProxyProbe>;
  explicit ProbeForceModel(Model model) : model_(std::move(model)) {}

  ProbeForceState NewState() const;

  /// Takes in the next sample. Bad samples: as NeedleForceModel::Step. Allocates nothing.
  /// @pre `state` is of this model.
  ProbeForce Step(ProbeForceState& state, const ProbeInput& input) const noexcept;

  /// Null for another model.
  const MultiProxyProbe* multi_proxy() const { return std::get_if<MultiProxyProbe>(&model_); }

  /// Bound on the magnitude of the force.
  double LargestForceN() const noexcept;

 private:
  Model model_;
};

}  // namespace acus::forces
