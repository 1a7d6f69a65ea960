#include "acus/patient/registration/surface_registration.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "acus/base/core/error.h"
#include "acus/base/core/parallel.h"
#include "acus/base/core/random.h"
#include "acus/base/core/text_table.h"
#include "acus/base/math/angles.h"
#include "acus/base/math/statistics.h"
#include "acus/data/mesh/nearest_triangle.h"

namespace acus::registration {
namespace {

using Eigen::Index;
using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Vector6 = Eigen::Matrix<double, 6, 1>;

constexpr Index kFewPoints = 300;  ///< For the first look at each start.
constexpr int kFewIterations = 30;
constexpr int kMostIcpIterations = 300;
constexpr double kConvergedMm = 1e-5;

void Check(const transforms::Markers& points_mm, const SurfaceSettings& s) {
  ACUS_REQUIRE(points_mm.cols() >= 12, "a surface registration needs at least 12 points, got ",
               points_mm.cols());
  ACUS_REQUIRE(points_mm.allFinite(), "a point is not finite");
  ACUS_REQUIRE(s.keep > 0.0 && s.keep <= 1.0, "the share of points kept must lie in (0, 1], got ",
               s.keep);
  ACUS_REQUIRE(s.num_starts >= 1 && s.num_starts <= 10000, "1 to 10000 starts are possible, got ",
               s.num_starts);
  ACUS_REQUIRE(s.start_mm >= 0.0 && s.start_deg >= 0.0, "the start's error must not be negative");
  ACUS_REQUIRE(s.least_hold > 0.0 && s.least_hold < 1.0, "the least hold must lie in (0, 1), got ",
               s.least_hold);
}

/// What the points see of the surface at a pose.
struct View {
  transforms::Markers placed_mm;
  transforms::Markers normals;  ///< Away from the surface, along which distances count.
  Eigen::VectorXd distance_mm;
  std::vector<bool> used;
};

/// One alternation from a start.
class Alternation {
 public:
  Alternation(const transforms::Markers& points_mm, const mesh::NearestTriangle& surface,
              double keep)
      : points_mm_(points_mm), surface_(surface), keep_(keep) {
    radius_mm_ = std::max(1e-6, SpreadMm(points_mm).norm());
  }

  double radius_mm() const { return radius_mm_; }

  View Look(const Isometry3d& pose) const {
    const Index n = points_mm_.cols();
    View view;
    view.placed_mm = pose * points_mm_;
    view.normals.resize(3, n);
    view.distance_mm.resize(n);
    for (Index i = 0; i < n; ++i) {
      const Vector3d x_mm = view.placed_mm.col(i);
      const mesh::NearestPoint nearest = surface_.Find(x_mm);
      const Vector3d off_mm = x_mm - nearest.point_mm;
      const double distance_mm = std::sqrt(nearest.squared_mm2);
      Vector3d normal = surface_.Normal(nearest.triangle);
      const double sign = off_mm.dot(normal) < 0.0 ? -1.0 : 1.0;
      // Far from the surface the way to it, near it the triangle's own normal.
      if (distance_mm > 1.0) normal = sign * off_mm / distance_mm;
      view.normals.col(i) = normal;
      view.distance_mm[i] = sign * distance_mm;
    }
    Trim(view);
    return view;
  }

