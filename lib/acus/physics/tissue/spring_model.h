// Tissue as linear springs along the path of the needle: no mesh, about a microsecond per step.
//
// Fortmeier-2016, section 2.3 (algorithm 1, eq. 4 to 7) for a rigid needle; the path may turn with
// it. For a needle that bends (eq. 8), the sample gives the direction of its tip. Equations and
// where they differ from the print: docs/models/tissue_functions_and_springs.md.
#pragma once

#include <array>
#include <bitset>
#include <cstdint>
#include <vector>

#include "acus/physics/forces/laws/force_table.h"
#include "acus/physics/forces/laws/friction_pace.h"
#include "acus/physics/forces/models/needle_force.h"
#include "acus/physics/mechanics/elements/elasticity_table.h"
#include "acus/physics/tissue/sample_gate.h"
#include "acus/physics/tissue/tissue_at.h"
#include "acus/physics/tissue/tissue_load.h"
#include "acus/physics/tissue/tool_sample.h"

namespace acus::tissue {

struct SpringSettings {
  double node_spacing_mm = 2.0;       ///< Delta p of the paper.
  double influence_radius_mm = 20.0;  ///< Tissue is held at this distance from the needle.
  /// Largest change of the friction force per second: keeps stiff springs from overshooting.
  double friction_rate_n_per_s = 1000.0;
  /// Stiffness of all springs across the needle together. A spring K that comes 1.5 steps T late
  /// needs a damping of 1.5 K T: at 1 kHz a device and hand of 4.5 N s/m hold up to 3 N/mm.
  double stiffest_across_n_per_mm = 2.0;
};

/// A node of the needle's path, in the tissue at rest. Springs are for a full spacing.
struct PathNode {
  Eigen::Vector3d rest_in_ct_mm = Eigen::Vector3d::Zero();
  volume::Label tissue = 0;
  double axial_n_per_mm = 0.0;    ///< k_i along the needle.
  double lateral_n_per_mm = 0.0;  ///< k_i across it.
  double friction_n = 0.0;        ///< R_i: the shaft slides beyond it.
  double a1_n_per_mm = 0.0;       ///< a_1,i of the cut.
  double a2_n_per_mm2 = 0.0;      ///< a_2,i.
  double cutting_n = 0.0;         ///< f_cut,i.
  double offset_mm = 0.0;         ///< Delta x_i: how far the tissue is dragged along.
  /// The same of the branches that relax, of the tissue's series.
  std::array<double, forces::ForceRelaxation::kMostTerms> relaxing_mm{};
};

/// A plain value: copy it to save, assign it to restore.
struct SpringState {
  static constexpr int kMaxNodes = 128;

  SampleGate gate;
  std::array<PathNode, kMaxNodes> node{};  ///< From the skin to the tip.
  int num_nodes = 0;                       ///< 0: outside; 1: on the skin; more: inside.
  std::int64_t num_path_full = 0;          ///< Nodes that found no room.

  Eigen::Vector3d device_in_ct_mm =
      Eigen::Vector3d::Zero();  ///< X: where the needle's tip is held.
  Eigen::Vector3d axis_in_ct = Eigen::Vector3d::UnitZ();
  bool bends = false;  ///< The tip's direction is given: the springs across act on the bent needle.
  Eigen::Vector3d tip_direction_in_ct = Eigen::Vector3d::UnitZ();  ///< d_l; the axis if rigid.
  double ahead_mm = 0.0;  ///< Delta d: of the device beyond the tip of the path.
  /// Where the branches that relax are at rest ahead of the tip of the path; >= 0.
  std::array<double, forces::ForceRelaxation::kMostTerms> rest_mm{};
  forces::FrictionPace pace;
  double slid_mm = 0.0;  ///< By how much the nodes slid in the last piece of a step, on average.
  volume::Label tissue_at_tip = 0;

  bool pierced = false;
  bool pressing = false;  ///< The tip is held by the membrane of `membrane_of`.
  volume::Label membrane_of = 0;
  bool on_bone = false;
  double bone_from_mm = 0.0;   ///< ahead_mm when the bone was met.
  double friction_n = 0.0;     ///< After the limit of its rate.
  double lateral_share = 1.0;  ///< Of the lateral springs' force, that the limit leaves.
  forces::NeedleForce force;
};

/// Eq. 4 and the update of the tip: how far the path's tip advances when the device is `ahead_mm`
/// beyond it, so that a2 x^2 + a1 x of what remains is at most `cutting_n`. Below 0 it moves back.
double TipAdvanceMm(double ahead_mm, double a1_n_per_mm, double a2_n_per_mm2,
                    double cutting_n) noexcept;

/// Eq. 6: the offset of a friction spring after the shaft has moved by `travel_mm`.
double FrictionOffsetMm(double offset_mm, double travel_mm, double stiffness_n_per_mm,
                        double friction_n) noexcept;

class SpringModel {
 public:
  /// @param tissues  labels that the scene has; all but free space and bone need elastic constants.
  /// @param hu_at  given, and with rows in the table's hu_springs: parameters of cut and shaft are
  ///     those at the HU of each node (Fortmeier-2016 section 2.3); membranes, bone and the springs
  ///     across the needle are the tissue's. As tissue_at, called in the step.
  /// @throws InputError for a setting out of range or a tissue that `elasticity` has no row for.
  SpringModel(const SpringSettings& settings, const forces::ForceTable& forces,
              const forces::NeedleProperties& needle, const mechanics::ElasticityTable& elasticity,
              const std::bitset<256>& tissues, TissueAt tissue_at, HuAt hu_at = nullptr);

