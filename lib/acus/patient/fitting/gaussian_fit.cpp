#include "acus/patient/fitting/gaussian_fit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "acus/base/core/error.h"
#include "acus/base/math/statistics.h"
#include "acus/patient/fitting/depth_bins.h"

namespace acus::fitting {
namespace {

constexpr double kSteps = 900.0;  // The fit's samples.
constexpr int kCentres = 90;      // Grid of starts, over the insertion...
constexpr int kWidths = 14;       // ...and from kNarrowest of it upwards.
constexpr double kNarrowest = 0.005;
constexpr double kWidest = 1.5;
constexpr double kLogNarrow = -7.0;    // Logarithms of widths in mm...
constexpr double kLogWide = 12.0;      // ...that are distinguished.
constexpr double kFar = 25.0;          // In widths: a term is 0 there.
constexpr Eigen::Index kColumns = 60;  // Of candidates at a time: they stay in the cache.
constexpr int kMostRounds = 4;         // Of taking terms out and looking for better ones.

/// Parameters: height, centre, logarithm of the width, for each term.
double Evaluate(std::span<const double> p, double x, std::span<double> gradient) {
  double sum = 0.0;
  for (std::size_t k = 0; k + 2 < p.size(); k += 3) {
    // A term may wander to any width on its way; far from its centre it is 0 with all derivatives.
    const double logarithm = std::clamp(p[k + 2], kLogNarrow, kLogWide);
    const double inverse_width = std::exp(-logarithm);
    const double u = std::clamp((x - p[k + 1]) * inverse_width, -kFar, kFar);
    const double bell = std::exp(-u * u);
    sum += p[k] * bell;
    gradient[k] = bell;
    gradient[k + 1] = 2.0 * p[k] * bell * u * inverse_width;
    gradient[k + 2] = logarithm == p[k + 2] ? 2.0 * p[k] * bell * u * u : 0.0;
  }
  return sum;
}

class GaussianFitter {
 public:
  GaussianFitter(const std::vector<double>& x, const std::vector<double>& y) : x_(x), y_(y) {
    const auto [first, last] = std::ranges::minmax(x);
    const double span = last - first;
    for (int c = 0; c < kCentres; ++c) {
      for (int w = 0; w < kWidths; ++w) {
        const double centre = first + span * (1.1 * c / (kCentres - 1) - 0.05);
        const double width =
            span * kNarrowest * std::pow(kWidest / kNarrowest, w / (kWidths - 1.0));
        candidates_.push_back({1.0, centre, width});
      }
    }
    bells_.resize(static_cast<Eigen::Index>(x.size()),
                  static_cast<Eigen::Index>(candidates_.size()));
    for (std::size_t k = 0; k < candidates_.size(); ++k) {
      bells_.col(static_cast<Eigen::Index>(k)) = Bell(candidates_[k]);
    }
  }

  ModelFit Run(int count, int most) {
    ModelFit best;
    for (int k = 0; k < count; ++k) best = Added(best.parameters);
    best = Exchanged(std::move(best));
    for (int k = count; k < most && best.rms_n > kEnoughN; ++k) {
      ModelFit more = Added(best.parameters);
      if (!(more.rms_n < best.rms_n)) break;
      best = Exchanged(std::move(more));
    }
    return best;
  }

 private:
  /// Each term in turn taken out and looked for again, as long as that helps.
  ModelFit Exchanged(ModelFit best) const {
    for (int round = 0; round < kMostRounds; ++round) {
      bool better = false;
      for (std::size_t k = 0; k < best.parameters.size(); k += 3) {
        std::vector<double> others = best.parameters;
        others.erase(others.begin() + static_cast<std::ptrdiff_t>(k),
                     others.begin() + static_cast<std::ptrdiff_t>(k) + 3);
        ModelFit other = Added(Polished(others).parameters);
        if (other.rms_n < 0.999 * best.rms_n) {
          best = std::move(other);
          better = true;
        }
      }
      if (!better) break;
    }
    return best;
  }

  Eigen::VectorXd Bell(const Gaussian& term) const {
    const Eigen::Map<const Eigen::ArrayXd> x(x_.data(), static_cast<Eigen::Index>(x_.size()));
    return (-((x - term.centre_mm) / term.width_mm).square()).exp();
  }

  ModelFit Polished(const std::vector<double>& start) const {
    return start.empty() ? ModelFit{} : FitModel(Evaluate, x_, y_, start, false);
  }