  /// Gauss-Newton on the distances of the used points; about the centroid of the placed points.
  /// `hold` in [0, 1] also holds the points to their nearest places across the normals.
  Isometry3d Step(const View& view, const Isometry3d& pose, double hold) const {
    const Vector3d centre_mm = view.placed_mm.rowwise().mean();
    Matrix6 normal = Matrix6::Zero();
    Vector6 right = Vector6::Zero();
    for (Index i = 0; i < view.placed_mm.cols(); ++i) {
      if (!view.used[static_cast<std::size_t>(i)]) continue;
      const Vector6 j = Row(view, i, centre_mm);
      normal += j * j.transpose();
      right -= j * view.distance_mm[i];
      if (hold > 0.0) {
        const Vector3d arm = (view.placed_mm.col(i) - centre_mm) / radius_mm_;
        Eigen::Matrix<double, 3, 6> full;
        full << 0, arm.z(), -arm.y(), 1, 0, 0, -arm.z(), 0, arm.x(), 0, 1, 0, arm.y(), -arm.x(), 0,
            0, 0, 1;
        normal += hold * full.transpose() * full;
        right -= hold * full.transpose() * (view.distance_mm[i] * view.normals.col(i));
      }
    }
    normal += 1e-9 * normal.trace() * Matrix6::Identity();
    const Vector6 step = normal.ldlt().solve(right);
    const Vector3d turn = step.head<3>() / radius_mm_;
    Isometry3d delta = Isometry3d::Identity();
    if (turn.norm() > 0.0) {
      const double angle = std::min(turn.norm(), 0.5);
      delta.linear() = Eigen::AngleAxisd(angle, turn.normalized()).toRotationMatrix();
    }
    delta.translation() = centre_mm - delta.linear() * centre_mm + step.tail<3>();
    Isometry3d moved = delta * pose;
    moved.linear() = Eigen::Quaterniond(moved.linear()).normalized().toRotationMatrix();
    return moved;
  }

  struct Result {
    Isometry3d pose = Isometry3d::Identity();
    double rms_mm = 0.0;
    int iterations = 0;
    bool converged = false;
  };

  Result Run(const Isometry3d& start, int most) const {
    Result result{.pose = start, .rms_mm = 0.0, .iterations = 0, .converged = false};
    while (result.iterations < most && !result.converged) {
      const View view = Look(result.pose);
      const double hold = result.iterations < 10 ? 0.2 : 0.0;
      const Isometry3d next = Step(view, result.pose, hold);
      const transforms::Markers moved_mm = next * points_mm_ - view.placed_mm;
      result.pose = next;
      ++result.iterations;
      result.converged = hold == 0.0 && moved_mm.colwise().norm().maxCoeff() < kConvergedMm;
    }
    result.rms_mm = RmsMm(Look(result.pose));
    return result;
  }

  static double RmsMm(const View& view) {
    double sum = 0.0, count = 0.0;
    for (Index i = 0; i < view.distance_mm.size(); ++i) {
      if (!view.used[static_cast<std::size_t>(i)]) continue;
      sum += view.distance_mm[i] * view.distance_mm[i];
      count += 1.0;
    }
    return std::sqrt(sum / count);
  }

  /// Derivative of a distance by (turn about the centre at the points' radius, shift), per mm.
  Vector6 Row(const View& view, Index i, const Vector3d& centre_mm) const {
    const Vector3d normal = view.normals.col(i);
    const Vector3d arm = (view.placed_mm.col(i) - centre_mm) / radius_mm_;
    Vector6 j;
    j << arm.cross(normal), normal;
    return j;
  }

 private:
  void Trim(View& view) const {
    const Index n = view.distance_mm.size();
    std::vector<double> size_mm(static_cast<std::size_t>(n));
    for (Index i = 0; i < n; ++i)
      size_mm[static_cast<std::size_t>(i)] = std::abs(view.distance_mm[i]);
    const double limit_mm = math::Quantile(size_mm, keep_);
    view.used.resize(size_mm.size());
    for (std::size_t i = 0; i < size_mm.size(); ++i) view.used[i] = size_mm[i] <= limit_mm;
  }

