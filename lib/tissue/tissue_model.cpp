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

TissueForce TissueModel::Step([[maybe_unused]] TissueState& state,
                              [[maybe_unused]] const ToolSample& sample) const noexcept {
  return std::visit(
      [&]<class Model>(const Model& model) -> TissueForce {
        if constexpr (Stepping<Model>) {
          return model.Step(*std::get_if<StateOf<Model>>(&state), sample);
        } else {
          static_cast<void>(model);
          return {};
        }
      },
      level_);
}

bool TissueModel::LoadOf([[maybe_unused]] const TissueState& state,
                         [[maybe_unused]] TissueLoad& out) const noexcept {
  return std::visit(
      [&]<class Model>(const Model& model) -> bool {
        if constexpr (Stepping<Model>) {
          return model.LoadOf(*std::get_if<StateOf<Model>>(&state), out);
        } else {
          static_cast<void>(model);
          return false;
        }
      },
      level_);
}

TissueField TissueModel::NewField() const {
  return std::visit(
      []<class Model>(const Model& model) -> TissueField {
        return TissueField(DisplacementFunctionsField(model));
      },
      level_);
}

}  // namespace acus::tissue
