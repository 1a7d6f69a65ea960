// The 2D tissue of 2010 as a model of its own: triangles in one plane through the planned path,
// plane strain, an explicit inverse, and nodes that stick to the needle or slip along it.
//
// Augmented-2010, section II.B and III, after DiMaio and Salcudean; docs/models/tissue_2d_2010.md.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "acus/physics/forces/laws/force_table.h"
#include "acus/physics/forces/laws/friction_pace.h"
#include "acus/physics/forces/models/needle_force.h"
#include "acus/physics/mechanics/elements/elasticity_table.h"
#include "acus/physics/tissue/elastic_planes.h"
#include "acus/physics/tissue/needle_phase.h"
#include "acus/physics/tissue/plane_contact.h"
#include "acus/physics/tissue/sample_gate.h"
#include "acus/physics/tissue/tissue_at.h"
#include "acus/physics/tissue/tissue_load.h"
#include "acus/physics/tissue/tool_sample.h"

namespace acus::tissue {

/// A node that the needle touches.
struct PlaneNode {
  int node = 0;
  double at_mm = 0.0;  ///< Along the path, at rest.
  double friction_n_per_mm = 0.0;
  volume::Label tissue = 0;
  /// Coordinates of the needle (along, across the path) for which the node, sticking, is at rest.
  Eigen::Vector2d reference_mm = Eigen::Vector2d::Zero();
};

/// A plain value: copy it to save, assign it to restore; the model must outlive it.
struct PlaneState {
  bool in_body() const noexcept { return phase != NeedlePhase::kFree; }
  bool pierced() const noexcept { return phase == NeedlePhase::kInside; }

  SampleGate gate;
  PlaneContact contact;         ///< Slot 2 q: along the path, 2 q + 1: across it, at node q.
  std::vector<PlaneNode> node;  ///< The first num_nodes count, from the skin on.
  int num_nodes = 0;
  int next_layer = 0;  ///< Of the grid, in which the next node is sought.

  PlaneFrame frame;  ///< Kept while the needle is in the body.
  Eigen::Vector3d tip_in_ct_mm = Eigen::Vector3d::Zero();     ///< Of the device.
  Eigen::Vector3d axis_in_ct = Eigen::Vector3d::UnitZ();      ///< Unit length.
  Eigen::Vector2d tip_in_plane_mm = Eigen::Vector2d::Zero();  ///< Of the device.
  Eigen::Vector2d axis_in_plane = Eigen::Vector2d::UnitY();
  double out_of_plane_mm = 0.0;   ///< Distance of the device's tip from the plane.
  double out_of_plane_rad = 0.0;  ///< Angle of its axis to the plane.
  double out_slope = 0.0;         ///< The same as a slope; 0 for a plane that does not turn.
  volume::Label tissue_at_tip = 0;

  NeedlePhase phase = NeedlePhase::kFree;  ///< There is a path unless it is free.
  bool pressing = false;                   ///< The tip is held by the membrane of `membrane_of`.
  bool engaged = false;  ///< The tip is at the end of its channel, not withdrawn in it.
  bool cutting = false;  ///< The channel got longer in the last substep.
  bool on_bone = false;
  Eigen::Vector2d entry_mm = Eigen::Vector2d::Zero();
  Eigen::Vector2d along = Eigen::Vector2d::UnitY();
  double device_mm = 0.0;    ///< Of the device's tip along the path.
  double needle_mm = 0.0;    ///< Of the needle's tip: bone holds it back.
  double aside_mm = 0.0;     ///< Of the tip from the path's line.
  double slope = 0.0;        ///< Of the needle to the path.
  double tip_rest_mm = 0.0;  ///< The tip, in tissue at rest.
  double channel_mm = 0.0;   ///< Depth to which tissue is cut, at rest.
  volume::Label cut_tissue = 0;
  volume::Label membrane_of = 0;
  double bone_at_mm = 0.0;  ///< The needle goes no farther.
  forces::FrictionPace pace;
  forces::PaceLogs pace_logs;
  double slid_mm = 0.0;  ///< By how much the nodes slid in the last substep, on average.
  forces::NeedleForce force;
};

class PlaneModel2010 {
 public:
  /// Cost and errors as ElasticPlanes. @throws InputError also for a limit that is not above 0.
  PlaneModel2010(const PlaneSettings& settings, const PlanePlacement& placement,
                 const forces::ForceTable& forces, const forces::NeedleProperties& needle,
                 const mechanics::ElasticityTable& elasticity, TissueAt tissue_at);

