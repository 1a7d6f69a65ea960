#include "acus/patient/registration/hand_eye.h"

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "acus/base/core/error.h"
#include "acus/base/math/angles.h"
#include "acus/base/math/covariance.h"
#include "acus/base/math/statistics.h"

namespace acus::registration {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Poses = std::span<const Isometry3d>;
using Matrix12 = Eigen::Matrix<double, 12, 12>;
using Vector12 = Eigen::Matrix<double, 12, 1>;

constexpr double kLeastTurnDeg = 5.0;
/// Share of the pairs that must agree.
constexpr double kLeastUsedPairs = 0.6;

Matrix3d Cross(const Vector3d& v) {
  Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

Vector3d LogOf(const Matrix3d& rotation) {
  const Eigen::AngleAxisd turn(rotation);
  return turn.angle() * turn.axis();
}

Matrix3d ExpOf(const Vector3d& turn) {
  const double angle = turn.norm();
  if (angle < 1e-300) return Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix();
}

/// The rotation nearest to a matrix.
Matrix3d NearestRotation(const Matrix3d& matrix) {
  const Eigen::JacobiSVD<Matrix3d> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Vector3d sign(1, 1, (svd.matrixU() * svd.matrixV().transpose()).determinant());
  return svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
}

/// RMS turn in the direction that turned least, degrees: the middle eigenvalue of the scatter of
/// rotation axes, since turning about two axes is enough.
double WeakTurnDeg(Poses poses) {
  Matrix3d scatter = Matrix3d::Zero();
  // Against every eighth or so pose, so that long runs stay linear.
  const std::size_t step = std::max<std::size_t>(1, poses.size() / 8);
  double count = 0.0;
  for (std::size_t j = 0; j < poses.size(); j += step) {
    for (const Isometry3d& pose : poses) {
      const Vector3d turn = LogOf(poses[j].linear().transpose() * pose.linear());
      scatter += turn * turn.transpose();
      count += 1.0;
    }
  }
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(scatter / count, Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(0.0, solver.eigenvalues()[1])) / math::kRadPerDegree;
}

void RequireTurns(double turn_deg) {
  if (turn_deg >= kLeastTurnDeg) return;
  throw NoAnswerError(Message("beside its main axis the body turned by only ", turn_deg,
                              " deg, at least ", kLeastTurnDeg,
                              " deg are needed: along the axis of all turns the calibration could "
                              "slide; turn the handle about two different axes"));
}

/// Rotations of X and Z: R_A R_X = R_Z R_B for all pairs, weighted.
void SolveRotations(Poses a, Poses b, const std::vector<double>& weights, Matrix3d& x,
                    Matrix3d& z) {
  Eigen::Matrix<double, 9, 9> sum = Eigen::Matrix<double, 9, 9>::Zero();
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) {
        sum.block<3, 3>(3 * r, 3 * c) += weights[i] * b[i].linear()(r, c) * a[i].linear();
      }
    }
  }
  // vec(R_Z) is along sum vec(R_X): the largest pair of singular vectors.
  const Eigen::JacobiSVD<Eigen::Matrix<double, 9, 9>> svd(
      sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Matrix<double, 9, 1> u = svd.matrixU().col(0);
  const Eigen::Matrix<double, 9, 1> v = svd.matrixV().col(0);
  Matrix3d z_like = Eigen::Map<const Matrix3d>(u.data());
  Matrix3d x_like = Eigen::Map<const Matrix3d>(v.data());
  if (x_like.determinant() < 0.0) {
    z_like = -z_like;
    x_like = -x_like;
  }
  x = NearestRotation(x_like);
  z = NearestRotation(z_like);
}

/// R_A t_X - t_Z = R_Z t_B - t_A.
void SolveTranslations(Poses a, Poses b, const std::vector<double>& weights, Isometry3d& x,
                       Isometry3d& z) {
  Eigen::Matrix<double, 6, 6> normal = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Matrix<double, 6, 1> right = Eigen::Matrix<double, 6, 1>::Zero();
  for (std::size_t i = 0; i < a.size(); ++i) {
    Eigen::Matrix<double, 3, 6> row;
    row << a[i].linear(), -Matrix3d::Identity();
    const Vector3d value = z.linear() * b[i].translation() - a[i].translation();
    normal += weights[i] * row.transpose() * row;
    right += weights[i] * row.transpose() * value;
  }
  const Eigen::Matrix<double, 6, 1> solution = normal.ldlt().solve(right);
  x.translation() = solution.head<3>();
  z.translation() = solution.tail<3>();
}

