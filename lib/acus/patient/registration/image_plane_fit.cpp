#include "acus/patient/registration/image_plane_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/SVD>
#include <algorithm>
#include <ceres/ceres.h>
#include <ceres/rotation.h>
#include <cmath>
#include <map>

#include "acus/base/core/error.h"
#include "acus/base/math/statistics.h"

namespace acus::registration {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr std::size_t kNumParameters = 8;
constexpr double kOutlierDeviations = 5.0;
constexpr double kMedianMagnitude = 0.6744897501960817;  ///< Of a normal variable, unit variance.
/// Rounding is no outlier: pixels, or mm.
constexpr double kLeastDeviation = 2e-4;
/// A wire that runs within the image's plane is cut nowhere.
constexpr double kLeastSine = 1e-6;

template <class T>
using Vec3 = Eigen::Matrix<T, 3, 1>;

/// The axes after a change by parameters[3..5].
template <class T>
Eigen::Matrix<T, 3, 3> AxesOf(const Matrix3d& axes, const T* parameters) {
  Eigen::Matrix<T, 3, 3> turn;
  ceres::AngleAxisToRotationMatrix(parameters + 3, turn.data());  // Column by column, as Eigen.
  return turn * axes.cast<T>();
}

/// Where the image cuts the wire, minus where it shows it; pixels.
struct WireCost {
  Matrix3d axes;
  PlanePoint point;

  template <class T>
  bool operator()(const T* parameters, T* residual) const {
    const Eigen::Matrix<T, 3, 3> axes_now = AxesOf(axes, parameters);
    const Vec3<T> origin(parameters[0], parameters[1], parameters[2]);
    const Vec3<T> place = axes_now.transpose() * (point.place_mm.cast<T>() - origin);
    const Vec3<T> direction = axes_now.transpose() * point.direction.cast<T>();
    using std::abs;
    if (abs(direction.z()) < T(kLeastSine)) return false;
    const T along = -place.z() / direction.z();
    residual[0] = (place.x() + along * direction.x()) / parameters[6] - T(point.point_px.x());
    residual[1] = (place.y() + along * direction.y()) / parameters[7] - T(point.point_px.y());
    return true;
  }
};

/// Where the pixel is, minus the place; mm.
struct PlaceCost {
  Matrix3d axes;
  PlanePoint point;

  template <class T>
  bool operator()(const T* parameters, T* residual) const {
    const Vec3<T> in_image(parameters[6] * T(point.point_px.x()),
                           parameters[7] * T(point.point_px.y()), T(0.0));
    const Vec3<T> place = AxesOf(axes, parameters) * in_image;
    for (int i = 0; i < 3; ++i) residual[i] = parameters[i] + place[i] - T(point.place_mm[i]);
    return true;
  }
};

using Cost = std::unique_ptr<ceres::CostFunction>;

Cost CostOf(const Matrix3d& axes, const PlanePoint& point) {
  if (point.is_wire) {
    return std::make_unique<ceres::AutoDiffCostFunction<WireCost, 2, 8>>(new WireCost{axes, point});
  }
  return std::make_unique<ceres::AutoDiffCostFunction<PlaceCost, 3, 8>>(new PlaceCost{axes, point});
}

void RequireCut(bool is_cut) {
  if (is_cut) return;
  throw NoAnswerError("a wire lies within the plane of an image; record images across the wires");
}

/// Residuals and their derivatives, 2 or 3 rows of it.
struct Row {
  VectorXd residual;
  Eigen::Matrix<double, Eigen::Dynamic, 8, Eigen::RowMajor> jacobian;
};

Row RowOf(const ceres::CostFunction& cost, const PlaneVector& parameters) {
  Row row{VectorXd::Zero(cost.num_residuals()), {}};
  row.jacobian.resize(cost.num_residuals(), 8);
  const double* blocks[] = {parameters.data()};
  double* jacobians[] = {row.jacobian.data()};
  RequireCut(cost.Evaluate(blocks, row.residual.data(), jacobians));
  return row;
}

/// The fit of one set of points, with axes that stay those of the start.
class PlaneSolver {
 public:
  PlaneSolver(const std::vector<PlanePoint>& points, const ImagePlane& start)
      : points_(points), axes_(start.axes) {
    parameters_ << start.origin_mm, Vector3d::Zero(), start.mm_per_px;
    for (const PlanePoint& point : points) costs_.push_back(CostOf(start.axes, point));
  }

