#include "acus/patient/fitting/hu_table_fit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "acus/base/core/error.h"
#include "acus/base/math/statistics.h"
#include "acus/patient/fitting/non_negative.h"
#include "acus/physics/forces/laws/hu_resistance.h"

namespace acus::fitting {
namespace {

constexpr double kStepMm = 0.1;
constexpr double kBuildUpMm = 2.0;
constexpr double kSmoothing[] = {1e-5, 1e-4, 1e-3, 1e-2, 1e-1, 1.0, 10.0};
constexpr int kFolds = 5;
constexpr double kLargestEdgeFactor = 20.0;

forces::CubicBSpline Spline(const std::vector<double>& hu, std::vector<double> coefficients = {}) {
  coefficients.resize(hu.size() + 2, 0.0);
  return {hu, coefficients, "resistance by HU"};
}

/// Means over kStepMm of the sliding part of an insertion.
struct Row {
  double hu = 0.0;
  double edge_share = 0.0;  ///< Of the samples, at an edge.
  double speed = 0.0;
  double travel_mm = 0.0;
  double force_n = 0.0;
  int fold = 0;
};

void AddRows(const ForceCurve& curve, const CurvePhases& phases, double offset_n,
             double edge_hu_per_mm, int fold, std::vector<Row>& rows) {
  const double begin_mm = curve.depth_mm[phases.advance.begin];
  const bool has_gradient = !curve.hu_gradient_per_mm.empty();
  Row sum;
  double count = 0.0;
  double from_mm = 0.0;  // Depth and time of the sample before the step.
  double from_s = -1.0;
  for (std::size_t i = phases.advance.begin; i < phases.advance.end; ++i) {
    const double depth = curve.depth_mm[i];
    if (depth < begin_mm + kBuildUpMm || !phases.moving_in[i] || from_s < 0.0) {
      from_mm = depth;
      from_s = depth < begin_mm + kBuildUpMm ? -1.0 : curve.time_s[i];
      sum = {};
      count = 0.0;
      continue;
    }
    sum.hu += curve.hu[i];
    if (has_gradient && curve.hu_gradient_per_mm[i] > edge_hu_per_mm) sum.edge_share += 1.0;
    sum.travel_mm += depth - begin_mm;
    sum.force_n += curve.force_n[i] - offset_n;
    count += 1.0;
    if (depth - from_mm < kStepMm) continue;
    rows.push_back({sum.hu / count, sum.edge_share / count,
                    (depth - from_mm) / (curve.time_s[i] - from_s), sum.travel_mm / count,
                    sum.force_n / count, fold});
    sum = {};
    count = 0.0;
    from_mm = depth;
    from_s = curve.time_s[i];
  }
}

class TableFitter {
 public:
  TableFitter(std::vector<Row> rows, std::vector<double> breakpoints)
      : rows_(std::move(rows)), hu_(std::move(breakpoints)) {
    Assemble();
  }

  /// Coefficients, then the shaft's force per mm; none below 0.
  Eigen::VectorXd Solve(double smoothing, int without_fold) const {
    const Eigen::Index n = columns_.cols();
    Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(n, n);
    Eigen::VectorXd right = Eigen::VectorXd::Zero(n);
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      if (rows_[i].fold == without_fold) continue;
      const auto row = columns_.row(static_cast<Eigen::Index>(i));
      normal += row.transpose() * row;
      right += row.transpose() * rows_[i].force_n;
    }
    normal += Penalty(smoothing);
    return SolveNonNegative(normal, right).x;
  }

  double BestSmoothing() const {
    double best = kSmoothing[0];
    double least = std::numeric_limits<double>::infinity();
    int folds = 0;
    for (const Row& row : rows_) folds = std::max(folds, row.fold + 1);
    for (const double smoothing : kSmoothing) {
      double squares = 0.0;
      for (int fold = 0; fold < folds; ++fold) {
        const Eigen::VectorXd solution = Solve(smoothing, fold);
        for (std::size_t i = 0; i < rows_.size(); ++i) {
          if (rows_[i].fold != fold) continue;
          squares += std::pow(
              columns_.row(static_cast<Eigen::Index>(i)).dot(solution) - rows_[i].force_n, 2);
        }
      }
      if (squares < least) {
        least = squares;
        best = smoothing;
      }
    }
    return best;
  }

