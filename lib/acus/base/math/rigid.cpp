#include "acus/base/math/rigid.h"

#include <Eigen/SVD>
#include <cmath>

#include "acus/base/core/error.h"

namespace acus::math {

bool IsRigid(const Eigen::Matrix4d& matrix, double tolerance) {
  if (!matrix.allFinite()) return false;
  const Eigen::Matrix3d r = matrix.topLeftCorner<3, 3>();
  const double skew = (r.transpose() * r - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  const double last = (matrix.row(3) - Eigen::RowVector4d(0, 0, 0, 1)).cwiseAbs().maxCoeff();
  return skew <= tolerance && last <= tolerance && r.determinant() > 0.0;
}

Eigen::Isometry3d RigidFromMatrix(const Eigen::Matrix4d& matrix, double tolerance) {
  ACUS_REQUIRE(matrix.allFinite(), "the transform has a value that is not finite");
  ACUS_REQUIRE(IsRigid(matrix, tolerance),
               "the transform is not rigid (rotation plus translation in mm): R^T R differs from "
               "the identity by more than ",
               tolerance, " or it mirrors");
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(matrix.topLeftCorner<3, 3>(),
                                              Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Isometry3d rigid = Eigen::Isometry3d::Identity();
  rigid.linear() = svd.matrixU() * svd.matrixV().transpose();
  rigid.translation() = matrix.topRightCorner<3, 1>();
  return rigid;
}

Eigen::Isometry3d Interpolate(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b,
                              double fraction) {
  const Eigen::Quaterniond qa(a.linear());
  const Eigen::Quaterniond qb(b.linear());
  Eigen::Isometry3d out = Eigen::Isometry3d::Identity();
  out.linear() = qa.slerp(fraction, qb).normalized().toRotationMatrix();
  out.translation() = (1.0 - fraction) * a.translation() + fraction * b.translation();
  return out;
}

double AngleBetweenRad(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  return Eigen::Quaterniond(a.linear()).angularDistance(Eigen::Quaterniond(b.linear()));
}

Eigen::Isometry3d PoseFromAxes(const Eigen::Vector3d& origin_mm, const Eigen::Vector3d& z_axis,
                               const Eigen::Vector3d& x_hint) {
  ACUS_ASSERT(z_axis.norm() > 0.0);
  const Eigen::Vector3d z = z_axis.normalized();
  Eigen::Vector3d x = x_hint - x_hint.dot(z) * z;
  if (x.norm() < 1e-9 * (1.0 + x_hint.norm())) x = z.unitOrthogonal();
  x.normalize();
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() << x, z.cross(x), z;
  pose.translation() = origin_mm;
  return pose;
}

Eigen::Isometry3d RasFromLps(const Eigen::Isometry3d& lps_from_source_lps) {
  const Eigen::DiagonalMatrix<double, 3> flip(-1.0, -1.0, 1.0);
  Eigen::Isometry3d out = Eigen::Isometry3d::Identity();
  out.linear() = flip * lps_from_source_lps.linear() * flip;
  out.translation() = flip * lps_from_source_lps.translation();
  return out;
}

}  // namespace acus::math
