// Elastic planes around the planned path of the 2D tissue of 2010: triangles in plane strain, each
// plane with an explicit inverse.
//
// Augmented-2010, section II.B; docs/models/tissue_2d_2010.md.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "acus/physics/forces/laws/force_table.h"
#include "acus/physics/mechanics/elements/elasticity_table.h"
#include "acus/physics/mechanics/elements/plane_strain.h"
#include "acus/physics/tissue/plane_contact.h"
#include "acus/physics/tissue/plane_frame.h"
#include "acus/physics/tissue/tissue_at.h"

namespace acus::tissue {

struct PlaneSettings {
  double spacing_mm = 3.0;  ///< Of the nodes.
  double width_mm = 90.0;   ///< Of the region, across the planned path.
  double depth_mm = 90.0;   ///< Of the region below the planned entry.
  double above_mm = 12.0;   ///< And above it.
  /// How thick a slab the plane stands for. 0: pi R / ln(R / a), R half the width and a the radius
  /// of the needle, for which the shear stiffness of a shaft is that of a rod in 3D.
  double thickness_mm = 0.0;
  double lateral_limit_n_per_mm = 0.3;  ///< Force across the shaft at which tissue is torn.
  double image_fade_mm = 20.0;          ///< Out of the plane, displacements fade to 0 within it.
  double force_error_n = 1e-10;         ///< Bound of the residual monitor.
  PlaneUpdate update = PlaneUpdate::kRestricted;
  /// Above 0: while the needle touches nothing, the plane is laid through it, as parallel as
  /// possible to the image of a probe that is there. Its elastic constants are then those of the
  /// nearest of so many planes around the planned axis, each with an inverse of its own. 0: it
  /// stays where it was planned. Not with kFull.
  int num_turned = 0;
};

/// Where the plane is. Plane coordinates (x, y) are along `across` and `axis`, from the corner.
struct PlanePlacement {
  Eigen::Vector3d entry_in_ct_mm = Eigen::Vector3d::Zero();  ///< Planned, on the skin.
  Eigen::Vector3d axis_in_ct = Eigen::Vector3d::UnitZ();     ///< Planned direction, any length > 0.
  Eigen::Vector3d across_in_ct = Eigen::Vector3d::UnitX();   ///< Any not parallel to the axis.
};

/// The planned plane, and those that it may be turned into. Const after construction; copies share
/// the inverses.
class ElasticPlanes {
 public:
  /// Cost: the inverse of each plane, see mechanics::InvertPlane.
  /// @throws InputError for settings out of range, a tissue that `elasticity` has no row for, or a
  ///     plane in which nothing can move.
  ElasticPlanes(const PlaneSettings& settings, const PlanePlacement& placement,
                const forces::ForceTable& table, const mechanics::ElasticityTable& elasticity,
                double needle_radius_mm, const TissueAt& tissue_at);

  /// Without those that it may be turned into.
  ElasticPlanes OnlyPlanned() const;

  const mechanics::PlaneGrid& grid() const { return grid_; }  ///< The same in all planes.
  double thickness_mm() const { return thickness_mm_; }
  int count() const { return static_cast<int>(plane_.size()); }
  const PlaneFrame& planned() const { return plane_.front().frame; }
  const std::vector<int>& dof_of_node(int plane = 0) const { return Of(plane).dof_of_node; }
  /// mm/N, for the thickness.
  const Eigen::MatrixXd& compliance(int plane = 0) const { return *Of(plane).compliance; }
  int num_free_nodes() const { return static_cast<int>(compliance().rows()) / 2; }
  /// No tissue at any triangle of the node; other nodes that do not move are held.
  bool IsAir(int node, int plane = 0) const {
    return Of(plane).dof_of_node[node] < 0 && Of(plane).held[node] == 0;
  }

  /// The plane through the needle, as parallel as possible to the image; `present` if the needle is
  /// across the image or does not go the planned way.
  /// @param image_normal_in_ct  unit length.
  PlaneFrame FrameFor(const Eigen::Vector3d& tip_in_ct_mm, const Eigen::Vector3d& axis_in_ct,
                      const Eigen::Vector3d& image_normal_in_ct,
                      const PlaneFrame& present) const noexcept;

 private:
  struct Plane {
    PlaneFrame frame;
    std::vector<int> dof_of_node;
    std::vector<char> held;  ///< By node: bone, or the border of the region.
    std::shared_ptr<const Eigen::MatrixXd> compliance;  ///< Shared, so that it stays where it is.
  };
  const Plane& Of(int plane) const { return plane_[static_cast<std::size_t>(plane)]; }
  PlaneFrame FrameThrough(const Eigen::Vector3d& entry_in_ct_mm, const Eigen::Vector3d& axis,
                          const Eigen::Vector3d& normal) const noexcept;
  Plane MakePlane(const PlaneFrame& frame, const forces::ForceTable& table,
                  const mechanics::ElasticityTable& elasticity, const TissueAt& tissue_at) const;

  Eigen::Vector3d entry_in_ct_mm_;  ///< Planned.
  double thickness_mm_ = 0.0;
  mechanics::PlaneGrid grid_;
  int half_columns_ = 0;
  int rows_above_ = 0;
  std::vector<Plane> plane_;  ///< The first is the planned one.
};

}  // namespace acus::tissue