  /// K_edge for these coefficients, then the columns with it.
  double UpdateEdgeFactor(const Eigen::VectorXd& solution) {
    const Eigen::VectorXd slope = EdgeColumn(solution);
    const std::vector<double> residual = Residuals(solution);
    const double fall =
        -slope.dot(Eigen::Map<const Eigen::VectorXd>(residual.data(), slope.size()));
    const double squares = slope.squaredNorm();
    if (squares > 0.0) {
      edge_factor_ = std::clamp(edge_factor_ + fall / squares, 1.0, kLargestEdgeFactor);
    }
    Assemble();
    return edge_factor_;
  }

  std::vector<double> Residuals(const Eigen::VectorXd& solution) const {
    std::vector<double> residual;
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      residual.push_back(columns_.row(static_cast<Eigen::Index>(i)).dot(solution) -
                         rows_[i].force_n);
    }
    return residual;
  }

  /// Intervals of each unknown and, last, of K_edge: each with the other ones that are not held at
  /// a bound, so that none counts as exact that is not.
  std::vector<Estimate> Estimates(double smoothing, const Eigen::VectorXd& solution,
                                  const std::vector<double>& residual) const {
    const Eigen::Index n = columns_.cols();
    Eigen::MatrixXd columns(columns_.rows(), n + 1);
    columns << columns_, EdgeColumn(solution);
    Eigen::MatrixXd normal = columns.transpose() * columns;
    normal.topLeftCorner(n, n) += Penalty(smoothing);
    double squares = 0.0;
    for (const double r : residual) squares += r * r;
    const double variance = squares / static_cast<double>(residual.size()) * Inflation(residual);
    std::vector<bool> is_free;
    for (const double value : solution) is_free.push_back(value > 0.0);
    is_free.push_back(edge_factor_ > 1.0 && edge_factor_ < kLargestEdgeFactor);
    Eigen::VectorXd at(n + 1), fall(n + 1);
    at << solution, edge_factor_;
    fall =
        -columns.transpose() * Eigen::Map<const Eigen::VectorXd>(residual.data(), columns.rows());
    fall.head(n) -= Penalty(smoothing) * solution;
    std::vector<Estimate> estimates;
    for (Eigen::Index k = 0; k <= n; ++k) {
      std::vector<Eigen::Index> others;
      for (Eigen::Index m = 0; m <= n; ++m) {
        if (m != k && is_free[static_cast<std::size_t>(m)]) others.push_back(m);
      }
      const Eigen::VectorXd shared = normal(others, k);
      const double information =
          normal(k, k) - shared.dot(normal(others, others).ldlt().solve(shared));
      if (!(information > 0.0)) {  // No edges.
        estimates.push_back({at(k), 0.0, at(k), at(k)});
        continue;
      }
      // Where the unknown would go if it were free: no step for one that is.
      const double value =
          at(k) + (is_free[static_cast<std::size_t>(k)] ? 0.0 : fall(k) / information);
      estimates.push_back(
          Estimate::Normal(value, std::sqrt(variance / information)).AtLeast(k < n ? 0.0 : 1.0));
    }
    return estimates;
  }

  /// Sum of each coefficient's basis function over the rows.
  Eigen::VectorXd Support() const { return columns_.cwiseAbs().colwise().sum(); }
  const std::vector<double>& hu() const { return hu_; }

 private:
  double FactorOf(const Row& row) const { return 1.0 + (edge_factor_ - 1.0) * row.edge_share; }

  /// d force / d K_edge of each row.
  Eigen::VectorXd EdgeColumn(const Eigen::VectorXd& solution) const {
    const Eigen::Index last = columns_.cols() - 1;
    Eigen::VectorXd slope = columns_.leftCols(last) * solution.head(last);
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      slope(static_cast<Eigen::Index>(i)) *= rows_[i].edge_share / FactorOf(rows_[i]);
    }
    return slope;
  }

  void Assemble() {
    columns_ = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(rows_.size()),
                                     static_cast<Eigen::Index>(hu_.size()) + 3);
    const forces::CubicBSpline spline = Spline(hu_);
    double basis[4];
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      const Row& row = rows_[i];
      const int first = spline.Basis(row.hu, basis);
      const double factor = row.speed * FactorOf(row);
      for (int k = 0; k < 4; ++k) {
        columns_(static_cast<Eigen::Index>(i), first + k) = factor * basis[k];
      }
      columns_(static_cast<Eigen::Index>(i), columns_.cols() - 1) = row.travel_mm;
    }
  }

  Eigen::MatrixXd Penalty(double smoothing) const {
    const Eigen::Index n = columns_.cols();
    Eigen::MatrixXd penalty = Eigen::MatrixXd::Zero(n, n);
    const double scale =
        smoothing * columns_.leftCols(n - 1).squaredNorm() / static_cast<double>(n - 1);
    const Eigen::Vector3d bend(1.0, -2.0, 1.0);
    for (Eigen::Index k = 0; k + 3 < n; ++k) {
      penalty.block<3, 3>(k, k) += scale * bend * bend.transpose();
    }
    penalty.diagonal().array() += 1e-12 * std::max(1e-12, scale / smoothing);
    return penalty;
  }

  std::vector<Row> rows_;
  std::vector<double> hu_;
  double edge_factor_ = 1.0;
  Eigen::MatrixXd columns_;
};