  SpringState NewState() const { return {}; }

  /// Takes in the next sample; bad ones as forces::NeedleForceModel::Step. The force's magnitude
  /// never exceeds the table's largest_force_n. Allocates nothing.
  forces::NeedleForce Step(SpringState& state, const ToolSample& sample) const noexcept;

  /// Forces on the tissue at the path's nodes, in order from the skin to the tip.
  void LoadOf(const SpringState& state, TissueLoad& out) const noexcept;

  /// Force on the needle by the spring of path node `i`, whose partner on the needle is at
  /// `needle_in_ct_mm`, across `tangent_in_ct` (unit). For a needle that bends, too.
  Eigen::Vector3d LateralForceN(const SpringState& state, int i,
                                const Eigen::Vector3d& needle_in_ct_mm,
                                const Eigen::Vector3d& tangent_in_ct) const noexcept;

  /// Springs and friction limit of a node of the path in this tissue.
  const PathNode& TissueNode(volume::Label tissue) const { return node_of_[tissue]; }
  /// The same of a node at a place: by its HU, where parameters are.
  PathNode NodeAt(const Eigen::Vector3d& rest_in_ct_mm) const noexcept;
  const SpringSettings& settings() const { return settings_; }
  const forces::ForceTable& table() const { return table_; }

  /// Share of a full spacing that node `i` >= 1 stands for: |p_i - p_(i-1)| / Delta p.
  double Weight(const SpringState& state, int i) const noexcept;

 private:
  using Event = forces::NeedleEvent;
  static double CuttingN(const PathNode& tip, double ahead_mm) noexcept;
  static double CuttingAheadMm(const PathNode& tip) noexcept;
  void Touch(SpringState& state, const Eigen::Vector3d& before_mm, bool was_outside) const noexcept;
  bool HasLeft(const SpringState& state) const noexcept;
  void DragShaft(SpringState& state, double travel_mm, double dt_s) const noexcept;
  void DrawBack(SpringState& state, double back_mm) const noexcept;
  struct Ahead {
    volume::Label tissue = 0;
    double at_mm = 0.0;  ///< From the tip.
  };
  Ahead LookAhead(const SpringState& state, double step_mm) const noexcept;
  Event Advance(SpringState& state) const noexcept;
  Event GiveWay(SpringState& state) const noexcept;
  Event Meet(SpringState& state, volume::Label next, double step_mm) const noexcept;
  void MoveTip(SpringState& state, const Eigen::Vector3d& to_mm) const noexcept;
  void AppendTip(SpringState& state) const noexcept;
  void SetTissue(PathNode& node, volume::Label tissue) const noexcept;
  void SetByHu(PathNode& node) const noexcept;
  void Forces(SpringState& state, double dt_s, double ahead_before_mm) const noexcept;
  template <class Law>
  double TipN(const SpringState& state, double ahead_mm, const Law& law) const noexcept;
  double PressedN(const SpringState& state, double ahead_mm) const noexcept;

  // spring_time.cpp
  void DragInTime(SpringState& state, double travel_mm, double dt_s) const noexcept;
  void DragNode(PathNode& node, const forces::PaceLogs& logs, double travel_mm,
                double dt_s) const noexcept;
  double HeldOffsetMm(const PathNode& node) const noexcept;
  void TakeMeanOffset(PathNode& node, volume::Label tissue) const noexcept;
  const forces::ForceRelaxation& TipRelaxation(const SpringState& state) const noexcept;
  void TakeTipOver(SpringState& state, const forces::ForceRelaxation& before) const noexcept;
  void CreepTip(SpringState& state, double from_mm, double dt_s) const noexcept;
  void AdvanceRests(SpringState& state, double step_mm) const noexcept;

  SpringSettings settings_;
  forces::ForceTable table_;
  std::vector<PathNode> node_of_;  ///< By label.
  TissueAt tissue_at_;
  HuAt hu_at_;  ///< Null: parameters are those of the tissues.
};

/// Displacements for the image: those of the path's nodes, faded out to the influence radius as in
/// Alamilla-2021. Continuous. One for each thread; keeps a reference to the model.
class SpringField {
 public:
  explicit SpringField(const SpringModel& model) : model_(&model) {}

  /// @param load  as made by SpringModel::LoadOf.
  void Update(const TissueLoad& load) noexcept;
  Eigen::Vector3d DisplacementMm(const Eigen::Vector3d& rest_in_ct_mm) const noexcept;

 private:
  const SpringModel* model_;
  int num_nodes_ = 0;
  Eigen::Vector3d begin_mm_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d along_ = Eigen::Vector3d::UnitZ();
  std::array<double, SpringState::kMaxNodes> at_mm_{};  ///< Of the nodes along the path; ascending.
  std::array<Eigen::Vector3d, SpringState::kMaxNodes> moved_mm_{};
};

}  // namespace acus::tissue
