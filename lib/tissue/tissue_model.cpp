#include "tissue/tissue_model.h"

namespace acus::tissue {
namespace {

/// Levels that touch the tools have a state; formulas do not.
template <class Model>
concept Stepping = requires(const Model& model) {
  model.NewState();
};

template <Stepping Model>
using StateOf = decltype(std::declval<const Model&>().NewState());

/// What a level knows beside the force on the needle.
void Describe(const SpringState& state, TissueForce& out) noexcept {
  out.touched = state.num_nodes > 0;
  out.tissue_at_tip = state.tissue_at_tip;
}

SpringField FieldOf(const SpringModel& model) {
  return SpringField(model);
}
DisplacementFunctionsField FieldOf(const DisplacementFunctions& model) {
  return DisplacementFunctionsField(model);
}

}  // namespace

void TissueField::Update(const TissueLoad& load) {
  std::visit([&](auto& field) { field.Update(load); }, level_);
}

Eigen::Vector3d TissueField::DisplacementMm(const Eigen::Vector3d& rest_in_ct_mm) const noexcept {
  return std::visit([&](const auto& field) { return field.DisplacementMm(rest_in_ct_mm); }, level_);
}

TissueState TissueModel::NewState() const {
  return std::visit(
      [](const auto& model) -> TissueState {
        if constexpr (Stepping<std::decay_t<decltype(model)>>) {
          return model.NewState();
        } else {
          return std::monostate();
        }
      },
      level_);
}

TissueForce TissueModel::Step(TissueState& state, const ToolSample& sample) const noexcept {
  TissueForce out;
  std::visit(
      [&]<class Model>(const Model& model) {
        if constexpr (Stepping<Model>) {
          auto& its_state = *std::get_if<StateOf<Model>>(&state);
          out.needle = model.Step(its_state, sample);
          Describe(its_state, out);
        }
      },
      level_);
  return out;
}

bool TissueModel::LoadOf(const TissueState& state, TissueLoad& out) const noexcept {
  return std::visit(
      [&]<class Model>(const Model& model) {
        if constexpr (Stepping<Model>) {
          const auto& its_state = *std::get_if<StateOf<Model>>(&state);
          TissueForce what;
          Describe(its_state, what);
          if (what.touched) model.LoadOf(its_state, out);
          return what.touched;
        }
        return false;
      },
      level_);
}

TissueField TissueModel::NewField() const {
  return std::visit([](const auto& model) { return TissueField(FieldOf(model)); }, level_);
}

}  // namespace acus::tissue