struct Difference {
  Vector3d turn;      ///< rad.
  Vector3d shift_mm;  ///< Of the marker's origin.
};

Difference DifferenceOf(const Isometry3d& a, const Isometry3d& b, const Isometry3d& x,
                        const Isometry3d& z) {
  const Isometry3d left = a * x;
  const Isometry3d right = z * b;
  return {.turn = LogOf(right.linear().transpose() * left.linear()),
          .shift_mm = left.translation() - right.translation()};
}

/// One weighted Gauss-Newton step; returns the normal matrix.
Matrix12 Refine(Poses a, Poses b, const std::vector<double>& weights, double arm_mm, Isometry3d& x,
                Isometry3d& z) {
  Matrix12 normal = Matrix12::Zero();
  Vector12 right = Vector12::Zero();
  for (std::size_t i = 0; i < a.size(); ++i) {
    const Difference d = DifferenceOf(a[i], b[i], x, z);
    // Parameters: X turned by w_x on the right, moved by t_x; Z turned by w_z on the left, moved.
    Eigen::Matrix<double, 6, 12> j = Eigen::Matrix<double, 6, 12>::Zero();
    j.block<3, 3>(0, 0) = arm_mm * Matrix3d::Identity();
    j.block<3, 3>(0, 6) = -arm_mm * (z.linear() * b[i].linear()).transpose();
    j.block<3, 3>(3, 3) = a[i].linear();
    j.block<3, 3>(3, 6) = Cross(z.linear() * b[i].translation());
    j.block<3, 3>(3, 9) = -Matrix3d::Identity();
    Eigen::Matrix<double, 6, 1> residual;
    residual << arm_mm * d.turn, d.shift_mm;
    normal += weights[i] * j.transpose() * j;
    right -= weights[i] * j.transpose() * residual;
  }
  const Vector12 step = normal.ldlt().solve(right);
  x.linear() = NearestRotation(x.linear() * ExpOf(step.segment<3>(0)));
  x.translation() += step.segment<3>(3);
  z.linear() = NearestRotation(ExpOf(step.segment<3>(6)) * z.linear());
  z.translation() += step.segment<3>(9);
  return normal;
}

std::vector<double> Residuals(Poses a, Poses b, double arm_mm, const HandEye& result) {
  std::vector<double> residual_mm(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    const Difference d =
        DifferenceOf(a[i], b[i], result.handle_from_marker, result.device_from_tracker);
    residual_mm[i] = std::sqrt(d.shift_mm.squaredNorm() + (arm_mm * d.turn).squaredNorm());
  }
  return residual_mm;
}

void Finish(Poses a, Poses b, double arm_mm, const Matrix12& normal, HandEye& result) {
  result.residual_mm = Residuals(a, b, arm_mm, result);
  double shift2 = 0.0, turn2 = 0.0, sum = 0.0, count = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (!result.used[i]) continue;
    const Difference d =
        DifferenceOf(a[i], b[i], result.handle_from_marker, result.device_from_tracker);
    shift2 += d.shift_mm.squaredNorm();
    turn2 += d.turn.squaredNorm();
    sum += result.residual_mm[i] * result.residual_mm[i];
    count += 1.0;
  }
  result.rms_mm = std::sqrt(shift2 / count);
  result.rms_deg = std::sqrt(turn2 / count) / math::kRadPerDegree;
  const Matrix12 covariance =
      sum / std::max(1.0, 6.0 * count - 12.0) * normal.ldlt().solve(Matrix12::Identity());
  result.handle_sd_mm = math::PrincipalDeviations(covariance.block<3, 3>(3, 3));
  result.device_sd_mm = math::PrincipalDeviations(covariance.block<3, 3>(9, 9));
}

}  // namespace

