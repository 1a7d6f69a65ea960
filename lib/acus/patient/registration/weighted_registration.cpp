#include "acus/patient/registration/weighted_registration.h"

#include <Eigen/Cholesky>
#include <cmath>

#include "acus/base/core/error.h"

namespace acus::registration {
namespace {

using Eigen::Index;
using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Jacobian = Eigen::Matrix<double, 3, 6>;

/// Below this an iteration changes nothing that matters: rad, and mm at a metre.
constexpr double kConverged = 1e-12;

Matrix3d CrossMatrix(const Vector3d& v) {
  Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

/// Derivative of a point's place by (rotation about the centre, translation).
Jacobian JacobianAt(const Vector3d& point_mm, const Vector3d& centre_mm) {
  Jacobian j;
  j << -CrossMatrix(point_mm - centre_mm), Matrix3d::Identity();
  return j;
}

Matrix3d Covariance(const MarkerNoise& noise, const Matrix3d& ct_from_reference) {
  return ct_from_reference * noise.reference_mm2 * ct_from_reference.transpose() + noise.ct_mm2;
}

Isometry3d Moved(const Isometry3d& pose, const Eigen::Matrix<double, 6, 1>& step,
                 const Vector3d& centre_mm) {
  const Vector3d rotation = step.head<3>();
  const double angle = rotation.norm();
  Isometry3d delta = Isometry3d::Identity();
  if (angle > 0.0) delta.linear() = Eigen::AngleAxisd(angle, rotation / angle).toRotationMatrix();
  delta.translation() = centre_mm - delta.linear() * centre_mm + step.tail<3>();
  Isometry3d moved = delta * pose;
  moved.linear() = Eigen::Quaterniond(moved.linear()).normalized().toRotationMatrix();
  return moved;
}

void RequireNoise(const std::vector<MarkerNoise>& noise, Index count) {
  ACUS_ASSERT(static_cast<Index>(noise.size()) == count);
  for (std::size_t i = 0; i < noise.size(); ++i) {
    // Directions of the two spaces differ by an unknown turn: each must do on its own, or both sum
    // up to something that has an inverse whatever the turn. Checked where it is used.
    const double total = noise[i].reference_mm2.trace() + noise[i].ct_mm2.trace();
    ACUS_REQUIRE(std::isfinite(total) && total > 0.0, "marker ", i + 1,
                 ": its localisation error must be above 0 mm");
  }
}

}  // namespace

TreEstimate PoseError::At(const Vector3d& target_ct_mm) const {
  const Jacobian j = JacobianAt(target_ct_mm, centre_ct_mm);
  TreEstimate tre;
  tre.covariance_mm2 = j * covariance * j.transpose();
  tre.rms_mm = std::sqrt(std::max(0.0, tre.covariance_mm2.trace()));
  return tre;
}

WeightedFit FitMarkersWeighted(const transforms::Markers& reference_mm,
                               const transforms::Markers& ct_mm,
                               const std::vector<MarkerNoise>& noise) {
  WeightedFit result;
  result.fit = FitMarkers(reference_mm, ct_mm);
  RequireNoise(noise, ct_mm.cols());
  Isometry3d& pose = result.fit.ct_from_reference;
  result.error.centre_ct_mm = ct_mm.rowwise().mean();
  Matrix6 normal = Matrix6::Zero();
  for (int iteration = 0; iteration < 100; ++iteration) {
    normal.setZero();
    Eigen::Matrix<double, 6, 1> right = Eigen::Matrix<double, 6, 1>::Zero();
    result.chi_square = 0.0;
    for (Index i = 0; i < ct_mm.cols(); ++i) {
      const Vector3d mapped_mm = pose * Vector3d(reference_mm.col(i));
      const Eigen::LDLT<Matrix3d> weight(
          Covariance(noise[static_cast<std::size_t>(i)], pose.linear()));
      const Vector3d d = weight.vectorD();
      ACUS_REQUIRE(d.minCoeff() > 1e-12 * d.maxCoeff(), "marker ", i + 1,
                   ": its localisation error is 0 in some direction; give it at least a trifle");
      const Jacobian j = JacobianAt(mapped_mm, result.error.centre_ct_mm);
      const Vector3d residual_mm = ct_mm.col(i) - mapped_mm;
      const Vector3d weighted = weight.solve(residual_mm);
      normal += j.transpose() * weight.solve(j);
      right += j.transpose() * weighted;
      result.chi_square += residual_mm.dot(weighted);
    }
    const Eigen::Matrix<double, 6, 1> step = normal.ldlt().solve(right);
    pose = Moved(pose, step, result.error.centre_ct_mm);
    if (step.head<3>().norm() * 1e3 + step.tail<3>().norm() < kConverged * 1e3) break;
  }
  result.error.covariance = normal.ldlt().solve(Matrix6::Identity());
  result.fit.residual_mm = ct_mm - pose * reference_mm;
  result.fit.fre_rms_mm =
      std::sqrt(result.fit.residual_mm.squaredNorm() / static_cast<double>(ct_mm.cols()));
  return result;
}

PoseError ErrorOfUnweightedFit(const transforms::Markers& reference_mm,
                               const Isometry3d& ct_from_reference,
                               const std::vector<MarkerNoise>& noise) {
  RequireNoise(noise, reference_mm.cols());
  const transforms::Markers mapped_mm = ct_from_reference * reference_mm;
  PoseError error;
  error.centre_ct_mm = mapped_mm.rowwise().mean();
  Matrix6 normal = Matrix6::Zero();
  Matrix6 spread = Matrix6::Zero();
  for (Index i = 0; i < mapped_mm.cols(); ++i) {
    const Jacobian j = JacobianAt(mapped_mm.col(i), error.centre_ct_mm);
    normal += j.transpose() * j;
    spread += j.transpose() *
              Covariance(noise[static_cast<std::size_t>(i)], ct_from_reference.linear()) * j;
  }
  const Matrix6 inverse = normal.ldlt().solve(Matrix6::Identity());
  error.covariance = inverse * spread * inverse;
  return error;
}

std::vector<MarkerNoise> IsotropicNoise(Index num_markers, double fle_rms_mm) {
  const Matrix3d covariance = fle_rms_mm * fle_rms_mm / 3.0 * Matrix3d::Identity();
  return std::vector<MarkerNoise>(
      static_cast<std::size_t>(num_markers),
      MarkerNoise{.reference_mm2 = Matrix3d::Zero(), .ct_mm2 = covariance});
}

}  // namespace acus::registration