  /// With one term more: the candidate that leaves least beside the given ones, then all fitted.
  ModelFit Added(const std::vector<double>& start) const {
    const auto rows = static_cast<Eigen::Index>(x_.size());
    const auto terms = static_cast<Eigen::Index>(start.size() / 3);
    Eigen::MatrixXd basis(rows, terms);
    for (Eigen::Index k = 0; k < terms; ++k) {
      const auto i = static_cast<std::size_t>(3 * k);
      basis.col(k) = Bell({1.0, start[i + 1], std::exp(start[i + 2])});
    }
    Eigen::VectorXd residual = Eigen::Map<const Eigen::VectorXd>(y_.data(), rows);
    Eigen::MatrixXd q(rows, terms);
    if (terms > 0) {
      q = basis.householderQr().householderQ() * Eigen::MatrixXd::Identity(rows, terms);
      residual -= q * (q.transpose() * residual);
    }
    Eigen::Index choice = 0;
    double most = -1.0;
    Eigen::MatrixXd left;
    for (Eigen::Index first = 0; first < bells_.cols(); first += kColumns) {
      const auto bells = bells_.middleCols(first, std::min(kColumns, bells_.cols() - first));
      left = bells;
      if (terms > 0) left.noalias() -= q * (q.transpose() * bells);
      for (Eigen::Index k = 0; k < left.cols(); ++k) {
        const double norm = left.col(k).squaredNorm();
        if (norm < 1e-6 * bells.col(k).squaredNorm()) continue;  // The others make it already.
        const double product = left.col(k).dot(residual);
        if (product * product / norm > most) {
          most = product * product / norm;
          choice = first + k;
        }
      }
    }
    return PolishedWith(start, basis, choice);
  }

  ModelFit PolishedWith(const std::vector<double>& start, const Eigen::MatrixXd& others,
                        Eigen::Index choice) const {
    Eigen::MatrixXd basis(others.rows(), others.cols() + 1);
    basis << others, bells_.col(choice);
    const Eigen::VectorXd height = basis.colPivHouseholderQr().solve(
        Eigen::Map<const Eigen::VectorXd>(y_.data(), basis.rows()));
    std::vector<double> next = start;
    const Gaussian& added = candidates_[static_cast<std::size_t>(choice)];
    next.insert(next.end(), {0.0, added.centre_mm, std::log(added.width_mm)});
    for (Eigen::Index k = 0; k < height.size(); ++k) {
      next[static_cast<std::size_t>(3 * k)] = height(k);
    }
    return Polished(next);
  }

  const std::vector<double>& x_;
  const std::vector<double>& y_;
  std::vector<Gaussian> candidates_;
  Eigen::MatrixXd bells_;  ///< A column per candidate.
};

GaussianFit Sorted(const ModelFit& fit) {
  GaussianFit result;
  std::vector<std::size_t> order;
  for (std::size_t k = 0; k < fit.parameters.size(); k += 3) order.push_back(k);
  std::ranges::stable_sort(order, {}, [&](std::size_t k) { return fit.parameters[k + 1]; });
  for (const std::size_t k : order) {
    const double width = std::exp(std::clamp(fit.parameters[k + 2], kLogNarrow, kLogWide));
    result.terms.push_back({fit.parameters[k], fit.parameters[k + 1], width});
    if (!fit.converged) continue;
    result.height_n.push_back(fit.Of(k));
    result.centre_mm.push_back(fit.Of(k + 1));
    Eigen::VectorXd gradient = Eigen::VectorXd::Zero(fit.covariance.rows());
    gradient(static_cast<Eigen::Index>(k + 2)) = width;
    result.width_mm.push_back(fit.Of(width, gradient));
  }
  return result;
}

}  // namespace

double SumN(std::span<const Gaussian> terms, double depth_mm) {
  double sum = 0.0;
  for (const Gaussian& term : terms) {
    const double u = (depth_mm - term.centre_mm) / term.width_mm;
    sum += term.height_n * std::exp(-u * u);
  }
  return sum;
}

GaussianFit FitGaussians(const ForceCurve& curve, const CurvePhases& phases, int count, int most) {
  ACUS_ASSERT(count >= 1 && count <= 32);
  GaussianFit result;
  const SampleRange& range = phases.advance;
  // Means over equal times: every sample counts the same, as in the RMS.
  const double duration_s =
      range.size() > 1 ? curve.time_s[range.end - 1] - curve.time_s[range.begin] : 0.0;
  const ForceCurve thin = Thinned(curve, range, duration_s / kSteps);
  const auto [low, high] = thin.size() > 0 ? std::ranges::minmax(thin.depth_mm)
                                           : std::ranges::minmax_result<double>{0.0, 0.0};
  if (thin.size() < static_cast<std::size_t>(4 * count) || high - low < 1.0) {
    result.message = Message("an insertion over ", high - low, " mm with ", thin.size(),
                             " steps is too short for ", count, " Gaussians");
    return result;
  }
  most = std::min(most, static_cast<int>(thin.size() / 4));
  const ModelFit fit = GaussianFitter(thin.depth_mm, thin.force_n).Run(count, most);
  result = Sorted(fit);
  result.converged = true;
  if (!fit.converged) result.message = "the terms cannot be separated: no intervals";
  std::vector<double> residual;
  for (std::size_t i = phases.advance.begin; i < phases.advance.end; ++i) {
    residual.push_back(SumN(result.terms, curve.depth_mm[i]) - curve.force_n[i]);
  }
  result.rms_n = math::RootMeanSquare(residual);
  result.aic = fit.effective_samples * 2.0 * std::log(std::max(fit.rms_n, 1e-12)) +
               2.0 * (static_cast<double>(fit.parameters.size()) + 1.0);
  return result;
}

}  // namespace acus::fitting