std::vector<double> Breakpoints(const std::vector<Row>& rows) {
  std::vector<double> hu;
  for (const Row& row : rows) hu.push_back(row.hu);
  const double low = math::Quantile(hu, 0.002);
  const double high = std::max(low + 1.0, math::Quantile(hu, 0.998));
  const int intervals = std::clamp(static_cast<int>((high - low) / 20.0), 1, 12);
  std::vector<double> breakpoints;
  for (int k = 0; k <= intervals; ++k) {
    breakpoints.push_back(low + (high - low) * k / intervals);
  }
  return breakpoints;
}

}  // namespace

double HuTable::ResistanceNSPerMm(double at_hu) const {
  return Spline(hu, n_s_per_mm)(at_hu);
}

HuTableFit FitHuTable(std::span<const ForceCurve> curves, std::span<const CurvePhases> phases,
                      std::span<const double> offsets_n, double edge_hu_per_mm) {
  ACUS_ASSERT(curves.size() == phases.size() && curves.size() == offsets_n.size());
  HuTableFit fit;
  std::vector<Row> rows;
  int fold = 0;
  bool has_gradient = false;
  for (std::size_t c = 0; c < curves.size(); ++c) {
    if (curves[c].hu.empty() || phases[c].advance.size() == 0) continue;
    AddRows(curves[c], phases[c], offsets_n[c], edge_hu_per_mm, fold++, rows);
    has_gradient = has_gradient || !curves[c].hu_gradient_per_mm.empty();
  }
  if (rows.size() < 40) {
    fit.message = Message("the recordings with HU have ", rows.size(),
                          " steps of 0.1 mm of steady insertion; at least 40 are needed");
    return fit;
  }
  if (fold == 1) {  // One recording: contiguous parts of its path.
    for (std::size_t i = 0; i < rows.size(); ++i) {
      rows[i].fold = static_cast<int>(i * kFolds / rows.size());
    }
  }
  TableFitter fitter(rows, Breakpoints(rows));
  fit.smoothing = fitter.BestSmoothing();
  Eigen::VectorXd solution = fitter.Solve(fit.smoothing, -1);
  for (int round = 0; round < 50 && has_gradient; ++round) {
    const double before = fit.table.edge_factor;
    fit.table.edge_factor = fitter.UpdateEdgeFactor(solution);
    solution = fitter.Solve(fit.smoothing, -1);
    if (std::abs(fit.table.edge_factor - before) < 1e-9) break;
  }
  const Eigen::Index count = solution.size() - 1;
  fit.table.hu = fitter.hu();
  fit.table.edge_hu_per_mm = edge_hu_per_mm;
  fit.table.n_s_per_mm.assign(solution.begin(), solution.begin() + count);
  const std::vector<double> residual = fitter.Residuals(solution);
  fit.rms_n = math::RootMeanSquare(residual);
  fit.n_s_per_mm = fitter.Estimates(fit.smoothing, solution, residual);
  fit.edge_factor = fit.n_s_per_mm.back();
  fit.friction_n_per_mm = fit.n_s_per_mm[static_cast<std::size_t>(count)];
  fit.n_s_per_mm.resize(static_cast<std::size_t>(count));
  const Eigen::VectorXd support = fitter.Support();
  const double typical = support.head(count).mean();
  for (Eigen::Index k = 0; k < count; ++k) {
    if (support(k) > 1e-3 * typical) continue;
    const auto at = static_cast<std::size_t>(std::clamp<Eigen::Index>(k - 1, 0, count - 3));
    fit.warnings.push_back(Message("resistance around ", fit.table.hu[at],
                                   " HU: no recording comes there; smoothness alone sets it"));
  }
  fit.converged = true;
  return fit;
}

nlohmann::json VidalBlock(const HuTable& table) {
  nlohmann::json block = {{"resistance", {{"hu", table.hu}, {"n_s_per_mm", table.n_s_per_mm}}}};
  block["edge_factor"] = table.edge_factor;
  block["edge_hu_per_mm"] = table.edge_hu_per_mm;
  return block;
}

}  // namespace acus::fitting