  const transforms::Markers& points_mm_;
  const mesh::NearestTriangle& surface_;
  double keep_;
  double radius_mm_ = 1.0;
};

Matrix3d RandomTurn(RandomStream& random) {
  Eigen::Vector4d q;
  for (double& x : q) x = random.Normal();
  return Eigen::Quaterniond(q.normalized()).toRotationMatrix();
}

/// The start itself, and others around it; without a start, orientations from everywhere.
std::vector<Isometry3d> Starts(const transforms::Markers& points_mm, const mesh::Surface& surface,
                               const std::optional<Isometry3d>& start,
                               const SurfaceSettings& settings) {
  const Vector3d points_centre_mm = points_mm.rowwise().mean();
  const Vector3d surface_centre_mm = surface.nodes_mm.rowwise().mean();
  const double size_mm = SpreadMm(surface.nodes_mm).norm();
  RandomStream random(1, "starts of a surface registration");
  std::vector<Isometry3d> starts;
  for (int k = 0; k < settings.num_starts; ++k) {
    Isometry3d pose = Isometry3d::Identity();
    if (start) {
      pose = *start;
      if (k > 0) {
        const Vector3d axis = RandomTurn(random).col(0);
        const double angle = random.Uniform(-1.0, 1.0) * settings.start_deg * math::kRadPerDegree;
        const Vector3d centre_mm = pose * points_centre_mm;
        const Vector3d shift_mm = settings.start_mm * random.Uniform() * RandomTurn(random).col(0);
        pose = Eigen::Translation3d(centre_mm + shift_mm) * Eigen::AngleAxisd(angle, axis) *
               Eigen::Translation3d(-centre_mm) * pose;
      }
    } else {
      pose.linear() = k == 0 ? Matrix3d(Matrix3d::Identity()) : RandomTurn(random);
      // Swept points lie on one side: their centroid is between the surface's and its skin.
      const Vector3d aside_mm =
          k == 0 ? Vector3d(Vector3d::Zero())
                 : Vector3d(0.5 * size_mm * random.Uniform() * RandomTurn(random).col(0));
      pose.translation() = surface_centre_mm + aside_mm - pose.linear() * points_centre_mm;
    }
    starts.push_back(pose);
  }
  return starts;
}

std::string DirectionText(const Vector3d& v) {
  const Vector3d unit = v.normalized();
  return Message("(", FixedText(unit.x(), 2), ", ", FixedText(unit.y(), 2), ", ",
                 FixedText(unit.z(), 2), ")");
}

std::vector<FreeMotion> Motions(const Alternation& alternation, const View& view,
                                Matrix6& information) {
  const Vector3d centre_mm = view.placed_mm.rowwise().mean();
  Matrix6 off = Matrix6::Zero();
  Matrix6 moved = Matrix6::Zero();
  double count = 0.0;
  for (Index i = 0; i < view.placed_mm.cols(); ++i) {
    if (!view.used[static_cast<std::size_t>(i)]) continue;
    const Vector6 j = alternation.Row(view, i, centre_mm);
    off += j * j.transpose();
    const Vector3d arm = (view.placed_mm.col(i) - centre_mm) / alternation.radius_mm();
    Eigen::Matrix<double, 3, 6> full;
    full << 0, arm.z(), -arm.y(), 1, 0, 0, -arm.z(), 0, arm.x(), 0, 1, 0, arm.y(), -arm.x(), 0, 0,
        0, 1;
    moved += full.transpose() * full;
    count += 1.0;
  }
  information = off;
  moved += 1e-12 * moved.trace() * Matrix6::Identity();
  const Eigen::GeneralizedSelfAdjointEigenSolver<Matrix6> solver(off, moved);
  std::vector<FreeMotion> motions;
  for (int k = 0; k < 6; ++k) {
    // The eigenvectors have v^T moved v = 1: scaled to 1 mm RMS.
    const Vector6 v = solver.eigenvectors().col(k) * std::sqrt(count);
    FreeMotion motion;
    motion.turn_deg = v.head<3>() / alternation.radius_mm() / math::kRadPerDegree;
    motion.shift_mm = v.tail<3>();
    motion.hold = std::sqrt(std::max(0.0, solver.eigenvalues()[k]));
    const double turning = v.head<3>().norm();
    motion.text = turning > v.tail<3>().norm() ? "turning about " + DirectionText(motion.turn_deg)
                                               : "sliding along " + DirectionText(motion.shift_mm);
    motions.push_back(motion);
  }
  return motions;
}

/// Covariance of (turn in rad, shift) about the centroid, from the scatter of the distances.
PoseError ErrorOf(const Alternation& alternation, const View& view, const Matrix6& information) {
  std::vector<double> size_mm;
  for (Index i = 0; i < view.distance_mm.size(); ++i)
    size_mm.push_back(std::abs(view.distance_mm[i]));
  const double sd_mm = 1.4826 * math::Median(size_mm);
  PoseError error;
  error.centre_ct_mm = view.placed_mm.rowwise().mean();
  Vector6 unit = Vector6::Ones();
  unit.head<3>().setConstant(1.0 / alternation.radius_mm());
  error.covariance = unit.asDiagonal() * information.ldlt().solve(Matrix6::Identity()) *
                     unit.asDiagonal() * (sd_mm * sd_mm);
  return error;
}

void RequireHold(const std::vector<FreeMotion>& motions, double least) {
  std::string free;
  for (const FreeMotion& motion : motions) {
    if (motion.hold < least) free += (free.empty() ? "" : "; ") + motion.text;
  }
  if (free.empty()) return;
  throw NoAnswerError(
      Message("the points do not determine the pose on this surface. Free to move: ", free,
              " (CT axes, about the points' centroid); sweep over parts that "
              "are curved otherwise, such as flanks, ribs and navel, or add landmarks"));
}

transforms::Markers Thinned(const transforms::Markers& points_mm, Index most) {
  const Index step = std::max<Index>(1, (points_mm.cols() + most - 1) / most);
  transforms::Markers few(3, (points_mm.cols() + step - 1) / step);
  for (Index i = 0; i < few.cols(); ++i) few.col(i) = points_mm.col(i * step);
  return few;
}

}  // namespace

SurfaceFit RegisterToSurface(const transforms::Markers& points_mm, const mesh::Surface& surface_ct,
                             const std::optional<Isometry3d>& start,
                             const SurfaceSettings& settings, const RunContext& context) {
  Check(points_mm, settings);
  const mesh::NearestTriangle surface(surface_ct);
  const transforms::Markers few_mm = Thinned(points_mm, kFewPoints);
  const Alternation first_look(few_mm, surface, settings.keep);
  const auto starts = Starts(points_mm, surface_ct, start, settings);
  std::vector<Alternation::Result> looked(starts.size());
  context.Checkpoint("surface registration", 0.0);
  ParallelFor(static_cast<int>(starts.size()), context.num_threads, [&](int i) {
    const auto k = static_cast<std::size_t>(i);
    looked[k] = first_look.Run(starts[k], kFewIterations);
  });
  std::ranges::stable_sort(looked, {}, &Alternation::Result::rms_mm);
  context.Checkpoint("surface registration", 0.5);
  const Alternation alternation(points_mm, surface, settings.keep);
  const auto best = alternation.Run(looked.front().pose, kMostIcpIterations);
  SurfaceFit fit;
  fit.ct_from_reference = best.pose;
  fit.num_iterations = best.iterations;
  const View view = alternation.Look(best.pose);
  fit.distance_mm = view.distance_mm;
  fit.used = view.used;
  fit.rms_mm = best.rms_mm;
  Matrix6 information;
  fit.motions = Motions(alternation, view, information);
  RequireHold(fit.motions, settings.least_hold);
  fit.error = ErrorOf(alternation, view, information);
  for (const auto& other : looked) {
    const double apart_mm = (other.pose * few_mm - best.pose * few_mm).colwise().norm().maxCoeff();
    const bool elsewhere = apart_mm > std::max(5.0, 10.0 * fit.rms_mm);
    if (!elsewhere || other.rms_mm > 1.2 * std::max(fit.rms_mm, 0.05)) continue;
    fit.rival_mm = apart_mm;
    break;
  }
  context.Checkpoint("surface registration", 1.0);
  return fit;
}

}  // namespace acus::registration