  /// @param loss_scale  Of a Cauchy loss; 0: none.
  void Solve(const std::vector<bool>& used, double loss_scale) {
    ceres::Problem::Options problem_options;
    problem_options.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    problem_options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    ceres::CauchyLoss cauchy(std::max(loss_scale, kLeastDeviation));
    ceres::Problem problem(problem_options);
    for (std::size_t i = 0; i < points_.size(); ++i) {
      if (!used[i]) continue;
      problem.AddResidualBlock(costs_[i].get(), loss_scale > 0.0 ? &cauchy : nullptr,
                               parameters_.data());
    }
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::DENSE_QR;
    options.num_threads = 1;  // More threads would sum in another order: other last bits.
    options.max_num_iterations = 100;
    options.function_tolerance = 1e-12;
    options.parameter_tolerance = 1e-12;
    options.gradient_tolerance = 1e-14;
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    if (summary.IsSolutionUsable() && parameters_.tail<2>().minCoeff() > 0.0) return;
    throw NoAnswerError(Message("the calibration does not converge: ", summary.message,
                                "; check the names of the wires and the phantom's pose"));
  }

  /// In the axes of the image: columns, rows, out of the plane.
  std::vector<Vector3d> Residuals() const {
    std::vector<Vector3d> residuals;
    const double* blocks[] = {parameters_.data()};
    const Matrix3d axes = Plane().axes;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      Vector3d residual = Vector3d::Zero();
      RequireCut(costs_[i]->Evaluate(blocks, residual.data(), nullptr));
      residuals.emplace_back(points_[i].is_wire ? residual : Vector3d(axes.transpose() * residual));
    }
    return residuals;
  }

  PlaneFit Fit(const std::vector<bool>& used) const {
    PlaneFit fit;
    fit.plane = Plane();
    fit.used = used;
    fit.residuals = Residuals();
    std::map<std::size_t, std::vector<Row>> clusters;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      if (!used[i]) continue;
      Row row = RowOf(*costs_[i], parameters_);
      fit.normal += row.jacobian.transpose() * row.jacobian;
      clusters[points_[i].cluster].push_back(std::move(row));
    }
    fit.num_clusters = clusters.size();
    fit.covariance = Jackknife(clusters, fit.normal);
    return fit;
  }

 private:
  ImagePlane Plane() const {
    return {AxesOf(axes_, parameters_.data()), parameters_.head<3>(), parameters_.tail<2>()};
  }

  /// What leaving each cluster out would change, to first order.
  static PlaneMatrix Jackknife(const std::map<std::size_t, std::vector<Row>>& clusters,
                               const PlaneMatrix& normal) {
    const Eigen::LDLT<PlaneMatrix> solver(normal);
    PlaneMatrix sum = PlaneMatrix::Zero();
    for (const auto& [number, rows] : clusters) {
      Eigen::Index size = 0;
      for (const Row& row : rows) size += row.residual.size();
      MatrixXd jacobian(size, 8);
      VectorXd residual(size);
      Eigen::Index at = 0;
      for (const Row& row : rows) {
        jacobian.middleRows(at, row.residual.size()) = row.jacobian;
        residual.segment(at, row.residual.size()) = row.residual;
        at += row.residual.size();
      }
      const MatrixXd rest =
          MatrixXd::Identity(size, size) - jacobian * solver.solve(MatrixXd(jacobian.transpose()));
      const VectorXd predicted = rest.completeOrthogonalDecomposition().solve(residual);
      const PlaneVector change = solver.solve(PlaneVector(jacobian.transpose() * predicted));
      sum += change * change.transpose();
    }
    const auto count = static_cast<double>(clusters.size());
    return (count - 1.0) / count * sum;
  }

  const std::vector<PlanePoint>& points_;
  Matrix3d axes_;
  PlaneVector parameters_;
  std::vector<Cost> costs_;
};

double MedianLength(const std::vector<Vector3d>& residuals) {
  std::vector<double> lengths;
  for (const Vector3d& residual : residuals) lengths.push_back(residual.norm());
  return math::Median(lengths);
}

