// Tissue that tools deform: one interface for all models, from two formulas to finite elements.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <variant>

#include "acus/data/volume/volume.h"
#include "acus/physics/forces/models/needle_force.h"
#include "acus/physics/tissue/displacement_functions.h"
#include "acus/physics/tissue/fem_field.h"
#include "acus/physics/tissue/needle_contact.h"
#include "acus/physics/tissue/plane_model_2010.h"
#include "acus/physics/tissue/spring_model.h"
#include "acus/physics/tissue/tissue_load.h"
#include "acus/physics/tissue/tool_sample.h"

namespace acus::tissue {

/// What one step gives.
struct TissueForce {
  bool touched = false;        ///< A tool deforms the tissue.
  forces::NeedleForce needle;  ///< On the needle.
  volume::Label tissue_at_tip = 0;
  bool pierced = false;                                     ///< The needle is through the skin.
  Eigen::Vector3d probe_in_ct_n = Eigen::Vector3d::Zero();  ///< On the probe.
  Eigen::Vector3d probe_torque_in_ct_n_mm = Eigen::Vector3d::Zero();  ///< About its face's middle.
  int num_probe_nodes = 0;      ///< Of the skin, that press on it.
  double probe_depth_mm = 0.0;  ///< Of its face beyond the skin at rest, at the deepest.
};

/// Finite elements in 3D: contact in the step, and the block that images are deformed by.
struct FemTissue {
  FemNeedleModel needle;
  std::shared_ptr<const FemImage> image;  ///< Null if no image shows the deformation.
};

/// The state of a model between steps. A plain value: a copy continues with the same bits.
using TissueState = std::variant<std::monostate, SpringState, PlaneState, FemNeedleState>;

/// Displacements at rest points by the forces of one moment. One for each thread; keeps a
/// reference to its model.
class TissueField {
 public:
  using Model = std::variant<DisplacementFunctionsField, SpringField, PlaneField2010, FemField>;
  explicit TissueField(Model model) : model_(std::move(model)) {}

  /// Takes in the forces. Allocates nothing after the first call.
  void Update(const TissueLoad& load);
  /// CT space, mm; continuous.
  Eigen::Vector3d DisplacementMm(const Eigen::Vector3d& rest_in_ct_mm) const noexcept;

 private:
  Model model_;
};

/// A model with its constants. Const after construction: any number of states and fields may use it
/// at once.
class TissueModel {
 public:
  using Model = std::variant<DisplacementFunctions, SpringModel, PlaneModel2010, FemTissue>;
  explicit TissueModel(Model model) : model_(std::move(model)) {}

  TissueState NewState() const;

  /// Takes in the next sample. Allocates nothing, takes no lock. Bad samples are dealt with as by
  /// forces::NeedleForceModel::Step. @pre `state` is of this model.
  TissueForce Step(TissueState& state, const ToolSample& sample) const noexcept;

  /// What the fields need. False, and `out` untouched, if nothing deforms the tissue.
  bool LoadOf(const TissueState& state, TissueLoad& out) const noexcept;

  /// The magnitude of the force on the needle never exceeds it, N; 0 for models without force.
  double LargestForceN() const noexcept;

  /// @pre the model is not FemTissue without an image.
  TissueField NewField() const;

 private:
  Model model_;
};

}  // namespace acus::tissue