  /// The same plane (and the same inverse in memory) with the other kind of update.
  PlaneModel2010 WithUpdate(PlaneUpdate update) const;

  PlaneState NewState() const;

  /// Takes in the next sample; bad ones as forces::NeedleForceModel::Step. What is out of the plane
  /// is projected into it; a plane that turns contains the needle when that touches the skin. The
  /// force's magnitude never exceeds the table's largest_force_n.
  forces::NeedleForce Step(PlaneState& state, const ToolSample& sample) const noexcept;

  /// Forces on the nodes that the needle touches.
  void LoadOf(const PlaneState& state, TissueLoad& out) const noexcept;

  const PlaneSettings& settings() const { return settings_; }
  const forces::ForceTable& table() const { return table_; }
  const ElasticPlanes& planes() const { return planes_; }

 private:
  using Event = forces::NeedleEvent;
  struct Motion;
  void Lay(PlaneState& state, const ToolSample& sample) const noexcept;
  volume::Label LabelAt(const PlaneFrame& frame, const Eigen::Vector2d& plane_mm) const noexcept;
  volume::Label LabelOnPath(const PlaneState& state, double at_mm) const noexcept;

  bool Touch(PlaneState& state, const Motion& motion) const noexcept;
  void StartPath(PlaneState& state, const Eigen::Vector2d& along,
                 const Eigen::Vector2d& entry_mm) const noexcept;
  bool AppendNode(PlaneState& state, double travel_mm) const noexcept;
  int NodeOfLayer(const PlaneState& state, int layer) const noexcept;
  static int LayerStep(const PlaneState& state) noexcept;
  Event Substep(PlaneState& state, const Eigen::Vector2d& tip_mm, const Eigen::Vector2d& axis,
                double dt_s) const noexcept;
  Event Balance(PlaneState& state, double travel_mm) const noexcept;
  void SetDemands(PlaneState& state, double lead_mm) const noexcept;
  bool CanDropLast(const PlaneState& state) const noexcept;
  void KeepSlips(PlaneState& state) const noexcept;
  Event FollowTip(PlaneState& state) const noexcept;
  Event AdvanceChannel(PlaneState& state, double to_mm) const noexcept;
  Event Pierce(PlaneState& state) const noexcept;
  bool HasLeft(const PlaneState& state) const noexcept;
  void Leave(PlaneState& state) const noexcept;
  double TipLimitN(const PlaneState& state) const noexcept;
  double FrictionNPerMm(const PlaneState& state, const PlaneNode& node) const noexcept;
  double AcrossMm(const PlaneState& state, double at_mm) const noexcept;
  double Hat(const PlaneState& state, int q, double at_mm) const noexcept;
  double HatIntegral(const PlaneState& state, int q, double end_mm) const noexcept;
  double AlongDisplacementMm(const PlaneState& state, double at_mm) const noexcept;
  void Forces(PlaneState& state, double speed_mm_per_s) const noexcept;

  PlaneSettings settings_;
  forces::ForceTable table_;
  TissueAt tissue_at_;
  ElasticPlanes planes_;
  mechanics::Relaxation relaxation_;
};

/// Displacements for the image: exact in the nodes, linear in the triangles, faded out of the
/// plane. In the air above the skin they fade to 0, too, and nodes on the border of the region do
/// not move, so the field is continuous everywhere. One for each thread; keeps a reference to the
/// model.
class PlaneField2010 {
 public:
  explicit PlaneField2010(const PlaneModel2010& model);

  /// @param load  as made by PlaneModel2010::LoadOf. Allocates nothing. Cost O(nodes x points).
  void Update(const TissueLoad& load) noexcept;
  Eigen::Vector3d DisplacementMm(const Eigen::Vector3d& rest_in_ct_mm) const noexcept;

 private:
  /// A node in the air goes with a node of the skin.
  struct AirNode {
    int node = 0;
    int with = 0;
    double share = 0.0;
  };
  std::vector<AirNode> AirOf(int plane) const;

  const PlaneModel2010* model_;
  std::vector<std::vector<AirNode>> air_;  ///< Of each plane.
  PlaneFrame frame_;
  Eigen::VectorXd dof_mm_;    ///< As the rows of the compliance.
  Eigen::Matrix2Xd node_mm_;  ///< In plane coordinates.
  bool active_ = false;
};

}  // namespace acus::tissue
