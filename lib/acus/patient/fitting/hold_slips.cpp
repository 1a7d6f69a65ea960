#include "acus/patient/fitting/hold_slips.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <vector>

namespace acus::fitting {
namespace {

constexpr double kLeastShare = 0.03;
constexpr double kLeastSlipN = 0.03;
constexpr double kEdgeS = 0.5;  // Slips nearer to the begin of the rest are relaxation.

std::vector<double> LeftInHold(const PhaseSamples& samples, std::span<const double> predicted) {
  std::vector<double> left;
  for (std::size_t i = samples.hold.begin; i < samples.hold.end; ++i) {
    left.push_back(predicted[i] - samples.all.force_n[i]);
  }
  return left;
}

/// Time at rest by sample of the hold.
std::vector<double> RestedS(const PhaseSamples& samples, const MechanicalModel& model) {
  MechanicalState state;
  std::vector<double> rested;
  for (std::size_t i = 0; i < samples.hold.end; ++i) {
    state.Advance(model, samples.all.time_s[i], samples.all.depth_mm[i]);
    if (i >= samples.hold.begin) rested.push_back(state.rest_s);
  }
  return rested;
}

/// What a relaxation that is fitted again can take up: a constant and the model's exponentials.
/// Orthonormal columns.
Eigen::MatrixXd RelaxationBasis(const PhaseSamples& samples, const MechanicalModel& model) {
  std::vector<double> times_s;
  for (std::size_t k = 0; k < MechanicalModel::kMostBranches; ++k) {
    if (model.relaxing_share[k] > 0.0) times_s.push_back(model.relaxation_s[k]);
  }
  const auto n = static_cast<Eigen::Index>(samples.hold.size());
  const auto columns = static_cast<Eigen::Index>(times_s.size()) + 1;
  Eigen::MatrixXd basis = Eigen::MatrixXd::Ones(n, columns);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double since_s = samples.all.time_s[samples.hold.begin + static_cast<std::size_t>(i)] -
                           samples.all.time_s[samples.hold.begin];
    for (Eigen::Index k = 1; k < columns; ++k) {
      basis(i, k) = std::exp(-since_s / times_s[static_cast<std::size_t>(k - 1)]);
    }
  }
  return basis.householderQr().householderQ() * Eigen::MatrixXd::Identity(n, columns);
}

}  // namespace

std::optional<Slip> BestSlip(const PhaseSamples& samples, const MechanicalModel& model,
                             std::span<const double> predicted) {
  const std::vector<double> left = LeftInHold(samples, predicted);
  if (left.size() < 20) return {};
  const std::vector<double> rested = RestedS(samples, model);
  const Eigen::MatrixXd basis = RelaxationBasis(samples, model);
  const Eigen::Map<const Eigen::VectorXd> all_left(left.data(),
                                                   static_cast<Eigen::Index>(left.size()));
  const Eigen::VectorXd taken_up = basis.transpose() * all_left;
  Eigen::VectorXd along = Eigen::VectorXd::Zero(basis.cols());
  double products = 0.0;
  double squares = 0.0;
  double most = 0.0;
  std::optional<Slip> best;
  for (std::size_t i = left.size(); i-- > 1;) {
    const double m = predicted[samples.hold.begin + i];
    products += m * left[i];
    squares += m * m;
    along += m * basis.row(static_cast<Eigen::Index>(i)).transpose();
    const double beside = squares - along.squaredNorm();
    if (!(beside > 1e-6 * squares)) continue;
    const double share = (products - along.dot(taken_up)) / beside;
    const bool counts = share >= kLeastShare && share < 1.0 && share * m >= kLeastSlipN &&
                        rested[i] > kEdgeS && rested[i - 1] > 0.0;
    if (!counts || share * share * beside <= most) continue;
    most = share * share * beside;
    best = Slip{0.5 * (rested[i - 1] + rested[i]), share};
  }
  return best;
}

double ShareMissing(const PhaseSamples& samples, const MechanicalModel& model,
                    std::span<const double> predicted, double after_s) {
  const std::vector<double> left = LeftInHold(samples, predicted);
  const std::vector<double> rested = RestedS(samples, model);
  const Eigen::MatrixXd basis = RelaxationBasis(samples, model);
  Eigen::VectorXd column = Eigen::VectorXd::Zero(basis.rows());
  for (std::size_t i = 0; i < left.size(); ++i) {
    if (rested[i] < after_s) continue;
    column(static_cast<Eigen::Index>(i)) = predicted[samples.hold.begin + i];
  }
  const double squares = column.squaredNorm();
  column -= basis * (basis.transpose() * column);
  const double beside = column.squaredNorm();
  if (!(beside > 1e-6 * squares)) return 0.0;
  const Eigen::Map<const Eigen::VectorXd> all_left(left.data(),
                                                   static_cast<Eigen::Index>(left.size()));
  return column.dot(all_left) / beside;
}

double IndependentInHold(const PhaseSamples& samples, std::span<const double> predicted) {
  const std::vector<double> left = LeftInHold(samples, predicted);
  return static_cast<double>(left.size()) / Inflation(left);
}

double HoldCriterion(const PhaseSamples& samples, std::span<const double> predicted,
                     double independent, double parameters) {
  double squares = 1e-30;
  for (const double l : LeftInHold(samples, predicted)) squares += l * l;
  return independent * std::log(squares) + 2.0 * parameters;
}

}  // namespace acus::fitting
