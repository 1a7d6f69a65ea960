// The 3D finite element model: a rigid needle and a probe in contact with elastic tissue, by stick
// and slip, from the condensed compliance. Equations and limits: docs/models/tissue_contact.md.
//
// After DiMaio and Salcudean (2003, IEEE Trans. Robotics and Automation 19(5):864-875; 2005, IEEE
// Trans. Biomedical Engineering 52(7):1167-1179), whose nodes on a remeshed path here are material
// points inside the elements, so that nothing is remeshed; and Augmented-2010, section II.B.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "acus/physics/forces/laws/force_table.h"
#include "acus/physics/forces/laws/friction_pace.h"
#include "acus/physics/forces/models/needle_force.h"
#include "acus/physics/mechanics/elements/elasticity_table.h"
#include "acus/physics/tissue/contact_mesh.h"
#include "acus/physics/tissue/contact_system.h"
#include "acus/physics/tissue/membrane_dimple.h"
#include "acus/physics/tissue/needle_phase.h"
#include "acus/physics/tissue/probe_contact.h"
#include "acus/physics/tissue/sample_gate.h"
#include "acus/physics/tissue/shell_near_field.h"
#include "acus/physics/tissue/strain_contact.h"
#include "acus/physics/tissue/tip_kernel.h"
#include "acus/physics/tissue/tissue_load.h"
#include "acus/physics/tissue/tool_sample.h"

namespace acus::tissue {

struct FemContactSettings {
  double contact_spacing_mm = 1.5;   ///< Between points along the shaft, at rest; > 0.
  int max_points = 96;               ///< The spacing grows if the needle is longer than they reach.
  std::optional<ProbeFace> probe{};  ///< None: the probe does not press.
  int max_probe_nodes = 48;
  std::optional<StrainSettings> strain{};  ///< None: linear everywhere.
};

/// A material point on the path that the tip has cut.
struct NeedlePoint {
  Eigen::Vector3d rest_in_ct_mm = Eigen::Vector3d::Zero();
  double axial_mm = 0.0;  ///< Of its place at rest, along the frame, from the entry.
  Eigen::Vector2d lateral_mm = Eigen::Vector2d::Zero();  ///< The same across.
  Eigen::Vector2d offset_mm = Eigen::Vector2d::Zero();   ///< Makes it free of force when it is new.
  double slip_mm = 0.0;   ///< It sticks where u = depth of the tip - slip.
  double moved_mm = 0.0;  ///< Its axial displacement u after the last step.
  double friction_n_per_mm = 0.0;
  volume::Label tissue = 0;
};

/// The state of the model between steps. A plain value: a copy continues with the same bits. Made
/// by FemNeedleModel::NewState(), which takes all the memory that it will ever need.
struct FemNeedleState : SampleGate {
  ContactState contact;
  StrainState strain;  ///< Empty for the linear law.
  ProbeState probe;
  ProbeForce probe_force;  ///< Of the last step.

  double probe_time_s = 0.0;  ///< Of the probe's last valid sample.
  double passed_s = 0.0;      ///< Until when tissue has relaxed.

  NeedlePhase phase = NeedlePhase::kFree;
  bool has_previous = false;  ///< There was a sample outside of the tissue before, at:
  Eigen::Vector3d outside_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d tip_in_ct_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d axis_in_ct = Eigen::Vector3d::UnitZ();

  Eigen::Vector3d entry_mm = Eigen::Vector3d::Zero();   ///< In the skin, at rest.
  Eigen::Matrix3d frame = Eigen::Matrix3d::Identity();  ///< Lateral, lateral, axial.
  double depth_mm = 0.0;                                ///< Of the tip, from the entry at rest.
  std::vector<NeedlePoint> point;
  forces::FrictionPace pace;
  forces::PaceLogs pace_logs;
  double slid_mm = 0.0;  ///< By how much the points slid in the last step, on average.

  // The end of the cut, at rest: where the tip cuts on. Kept when the needle leaves.
  bool has_channel = false;
  Eigen::Vector3d end_mm = Eigen::Vector3d::Zero();
  volume::Label end_tissue = 0;
  volume::Label beyond = 0;  ///< Tissue whose membrane is pressed.
  double membrane_n = 0.0;   ///< It yields at this force; 0: none is pressed.
  bool end_is_bone = false;
  bool on_bone = false;
  double tip_offset_mm = 0.0;  ///< Keeps the force when the tip meets something harder.
  // The membrane that the tip presses: stretched beside the finite elements, and linear in a step.
  MembraneDimple dimple;         ///< Of no membrane where none is pressed.
  double dimple_from_mm = 0.0;   ///< Displacement of the kernel where the tip met it.
  double kernel_moved_mm = 0.0;  ///< Displacement of the tip's kernel after the last step.
  double ground_mpa = 0.0;     ///< Stiffness of the ground under the skin's dimple over its radius.
  double near_mm_per_n = 0.0;  ///< What the kernel is too wide for.
  double stretch_n_per_mm = 0.0;  ///< Slope of the dimple's force for which the slot was set.
  Eigen::Vector3d placed_mm = Eigen::Vector3d::Zero();  ///< The end for which the slot was set.
  std::vector<Eigen::Vector3d> channel_mm;  ///< Points at rest, of the cut; also those not in use.
  int num_channel = 0;

