#include "acus/assess/study/reliability.h"

#include "acus/base/core/error.h"

namespace acus::study {

std::optional<IntraclassCorrelation> ComputeIcc(const Eigen::MatrixXd& ratings) {
  ACUS_ASSERT(ratings.rows() >= 2 && ratings.cols() >= 2);
  const double n = static_cast<double>(ratings.rows());
  const double k = static_cast<double>(ratings.cols());
  const double mean = ratings.mean();
  const Eigen::VectorXd row_means = ratings.rowwise().mean();
  const Eigen::RowVectorXd column_means = ratings.colwise().mean();
  const double between = k * (row_means.array() - mean).square().sum();
  const double columns = n * (column_means.array() - mean).square().sum();
  const double all = (ratings.array() - mean).square().sum();
  if (!(all > 0.0)) return std::nullopt;
  // Names in the paper: between targets, within targets, between judges, error.
  const double bms = between / (n - 1.0);
  const double wms = (all - between) / (n * (k - 1.0));
  const double jms = columns / (k - 1.0);
  const double ems = (all - between - columns) / ((n - 1.0) * (k - 1.0));
  const auto ratio = [](double over, double under) { return under == 0.0 ? 0.0 : over / under; };
  return IntraclassCorrelation{ratio(bms - wms, bms + (k - 1.0) * wms),
                               ratio(bms - ems, bms + (k - 1.0) * ems + k * (jms - ems) / n),
                               ratio(bms - ems, bms + (k - 1.0) * ems),
                               ratio(bms - wms, bms),
                               ratio(bms - ems, bms + (jms - ems) / n),
                               ratio(bms - ems, bms)};
}

std::optional<double> CronbachAlpha(const Eigen::MatrixXd& answers) {
  ACUS_ASSERT(answers.rows() >= 2 && answers.cols() >= 2);
  const double k = static_cast<double>(answers.cols());
  const auto variance = [](const Eigen::VectorXd& values) {
    return (values.array() - values.mean()).square().sum() / static_cast<double>(values.size() - 1);
  };
  double items = 0.0;
  for (Eigen::Index i = 0; i < answers.cols(); ++i) items += variance(answers.col(i));
  const double total = variance(answers.rowwise().sum());
  if (!(total > 0.0)) return std::nullopt;
  return k / (k - 1.0) * (1.0 - items / total);
}

}  // namespace acus::study
