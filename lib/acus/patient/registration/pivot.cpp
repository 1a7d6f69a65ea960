#include "acus/patient/registration/pivot.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/csv.h"
#include "acus/base/core/error.h"
#include "acus/base/math/statistics.h"
#include "acus/data/transforms/transform_file.h"

namespace acus::registration {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Fewer poses than this share are not "the rest" that others do not fit to.
constexpr double kLeastUsedShare = 0.6;
/// Residuals of a pivoted tip are a small share of how far the marker moves.
constexpr double kMovedShare = 0.2;

constexpr double kShortestPointerMm = 2.0;  ///< From marker to tip: less are metres.
constexpr double kLongestPointerMm = 5000.0;
constexpr double kNearestToTrackerMm = 10.0;  ///< Coordinates below it are metres.

constexpr double kMinTiltRad = 3.0 * std::numbers::pi / 180.0;

/// Median length of a 3D normal vector with unit variance per axis.
constexpr double kMedianLength = 1.5381722544550522;

struct TipAndPivot {
  Vector3d tip_mm;
  Vector3d pivot_mm;
  Eigen::Vector3d turn;  ///< Eigenvalues of the normal matrix of the tip, smallest first; 0 to 1.
};

/// Weighted least squares of R_i tip + t_i = pivot. The pivot is eliminated first: it is the mean
/// of the left side. What remains for the tip is (I - mean(R)^T mean(R)) tip = ..., whose smallest
/// eigenvalue is about the squared turn angle that the weakest direction has seen.
TipAndPivot Solve(std::span<const Isometry3d> poses, const std::vector<double>& weights) {
  Matrix3d mean_rotation = Matrix3d::Zero();
  Vector3d mean_position = Vector3d::Zero();
  double total = 0.0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    mean_rotation += weights[i] * poses[i].linear();
    mean_position += weights[i] * poses[i].translation();
    total += weights[i];
  }
  mean_rotation /= total;
  mean_position /= total;
  Matrix3d normal = Matrix3d::Zero();
  Vector3d right = Vector3d::Zero();
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Matrix3d rotation = poses[i].linear() - mean_rotation;
    normal += weights[i] * rotation.transpose() * rotation;
    right -= weights[i] * rotation.transpose() * (poses[i].translation() - mean_position);
  }
  normal /= total;
  right /= total;
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(normal);
  TipAndPivot solution;
  solution.turn = solver.eigenvalues().cwiseMax(0.0);
  if (std::sqrt(solution.turn[0]) < kMinTiltRad) {
    throw NoAnswerError(Message(
        "the pointer turned by only ", std::sqrt(solution.turn[0]) * 180.0 / std::numbers::pi,
        " deg about some axis, at least ", kMinTiltRad * 180.0 / std::numbers::pi,
        " deg are needed; tilt it to all sides and spin it while the tip rests"));
  }
  solution.tip_mm = normal.ldlt().solve(right);
  solution.pivot_mm = mean_rotation * solution.tip_mm + mean_position;
  return solution;
}

std::vector<double> Residuals(std::span<const Isometry3d> poses, const TipAndPivot& solution) {
  std::vector<double> residual_mm(poses.size());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    residual_mm[i] = (poses[i] * solution.tip_mm - solution.pivot_mm).norm();
  }
  return residual_mm;
}

PivotCalibration FitUsed(std::span<const Isometry3d> poses, const std::vector<bool>& used) {
  std::vector<double> weights(used.begin(), used.end());
  const auto count = static_cast<double>(std::ranges::count(used, true));
  const TipAndPivot solution = Solve(poses, weights);
  PivotCalibration result;
  result.tip_mm = solution.tip_mm;
  result.pivot_mm = solution.pivot_mm;
  result.used = used;
  result.residual_mm = Residuals(poses, solution);
  double sum = 0.0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (used[i]) sum += result.residual_mm[i] * result.residual_mm[i];
  }
  result.residual_rms_mm = std::sqrt(sum / count);
  result.residual_coordinate_rms_mm = std::sqrt(sum / (3.0 * count));
  const double variance_mm2 = sum / std::max(1.0, 3.0 * count - 6.0);
  result.tip_sd_mm = (variance_mm2 / (count * solution.turn.array())).sqrt().matrix().reverse();
  result.tilt_deg =
      std::asin(std::min(1.0, std::sqrt(solution.turn[0]))) * 180.0 / std::numbers::pi;
  return result;
}

