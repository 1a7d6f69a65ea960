#include "acus/physics/tissue/tissue_model.h"

namespace acus::tissue {
namespace {

/// The part of a model that steps with the samples; null for formulas, which have no state.
const SpringModel* Contact(const SpringModel& model) {
  return &model;
}
const PlaneModel2010* Contact(const PlaneModel2010& model) {
  return &model;
}
const FemNeedleModel* Contact(const FemTissue& model) {
  return &model.needle;
}
std::nullptr_t Contact(const DisplacementFunctions&) {
  return nullptr;
}

template <class Model>
concept Stepping = requires(const Model& model) {
  Contact(model)->NewState();
};

template <Stepping Model>
using StateOf = decltype(Contact(std::declval<const Model&>())->NewState());

/// What a model computes beside the force on the needle.
void Describe(const SpringModel&, const SpringState& state, TissueForce& out) noexcept {
  out.touched = state.num_nodes > 0;
  out.pierced = state.pierced;
  out.tissue_at_tip = state.bends && state.num_nodes > 0 ? state.node[state.num_nodes - 1].tissue
                                                         : state.tissue_at_tip;
}

void Describe(const PlaneModel2010&, const PlaneState& state, TissueForce& out) noexcept {
  out.touched = state.in_body();
  out.pierced = state.pierced();
  out.tissue_at_tip = state.tissue_at_tip;
}

void Describe(const FemNeedleModel& model, const FemNeedleState& state, TissueForce& out) noexcept {
  out.touched = state.phase != NeedlePhase::kFree || state.probe_force.num_nodes > 0;
  out.pierced = state.phase == NeedlePhase::kInside;
  out.probe_in_ct_n = state.probe_force.force_in_ct_n;
  out.probe_torque_in_ct_n_mm = state.probe_force.torque_in_ct_n_mm;
  out.num_probe_nodes = state.probe_force.num_nodes;
  out.probe_depth_mm = state.probe_force.deepest_mm;
  if (state.phase == NeedlePhase::kFree) return;
  // At the end of its cut the tip is where it cut last; withdrawn, somewhere along the cut.
  const Eigen::Vector3d axis = state.frame.col(2);
  const bool drawn_back = state.depth_mm < (state.end_mm - state.entry_mm).dot(axis);
  out.tissue_at_tip = drawn_back ? model.mesh().Find(state.entry_mm + state.depth_mm * axis).tissue
                                 : state.end_tissue;
}

DisplacementFunctionsField FieldOf(const DisplacementFunctions& model) {
  return DisplacementFunctionsField(model);
}
SpringField FieldOf(const SpringModel& model) {
  return SpringField(model);
}
PlaneField2010 FieldOf(const PlaneModel2010& model) {
  return PlaneField2010(model);
}
FemField FieldOf(const FemTissue& model) {
  return FemField(*model.image);
}

}  // namespace

void TissueField::Update(const TissueLoad& load) {
  std::visit([&](auto& field) { field.Update(load); }, model_);
}

Eigen::Vector3d TissueField::DisplacementMm(const Eigen::Vector3d& rest_in_ct_mm) const noexcept {
  return std::visit([&](const auto& field) { return field.DisplacementMm(rest_in_ct_mm); }, model_);
}

TissueState TissueModel::NewState() const {
  return std::visit(
      []<class Model>(const Model& model) -> TissueState {
        if constexpr (Stepping<Model>) {
          return Contact(model)->NewState();
        } else {
          return std::monostate();
        }
      },
      model_);
}

TissueForce TissueModel::Step(TissueState& state, const ToolSample& sample) const noexcept {
  TissueForce out;
  std::visit(
      [&]<class Model>(const Model& model) {
        if constexpr (Stepping<Model>) {
          auto& its_state = *std::get_if<StateOf<Model>>(&state);
          out.needle = Contact(model)->Step(its_state, sample);
          Describe(*Contact(model), its_state, out);
        }
      },
      model_);
  return out;
}

bool TissueModel::LoadOf(const TissueState& state, TissueLoad& out) const noexcept {
  return std::visit(
      [&]<class Model>(const Model& model) {
        if constexpr (Stepping<Model>) {
          const auto& its_state = *std::get_if<StateOf<Model>>(&state);
          TissueForce what;
          Describe(*Contact(model), its_state, what);
          if (what.touched) Contact(model)->LoadOf(its_state, out);
          return what.touched;
        }
        return false;
      },
      model_);
}

double TissueModel::LargestForceN() const noexcept {
  return std::visit(
      []<class Model>(const Model& model) -> double {
        if constexpr (Stepping<Model>) {
          return Contact(model)->table().settings.largest_force_n;
        } else {
          return 0.0;
        }
      },
      model_);
}

TissueField TissueModel::NewField() const {
  return std::visit([](const auto& model) { return TissueField(FieldOf(model)); }, model_);
}

}  // namespace acus::tissue