/// Standard deviations of the residuals used along each axis: by their medians, which outliers do
/// not move, or by their squares, which scatter less where there are no outliers left.
Vector3d Deviations(const std::vector<Vector3d>& residuals, const std::vector<bool>& used,
                    bool by_medians) {
  constexpr double kParametersPerAxis = 8.0 / 3.0;
  Vector3d deviations;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> magnitudes;
    for (std::size_t i = 0; i < used.size(); ++i) {
      if (used[i]) magnitudes.push_back(std::abs(residuals[i][axis]));
    }
    const auto count = static_cast<double>(magnitudes.size());
    const double freedom = std::max(1.0, count - kParametersPerAxis);
    const double deviation = by_medians
                                 ? math::Median(magnitudes) / kMedianMagnitude
                                 : math::RootMeanSquare(magnitudes) * std::sqrt(count / freedom);
    deviations[axis] = std::max(kLeastDeviation, deviation);
  }
  return deviations;
}

/// Affine least squares with weights: columns are the axes of u, of v, and the origin.
Matrix3d AffineOf(const std::vector<Vector2d>& points_px, const std::vector<Vector3d>& places_mm,
                  const std::vector<double>& weights) {
  const auto count = static_cast<Eigen::Index>(points_px.size());
  MatrixXd left(count, 3);
  MatrixXd right(count, 3);
  for (Eigen::Index i = 0; i < count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const double root = std::sqrt(weights[k]);
    left.row(i) << root * points_px[k].x(), root * points_px[k].y(), root;
    right.row(i) = root * places_mm[k].transpose();
  }
  return left.colPivHouseholderQr().solve(right).transpose();
}

}  // namespace

Vector3d ImagePlane::At(const Vector2d& point_px) const {
  return origin_mm + axes.leftCols<2>() * mm_per_px.cwiseProduct(point_px);
}

Eigen::Matrix<double, 3, 8> PlaneFit::JacobianAt(const Vector2d& point_px) const {
  PlaneVector parameters;
  parameters << plane.origin_mm, Vector3d::Zero(), plane.mm_per_px;
  const Cost cost = CostOf(plane.axes, {.cluster = 0, .point_px = point_px, .is_wire = false});
  return RowOf(*cost, parameters).jacobian;
}

ImagePlane LinearPlane(const std::vector<Vector2d>& points_px,
                       const std::vector<Vector3d>& places_mm) {
  std::vector<double> weights(points_px.size(), 1.0);
  std::vector<double> distance_mm(points_px.size());
  Matrix3d affine;
  for (int iteration = 0; iteration < 100; ++iteration) {
    affine = AffineOf(points_px, places_mm, weights);
    for (std::size_t i = 0; i < weights.size(); ++i) {
      distance_mm[i] = (affine * points_px[i].homogeneous() - places_mm[i]).norm();
    }
    const double floor_mm = std::max(1e-9, 1e-3 * math::Median(distance_mm));
    for (std::size_t i = 0; i < weights.size(); ++i) {
      weights[i] = 1.0 / std::max(distance_mm[i], floor_mm);
    }
  }
  ImagePlane plane;
  plane.mm_per_px = {affine.col(0).norm(), affine.col(1).norm()};
  plane.origin_mm = affine.col(2);
  // The nearest rotation: both axes turn by the same angle to become perpendicular.
  const Vector3d x = affine.col(0).normalized(), y = affine.col(1).normalized();
  const Vector3d between = (x + y).normalized(), across = (x - y).normalized();
  plane.axes.col(0) = (between + across).normalized();
  plane.axes.col(1) = (between - across).normalized();
  plane.axes.col(2) = plane.axes.col(0).cross(plane.axes.col(1));
  return plane;
}

PlaneFit FitPlane(const std::vector<PlanePoint>& points, const ImagePlane& start) {
  PlaneSolver solver(points, start);
  std::vector<bool> used(points.size(), true);
  for (int round = 0; round < 3; ++round) {
    solver.Solve(used, 2.0 * MedianLength(solver.Residuals()));
  }
  for (int round = 0; round < 50; ++round) {
    const std::vector<Vector3d> residuals = solver.Residuals();
    const Vector3d deviations = Deviations(residuals, used, round == 0);
    std::vector<bool> next(used.size());
    for (std::size_t i = 0; i < used.size(); ++i) {
      next[i] = residuals[i].cwiseQuotient(deviations).norm() <= kOutlierDeviations;
    }
    const auto count = static_cast<std::size_t>(std::ranges::count(next, true));
    if ((next == used && round > 0) || count < kNumParameters) break;
    used = next;
    solver.Solve(used, 0.0);
  }
  return solver.Fit(used);
}

}  // namespace acus::registration
