#include "acus/physics/forces/force_model.h"

#include <type_traits>

namespace acus::forces {
namespace {

template <class Model>
struct StateOf;
template <>
struct StateOf<NeedleForceModel> : std::type_identity<NeedleForceState> {};
template <>
struct StateOf<AlamillaModel> : std::type_identity<AlamillaState> {};
template <>
struct StateOf<VidalModel> : std::type_identity<VidalState> {};
template <>
struct StateOf<MeasuredModel> : std::type_identity<MeasuredState> {};

}  // namespace

const NeedleTrack& TrackOf(const ForceState& state) noexcept {
  return std::visit([](const auto& track) -> const NeedleTrack& { return track; }, state);
}

ForceState ForceModel::NewState() const {
  return std::visit(
      []<class Model>(const Model&) -> ForceState { return typename StateOf<Model>::type(); },
      level_);
}

NeedleForce ForceModel::Step(ForceState& state, const NeedleInput& input) const noexcept {
  return std::visit(
      [&]<class Model>(const Model& model) {
        return model.Step(*std::get_if<typename StateOf<Model>::type>(&state), input);
      },
      level_);
}

const ForceTable& ForceModel::table() const {
  return std::visit([](const auto& model) -> const ForceTable& { return model.table(); }, level_);
}

}  // namespace acus::forces