void RequirePoses(std::span<const Isometry3d> poses) {
  ACUS_REQUIRE(poses.size() >= 3, "pivot calibration needs at least 3 poses, got ", poses.size());
}

double UsedShare(const PivotCalibration& calibration) {
  return static_cast<double>(std::ranges::count(calibration.used, true)) /
         static_cast<double>(calibration.used.size());
}

/// RMS distance of the tool's origin from its mean position.
double OriginSpreadMm(std::span<const Isometry3d> poses) {
  Vector3d mean = Vector3d::Zero();
  for (const Isometry3d& pose : poses) mean += pose.translation();
  mean /= static_cast<double>(poses.size());
  double sum = 0.0;
  for (const Isometry3d& pose : poses) sum += (pose.translation() - mean).squaredNorm();
  return std::sqrt(sum / static_cast<double>(poses.size()));
}

Isometry3d PoseFromRow(const Vector3d& position_mm, const Eigen::Quaterniond& rotation,
                       const std::string& where) {
  ACUS_REQUIRE(std::abs(rotation.norm() - 1.0) <= 1e-3, where, ": the quaternion's length is ",
               rotation.norm(), ", not 1");
  Isometry3d pose = Isometry3d::Identity();
  pose.linear() = rotation.normalized().toRotationMatrix();
  pose.translation() = position_mm;
  return pose;
}

std::vector<Isometry3d> ReadStream(const std::filesystem::path& path) {
  const CsvTable table(path);
  std::vector<std::vector<double>> columns;
  for (const char* name : {"x_mm", "y_mm", "z_mm", "qw", "qx", "qy", "qz"}) {
    columns.push_back(table.Numbers(name));
  }
  std::vector<std::string> status(table.num_rows(), "OK");
  if (table.Has("status")) status = table.Texts("status");
  std::vector<Isometry3d> poses;
  for (std::size_t i = 0; i < table.num_rows(); ++i) {
    if (status[i] != "OK") continue;
    const auto at = [&](std::size_t column) { return columns[column][i]; };
    poses.push_back(
        PoseFromRow({at(0), at(1), at(2)}, {at(3), at(4), at(5), at(6)}, table.Where(i)));
  }
  return poses;
}

}  // namespace

PivotCalibration CalibratePivot(std::span<const Isometry3d> reference_from_tool) {
  RequirePoses(reference_from_tool);
  return FitUsed(reference_from_tool, std::vector<bool>(reference_from_tool.size(), true));
}

PivotCalibration CalibratePivotRobustly(std::span<const Isometry3d> reference_from_tool) {
  RequirePoses(reference_from_tool);
  // Least absolute residuals by reweighting: wrong poses lose their pull.
  std::vector<double> weights(reference_from_tool.size(), 1.0);
  std::vector<double> residual_mm;
  for (int iteration = 0; iteration < 100; ++iteration) {
    residual_mm = Residuals(reference_from_tool, Solve(reference_from_tool, weights));
    const double floor_mm = std::max(1e-9, 1e-3 * math::Median(residual_mm));
    for (std::size_t i = 0; i < weights.size(); ++i) {
      weights[i] = 1.0 / std::max(residual_mm[i], floor_mm);
    }
  }
  std::vector<bool> used(reference_from_tool.size(), true);
  for (int iteration = 0; iteration < 50; ++iteration) {
    std::vector<double> kept;
    for (std::size_t i = 0; i < used.size(); ++i) {
      if (used[i]) kept.push_back(residual_mm[i]);
    }
    const double limit_mm = 4.0 * math::Median(kept) / kMedianLength + 1e-6;
    std::vector<bool> next(used.size());
    for (std::size_t i = 0; i < used.size(); ++i) next[i] = residual_mm[i] <= limit_mm;
    if (std::ranges::count(next, true) < 3) break;
    const PivotCalibration result = FitUsed(reference_from_tool, next);
    if (next == used && iteration > 0) return result;
    used = next;
    residual_mm = result.residual_mm;
  }
  return FitUsed(reference_from_tool, used);
}

