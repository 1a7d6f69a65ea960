// The passes over the rod that RodModel::Solve is made of. Internal to the module.
#pragma once

#include "acus/physics/needle/rod.h"

namespace acus::needle {

/// Beyond these an input is not of a needle: 100 m, N/mm or N mm/rad, N.
inline constexpr double kFarthestMm = 1e5;
inline constexpr double kStiffest = 1e9;
inline constexpr double kLargestN = 1e6;
inline bool IsNear(const Eigen::Vector3d& place_mm) noexcept {
  return place_mm.allFinite() && place_mm.cwiseAbs().maxCoeff() <= kFarthestMm;
}

/// Where the rod starts, in the sweep's sense.
struct RodStart {
  Eigen::Vector3d position_mm = Eigen::Vector3d::Zero();
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
};

/// Takes contacts and loads into state.action, by place along the needle.
/// False if there are too many, or one is not finite, negative or far beyond any needle; the state
/// keeps its shape.
bool TakeActions(const RodModel& model, const RodInput& input, RodState& state) noexcept;

/// Lays `curvature_per_mm` of each `from` point out from `start` into `to`. Returns the energy.
double LayOut(const RodModel& model, const RodStart& start, const std::vector<RodPoint>& from,
              RodState& state) noexcept;

/// The same for the shape corrected by the step of the last TipToBase, scaled by `fraction`, with
/// its feedback from how far each node has really moved. Into state.trial; returns the energy.
double LayOutStep(const RodModel& model, const RodStart& start, double fraction,
                  RodState& state) noexcept;

/// Places and energy of the actions for state.point as it is. Returns the whole energy.
double Place(const RodModel& model, RodState& state) noexcept;

/// Forces, moments and gradient of state.point into state.sweep. Returns the largest unbalanced
/// moment of an element, N mm.
double Balance(const RodModel& model, RodState& state) noexcept;

/// dE / d(base position) and dE / d(base rotation, about the base) of the last Balance.
struct BaseGradient {
  Eigen::Vector3d force_n = Eigen::Vector3d::Zero();
  Eigen::Vector3d moment_n_mm = Eigen::Vector3d::Zero();
};
BaseGradient GradientAtBase(const RodState& state) noexcept;

/// The quadratic model of the energy that remains when the base moves: value terms at the base.
struct BaseModel {
  Eigen::Matrix<double, 6, 6> hessian = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Matrix<double, 6, 1> gradient = Eigen::Matrix<double, 6, 1>::Zero();
  bool repaired = false;  ///< A pivot was not positive and was changed.
};

/// Solves for the Newton step, from tip to base. With `curved`, the full second derivative; without
/// it the Gauss-Newton part, which is always positive definite.
BaseModel TipToBase(const RodModel& model, bool curved, RodState& state) noexcept;

}  // namespace acus::needle
