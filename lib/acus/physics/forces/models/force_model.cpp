#include "acus/physics/forces/models/force_model.h"

#include <type_traits>

#include "acus/physics/forces/path/sweep.h"

namespace acus::forces {
namespace {

/// What models that use labels distinguish.
struct SweptLabels {
  const SweptTissue& tissue;
  static constexpr int kMostLooks = SweepLimits::kMostLooks;
  int At(const Eigen::Vector3d& mm, int /*before*/) const noexcept { return LabelAt(mm); }
  volume::Label LabelAt(const Eigen::Vector3d& mm) const noexcept {
    return tissue.lookup->At(mm + tissue.tip_offset_mm);
  }
};

/// What a model distinguishes that reads the CT itself.
template <class Model>
struct SweptField {
  const Model& model;
  const SweptTissue& tissue;
  static constexpr int kMostLooks = SweepLimits::kMostLooksAtHu;
  int At(const Eigen::Vector3d& mm, int before) const noexcept { return model.KindAt(mm, before); }
  volume::Label LabelAt(const Eigen::Vector3d& mm) const noexcept {
    return tissue.lookup->At(mm + tissue.tip_offset_mm);
  }
};

template <class Model, class State>
NeedleForce Swept(const Model& model, State& state, const NeedleInput& input,
                  const SweptTissue& tissue, PassedEvents& events) noexcept {
  const auto run = [&](const auto& place, double step_mm) {
    Sweep sweep(model, state, place, step_mm, events);
    SweptWay way;
    if (tissue.lookup == nullptr ||
        !IsSwept(state, model.table().settings, input, state.guide.axis_in_ct, way)) {
      return sweep.Once(input);
    }
    return sweep.Along(way);
  };
  if constexpr (requires { model.KindAt(input.tip_in_ct_mm, 0); }) {
    return run(SweptField<Model>{model, tissue}, model.HalfVoxelMm());
  } else {
    return run(SweptLabels{tissue}, tissue.lookup != nullptr ? tissue.lookup->HalfVoxelMm() : 1.0);
  }
}

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
      model_);
}

NeedleForce ForceModel::Step(ForceState& state, const NeedleInput& input) const noexcept {
  return std::visit(
      [&]<class Model>(const Model& model) {
        return model.Step(*std::get_if<typename StateOf<Model>::type>(&state), input);
      },
      model_);
}

NeedleForce ForceModel::StepAlong(ForceState& state, const NeedleInput& input,
                                  const SweptTissue& tissue, PassedEvents& events) const noexcept {
  events.Clear();
  return std::visit(
      [&]<class Model>(const Model& model) {
        auto& of_model = *std::get_if<typename StateOf<Model>::type>(&state);
        return Swept(model, of_model, input, tissue, events);
      },
      model_);
}

const ForceTable& ForceModel::table() const {
  return std::visit([](const auto& model) -> const ForceTable& { return model.table(); }, model_);
}

}  // namespace acus::forces