HandEye CalibrateHandEye(Poses device_from_handle, Poses tracker_from_marker, double arm_mm) {
  ACUS_REQUIRE(device_from_handle.size() == tracker_from_marker.size(), "there are ",
               device_from_handle.size(), " poses of the handle, but ", tracker_from_marker.size(),
               " of the marker; each needs its partner of the same moment");
  ACUS_REQUIRE(device_from_handle.size() >= 4,
               "a hand-eye calibration needs at least 4 pairs of poses, got ",
               device_from_handle.size());
  HandEye result;
  result.turn_deg = WeakTurnDeg(device_from_handle);
  RequireTurns(std::min(result.turn_deg, WeakTurnDeg(tracker_from_marker)));
  std::vector<double> weights(device_from_handle.size(), 1.0);
  Matrix12 normal = Matrix12::Zero();
  Isometry3d& x = result.handle_from_marker;
  Isometry3d& z = result.device_from_tracker;
  // Least absolute residuals first, by reweighting: wrong pairs lose their pull.
  Matrix3d x_turn, z_turn;
  for (int iteration = 0; iteration < 30; ++iteration) {
    SolveRotations(device_from_handle, tracker_from_marker, weights, x_turn, z_turn);
    x.linear() = x_turn;
    z.linear() = z_turn;
    SolveTranslations(device_from_handle, tracker_from_marker, weights, x, z);
    const auto residual_mm = Residuals(device_from_handle, tracker_from_marker, arm_mm, result);
    const double floor_mm = std::max(1e-9, 0.1 * math::Median(residual_mm));
    for (std::size_t i = 0; i < weights.size(); ++i) {
      weights[i] = 1.0 / std::max(residual_mm[i], floor_mm);
    }
  }
  result.used.assign(weights.size(), true);
  for (int iteration = 0; iteration < 10; ++iteration) {
    const auto residual_mm = Residuals(device_from_handle, tracker_from_marker, arm_mm, result);
    const double limit_mm = 3.5 * math::Median(residual_mm) + 1e-6;
    for (std::size_t i = 0; i < weights.size(); ++i) {
      result.used[i] = residual_mm[i] <= limit_mm;
      weights[i] = result.used[i] ? 1.0 : 0.0;
    }
    for (int step = 0; step < 5; ++step) {
      normal = Refine(device_from_handle, tracker_from_marker, weights, arm_mm, x, z);
    }
  }
  Finish(device_from_handle, tracker_from_marker, arm_mm, normal, result);
  return result;
}

void RequireOneBody(const HandEye& result, double limit_mm) {
  const auto used = static_cast<double>(std::ranges::count(result.used, true)) /
                    static_cast<double>(result.used.size());
  if (result.rms_mm <= limit_mm && used >= kLeastUsedPairs) return;
  throw NoAnswerError(Message(
      "the two sets of poses do not belong to one rigid body: ", result.rms_mm, " mm and ",
      result.rms_deg, " deg RMS remain over ", std::lround(100.0 * used), " % of ",
      result.used.size(), " pairs (allowed: ", limit_mm,
      " mm, at least 60 %); probably the pairs are not of the same moments, another tool was "
      "tracked, or the marker moved on its body"));
}

Isometry3d SolveAxXb(Poses handle_motion, Poses marker_motion) {
  ACUS_REQUIRE(handle_motion.size() == marker_motion.size() && handle_motion.size() >= 2,
               "at least 2 pairs of motions are needed, got ", handle_motion.size(), " and ",
               marker_motion.size());
  Matrix3d product = Matrix3d::Zero();
  Matrix3d scatter = Matrix3d::Zero();
  for (std::size_t i = 0; i < handle_motion.size(); ++i) {
    const Vector3d alpha = LogOf(handle_motion[i].linear());
    const Vector3d beta = LogOf(marker_motion[i].linear());
    product += alpha * beta.transpose();
    scatter += alpha * alpha.transpose() / static_cast<double>(handle_motion.size());
  }
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(scatter, Eigen::EigenvaluesOnly);
  RequireTurns(std::sqrt(std::max(0.0, solver.eigenvalues()[1])) / math::kRadPerDegree);
  Isometry3d x = Isometry3d::Identity();
  x.linear() = NearestRotation(product);
  Matrix3d normal = Matrix3d::Zero();
  Vector3d right = Vector3d::Zero();
  for (std::size_t i = 0; i < handle_motion.size(); ++i) {
    const Matrix3d row = handle_motion[i].linear() - Matrix3d::Identity();
    normal += row.transpose() * row;
    right += row.transpose() *
             (x.linear() * marker_motion[i].translation() - handle_motion[i].translation());
  }
  x.translation() = normal.ldlt().solve(right);
  return x;
}

}  // namespace acus::registration
