#include "acus/rig/camera/pose_refinement.h"

#include <algorithm>
#include <cmath>

namespace acus::camera {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

struct NormalEquations {
  Matrix6 matrix = Matrix6::Zero();
  Vector6 right = Vector6::Zero();
  double cost = 0.0;  ///< Of Geman-McClure: sum of c^2 r^2 / (c^2 + r^2).
};

NormalEquations Accumulate(std::span<const SeenPoint> points, const Eigen::Isometry3d& pose,
                           std::span<const Viewpoint> viewpoints, double outlier_sigmas) {
  const double c2 = outlier_sigmas * outlier_sigmas;
  NormalEquations normal;
  for (const SeenPoint& point : points) {
    const Viewpoint& view = viewpoints[point.viewpoint];
    const Eigen::Vector3d turned = pose.linear() * point.in_object_mm;
    Eigen::Matrix<double, 2, 3> by_point;
    const auto pixel =
        view.camera->Project(view.here_from_first * (turned + pose.translation()), by_point);
    if (!pixel) {
      normal.cost += c2;
      continue;
    }
    const Eigen::Vector2d residual = (*pixel - point.pixel) / point.sigma_px;
    const double r2 = residual.squaredNorm();
    const double share = c2 / (c2 + r2);
    normal.cost += share * r2;
    by_point *= view.here_from_first.linear();  // From here on by the point in the first's frame.
    Eigen::Matrix<double, 2, 6> derivative;
    Eigen::Matrix3d cross;
    cross << 0, turned[2], -turned[1], -turned[2], 0, turned[0], turned[1], -turned[0], 0;
    derivative << by_point, by_point * cross;
    derivative /= point.sigma_px;
    normal.matrix += share * share * derivative.transpose() * derivative;
    normal.right -= share * share * derivative.transpose() * residual;
  }
  return normal;
}

Eigen::Isometry3d Moved(const Eigen::Isometry3d& pose, const Vector6& step) {
  Eigen::Isometry3d moved = pose;
  const Eigen::Vector3d turn = step.tail<3>();
  const double angle = turn.norm();
  if (angle > 0.0) {
    moved.linear() = Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix() * pose.linear();
    // Rounding must not add up over many steps.
    moved.linear() = Eigen::Quaterniond(moved.linear()).normalized().toRotationMatrix();
  }
  moved.translation() += step.head<3>();
  return moved;
}

}  // namespace

double SquaredResidual(const SeenPoint& point, const Eigen::Isometry3d& camera_from_object,
                       std::span<const Viewpoint> viewpoints, double cap) {
  const Viewpoint& view = viewpoints[point.viewpoint];
  const auto pixel =
      view.camera->Project(view.here_from_first * (camera_from_object * point.in_object_mm));
  if (!pixel) return cap;
  return std::min(cap, (*pixel - point.pixel).squaredNorm() / (point.sigma_px * point.sigma_px));
}

RefinedPose RefinePose(std::span<const SeenPoint> points, const Eigen::Isometry3d& start,
                       std::span<const Viewpoint> viewpoints, double outlier_sigmas) {
  RefinedPose out;
  out.camera_from_object = start;
  NormalEquations normal = Accumulate(points, start, viewpoints, outlier_sigmas);
  double damping = 1e-4;
  for (int iteration = 0; iteration < 40 && !out.converged; ++iteration) {
    Matrix6 damped = normal.matrix;
    damped.diagonal() *= 1.0 + damping;
    damped.diagonal().array() += 1e-12;
    const Vector6 step = damped.ldlt().solve(normal.right);
    if (!step.allFinite()) break;
    const Eigen::Isometry3d moved = Moved(out.camera_from_object, step);
    const NormalEquations there = Accumulate(points, moved, viewpoints, outlier_sigmas);
    if (there.cost <= normal.cost) {
      out.converged = step.head<3>().norm() < 1e-6 && step.tail<3>().norm() < 1e-9;
      out.converged |= normal.cost - there.cost <= 1e-12 * normal.cost && damping <= 1e-4;
      out.camera_from_object = moved;
      normal = there;
      damping = std::max(1e-9, 0.1 * damping);
    } else {
      damping *= 10.0;
      if (damping > 1e8) break;
    }
  }
  Matrix6 information = normal.matrix;
  information.diagonal().array() += 1e-12;
  out.covariance = information.ldlt().solve(Matrix6::Identity());
  const double cap = outlier_sigmas * outlier_sigmas;
  for (const SeenPoint& point : points) {
    out.cost += SquaredResidual(point, out.camera_from_object, viewpoints, cap);
  }
  return out;
}

}  // namespace acus::camera
