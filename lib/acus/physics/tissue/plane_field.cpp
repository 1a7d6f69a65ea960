// The displacement field of PlaneModel2010.
#include <algorithm>
#include <cmath>
#include <limits>

#include "acus/physics/tissue/displacement_functions.h"
#include "acus/physics/tissue/plane_model_2010.h"

namespace acus::tissue {
namespace {

constexpr double kAirFadeMm = 10.0;  // Above the skin displacements are gone after this.

}  // namespace

PlaneField2010::PlaneField2010(const PlaneModel2010& model)
    : model_(&model), node_mm_(Eigen::Matrix2Xd::Zero(2, model.planes().grid().num_nodes())) {
  Eigen::Index most_dofs = 0;
  for (int plane = 0; plane < model.planes().count(); ++plane) {
    air_.push_back(AirOf(plane));
    most_dofs = std::max(most_dofs, model.planes().compliance(plane).rows());
  }
  dof_mm_.setZero(most_dofs);
}

/// The nodes above the skin that move with it.
std::vector<PlaneField2010::AirNode> PlaneField2010::AirOf(int plane) const {
  const PlaneModel2010& model = *model_;
  const std::vector<int>& dof_of = model.planes().dof_of_node(plane);
  std::vector<AirNode> nodes;
  const mechanics::PlaneGrid& grid = model.planes().grid();
  const int reach = static_cast<int>(std::ceil(kAirFadeMm / grid.spacing_mm));
  for (int row = 1; row + 1 < grid.rows; ++row) {  // The border stays where it is.
    for (int column = 1; column + 1 < grid.columns; ++column) {
      const int node = grid.Node(column, row);
      if (dof_of[node] >= 0) continue;
      AirNode air{node, -1, 0.0};
      double nearest_mm = kAirFadeMm;
      for (int r = std::max(0, row - reach); r <= std::min(grid.rows - 1, row + reach); ++r) {
        for (int c = std::max(0, column - reach); c <= std::min(grid.columns - 1, column + reach);
             ++c) {
          const int other = grid.Node(c, r);
          const double far_mm = (grid.PositionMm(other) - grid.PositionMm(node)).norm();
          if (dof_of[other] < 0 || far_mm >= nearest_mm) continue;
          nearest_mm = far_mm;
          air.with = other;
        }
      }
      air.share = Fade(nearest_mm / kAirFadeMm);
      if (air.with >= 0 && model.planes().IsAir(node, plane)) nodes.push_back(air);
    }
  }
  return nodes;
}

void PlaneField2010::Update(const TissueLoad& load) noexcept {
  active_ = load.needle.in_contact && load.num_points > 0;
  if (!active_) return;
  const PlaneModel2010& model = *model_;
  const mechanics::PlaneGrid& grid = model.planes().grid();
  frame_ = load.plane;
  const int plane = std::clamp(frame_.tissue, 0, model.planes().count() - 1);
  const std::vector<int>& dof_of = model.planes().dof_of_node(plane);
  const Eigen::MatrixXd& compliance = model.planes().compliance(plane);
  auto dof_mm = dof_mm_.head(compliance.rows());
  dof_mm.setZero();
  for (int i = 0; i < load.num_points; ++i) {
    const PointLoad& point = load.point[i];
    const Eigen::Vector3d at_mm = frame_.ToPlaneMm(point.rest_in_ct_mm);
    const double column = std::round(at_mm.x() / grid.spacing_mm);
    const double row = std::round(at_mm.y() / grid.spacing_mm);
    if (!(column >= 0 && row >= 0 && column < grid.columns && row < grid.rows)) continue;
    const int dof = dof_of[grid.Node(static_cast<int>(column), static_cast<int>(row))];
    if (dof < 0) continue;
    const Eigen::Vector3d force_n = frame_.DirectionInPlane(point.force_in_ct_n);
    dof_mm += force_n.x() * compliance.col(dof);
    dof_mm += force_n.y() * compliance.col(dof + 1);
  }
  node_mm_.setZero();  // Another plane has other nodes.
  for (int node = 0; node < grid.num_nodes(); ++node) {
    const int dof = dof_of[node];
    if (dof >= 0) node_mm_.col(node) = dof_mm_.segment<2>(dof);
  }
  for (const AirNode& air : air_[static_cast<std::size_t>(plane)])
    node_mm_.col(air.node) = air.share * node_mm_.col(air.with);
}

Eigen::Vector3d PlaneField2010::DisplacementMm(
    const Eigen::Vector3d& rest_in_ct_mm) const noexcept {
  if (!active_) return Eigen::Vector3d::Zero();
  const Eigen::Vector3d at_mm = frame_.ToPlaneMm(rest_in_ct_mm);
  const double fade = Fade(std::abs(at_mm.z()) / model_->settings().image_fade_mm);
  if (!(fade > 0.0)) return Eigen::Vector3d::Zero();
  const auto place = model_->planes().grid().PlaceOf(at_mm.head<2>());
  if (place.triangle < 0) return Eigen::Vector3d::Zero();
  Eigen::Vector2d moved_mm = Eigen::Vector2d::Zero();
  for (int k = 0; k < 3; ++k) moved_mm += place.weight[k] * node_mm_.col(place.node[k]);
  return fade * frame_.DirectionInCt(moved_mm);
}

}  // namespace acus::tissue