void RequirePivoted(const PivotCalibration& calibration, std::span<const Isometry3d> poses,
                    double limit_mm) {
  const double used = UsedShare(calibration);
  if (calibration.residual_rms_mm <= limit_mm && used >= kLeastUsedShare) return;
  const std::string what =
      Message("the tip varies by ", calibration.residual_rms_mm, " mm RMS about one point over ",
              std::lround(100.0 * used), " % of ", poses.size(), " poses (allowed: ", limit_mm,
              " mm, at least 60 %): ");
  const PivotCalibration robust = CalibratePivotRobustly(poses);
  const double spread_mm = OriginSpreadMm(poses);
  if (used == 1.0 && robust.residual_rms_mm <= limit_mm && UsedShare(robust) >= kLeastUsedShare) {
    throw NoAnswerError(Message(what, std::ranges::count(robust.used, false),
                                " poses do not fit the others, which "
                                "agree to ",
                                robust.residual_rms_mm, " mm; --robust leaves them out"));
  }
  if (calibration.residual_rms_mm > kMovedShare * spread_mm || used < kLeastUsedShare) {
    throw NoAnswerError(
        Message(what, "the pointer was moved, not pivoted (its marker moves by ", spread_mm,
                " mm RMS); record only the time in which the tip rests in one hole, and check "
                "--tool and --reference"));
  }
  throw NoAnswerError(Message(what,
                              "the tip slid, or the reference moved; press the tip into a small "
                              "hole and name the reference that is fixed to it (--reference); "
                              "--limit-mm accepts a tracker with larger errors"));
}

void RequireTipInMillimetres(const PivotCalibration& calibration,
                             std::span<const Isometry3d> poses) {
  double farthest_mm = 0.0;
  for (const Isometry3d& pose : poses) {
    farthest_mm = std::max(farthest_mm, pose.translation().cwiseAbs().maxCoeff());
  }
  const double tip_mm = calibration.tip_mm.norm();
  const double spread_mm = OriginSpreadMm(poses);
  // A tool that is calibrated already has its tip at 0, but far from the tracker.
  const bool in_metres = tip_mm < kShortestPointerMm && spread_mm < kShortestPointerMm &&
                         farthest_mm < kNearestToTrackerMm;
  const bool in_micrometres = tip_mm > kLongestPointerMm;
  ACUS_REQUIRE(!in_metres && !in_micrometres, "the tip is ", tip_mm,
               " mm from the marker, which moves by ", spread_mm, " mm and is up to ", farthest_mm,
               " mm away: are the poses in ", in_metres ? "metres" : "micrometres",
               "? They are needed in mm; --as-it-is takes them as they are");
}

std::vector<Isometry3d> ReadPoses(const std::filesystem::path& path) {
  if (path.extension() == ".csv") return ReadStream(path);
  std::vector<std::filesystem::path> files{path};
  if (std::filesystem::is_directory(path)) {
    files.clear();
    std::error_code error;
    for (const auto& entry : std::filesystem::directory_iterator(path, error)) {
      if (entry.path().extension() == ".txt") files.push_back(entry.path());
    }
    ACUS_REQUIRE(!error, path.string(), ": cannot be read: ", error.message());
    std::ranges::sort(files);
    ACUS_REQUIRE(!files.empty(), path.string(),
                 ": has no .txt file; poses are text files of 4 x 4 numbers");
  }
  std::vector<Isometry3d> poses;
  for (const auto& file : files) {
    poses.push_back(transforms::ParseRigidMatrix(ReadTextFile(file), file.string()));
  }
  return poses;
}

}  // namespace acus::registration