  std::int64_t num_out_of_reach = 0;   ///< Points set in elements that are not all in reach.
  std::int64_t num_without_point = 0;  ///< Steps in which a point was due but all were in use.
  std::int64_t num_turned = 0;         ///< Changes of the frame because the needle had tilted.
  std::int64_t num_lost = 0;  ///< Contacts given up: pulled aside too hard, or turned over.
};

/// Const after construction: any number of states may step side by side.
class FemNeedleModel {
 public:
  /// @param compliance  Of nodes of `mesh`, of which at least one is needed.
  /// @throws InputError if a tissue of the mesh that can be deformed has no row in `elasticity`, if
  ///     the mesh is empty, or a setting is out of range.
  FemNeedleModel(const mesh::TetraMesh& mesh, const mechanics::Compliance& compliance,
                 const mechanics::ElasticityTable& elasticity, const forces::ForceTable& table,
                 const forces::NeedleProperties& needle, const FemContactSettings& settings);

  FemNeedleState NewState() const;

  /// Takes in the next sample. Bad samples are dealt with as by forces::NeedleForceModel::Step, and
  /// the magnitude of the force never exceeds the table's largest_force_n. Allocates nothing.
  forces::NeedleForce Step(FemNeedleState& state, const ToolSample& sample) const noexcept;

  /// Forces on the tissue, for the image. Those of the last step, also while tracking is lost.
  void LoadOf(const FemNeedleState& state, TissueLoad& out) const noexcept;

  const ContactSystem& system() const { return system_; }
  const ContactMesh& mesh() const { return mesh_; }
  const std::optional<StrainContact>& strain() const { return strain_; }
  double spacing_mm() const { return spacing_mm_; }
  const forces::ForceTable& table() const { return table_; }

 private:
  struct Outcome;

  // needle_contact.cpp
  void SolveContact(FemNeedleState& state) const noexcept;
  Eigen::Vector3d StrainMovedMm(const FemNeedleState& state,
                                const ContactPlace& place) const noexcept;
  void StepProbe(FemNeedleState& state, const ToolSample& sample) const noexcept;
  void Touch(FemNeedleState& state, const Eigen::Vector3d& tip_mm, const Eigen::Vector3d& axis,
             Outcome& outcome) const noexcept;
  void PressSkin(FemNeedleState& state) const noexcept;
  void Release(FemNeedleState& state) const noexcept;
  bool Pierced(FemNeedleState& state, Outcome& outcome) const noexcept;
  void After(FemNeedleState& state, Outcome& outcome) const noexcept;
  forces::NeedleForce ForceOf(const FemNeedleState& state, const Outcome& outcome) const noexcept;

  // needle_insertion.cpp
  void Enter(FemNeedleState& state, const Eigen::Vector3d& axis) const noexcept;
  void Demand(FemNeedleState& state) const noexcept;
  void FollowPace(FemNeedleState& state, double dt_s) const noexcept;
  void FollowSlip(FemNeedleState& state) const noexcept;
  forces::NeedleEvent Cut(FemNeedleState& state) const noexcept;
  void SetPoints(FemNeedleState& state) const noexcept;
  void AppendPoint(FemNeedleState& state, double axial_mm) const noexcept;
  void DropPoints(FemNeedleState& state) const noexcept;
  void Turn(FemNeedleState& state) const noexcept;
  void PlaceTip(FemNeedleState& state, const Eigen::Vector3d& direction) const noexcept;
  void PlaceTipKeepingForce(FemNeedleState& state) const noexcept;
  void DemandTip(FemNeedleState& state, double displacement_mm) const noexcept;
  void FollowDimple(FemNeedleState& state) const noexcept;
  double TipLimitN(const FemNeedleState& state) const noexcept;
  const mechanics::Membrane* MembraneBefore(const FemNeedleState& state) const noexcept;
  double FrictionNPerMm(const FemNeedleState& state, const NeedlePoint& point) const noexcept;
  double FrictionLengthMm(const FemNeedleState& state, int point) const noexcept;
  Eigen::Vector2d LineMm(const FemNeedleState& state, double axial_mm) const noexcept;

  forces::ForceTable table_;
  std::array<mechanics::ElasticTissue, 256> elastic_{};  ///< Solids, beneath their membranes.
  std::array<mechanics::ElasticTissue, 256> whole_{};    ///< With them: what holds the shaft.
  std::vector<mechanics::Membrane> membranes_;
  /// Near field of the membrane between each tissue and the outside.
  std::array<std::optional<ShellNearField>, 256> skin_shell_;
  ContactMesh mesh_;
  TipKernel kernel_;
  int max_points_;
  ContactSystem system_;
  std::optional<ProbeContact> probe_;
  std::optional<StrainContact> strain_;
  double radius_mm_;
  double spacing_mm_;
};

}  // namespace acus::tissue
