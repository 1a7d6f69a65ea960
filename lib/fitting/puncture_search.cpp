#include "fitting/puncture_search.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <functional>
#include <span>

#include "core/error.h"
#include "fitting/series_fit.h"

namespace acus::fitting {
namespace {

constexpr double kPeakWithinMm =
    0.5;  // A place to look at is the largest in so much on both sides.
constexpr double kRisesMm[] = {0.4, 0.8, 1.5, 2.5, 4.0, 6.0, 9.0, 14.0};
constexpr double kRecoveriesMm[] = {0.1, 0.4, 1.0, 2.5};
constexpr double kWidthsMm[] = {0.1, 0.4, 1.2, 3.0};
constexpr double kFewestIndependent = 30.0;

Eigen::Map<const Eigen::VectorXd> AsVector(const std::vector<double>& values) {
  return {values.data(), static_cast<Eigen::Index>(values.size())};
}

/// What one kind of event looks like at a place: columns to be scaled, the first `positive` of them
/// by factors that must not be negative.
struct Shape {
  std::vector<double> place;  ///< The non-linear parameters.
  Eigen::MatrixXd columns;
};

struct Choice {
  double gain = -1.0;  ///< Squares that it takes away.
  std::vector<double> place;
  Eigen::VectorXd factor;
  Eigen::MatrixXd columns;
};

/// The basis so far, orthonormal, and what it leaves.
class Pursuit {
 public:
  Pursuit(const Eigen::MatrixXd& columns, const Eigen::VectorXd& force)
      : columns_(columns), force_(force) {
    Refresh();
  }

  const Eigen::VectorXd& residual() const { return residual_; }
  double squares() const { return residual_.squaredNorm(); }

  /// What an event would bring; columns that ask for a negative factor are left out.
  void Try(const Shape& shape, Eigen::Index positive, Choice& best) const {
    const Eigen::MatrixXd left = shape.columns - q_ * (q_.transpose() * shape.columns);
    const Eigen::Index n = left.cols();
    std::vector<Eigen::Index> used;
    for (Eigen::Index k = 0; k < n; ++k) {
      if (left.col(k).squaredNorm() > 1e-6 * shape.columns.col(k).squaredNorm()) used.push_back(k);
    }
    while (!used.empty()) {
      const Eigen::MatrixXd part = left(Eigen::all, used);
      const Eigen::VectorXd product = part.transpose() * residual_;
      const Eigen::VectorXd factor = (part.transpose() * part).ldlt().solve(product);
      auto worst = used.end();
      for (std::size_t k = 0; k < used.size(); ++k) {
        if (used[k] < positive && factor(static_cast<Eigen::Index>(k)) < 0.0) {
          worst = used.begin() + static_cast<std::ptrdiff_t>(k);
          break;
        }
      }
      if (worst != used.end()) {
        used.erase(worst);
        continue;
      }
      const double gain = factor.dot(product);
      if (!(gain > best.gain)) return;
      best = {gain, shape.place, Eigen::VectorXd::Zero(n), shape.columns};
      for (std::size_t k = 0; k < used.size(); ++k) {
        best.factor(used[k]) = factor(static_cast<Eigen::Index>(k));
      }
      return;
    }
  }

  /// Takes the event's sum of columns into the basis.
  void Add(const Choice& choice) {
    columns_.conservativeResize(Eigen::NoChange, columns_.cols() + 1);
    columns_.rightCols(1) = choice.columns * choice.factor;
    Refresh();
  }

 private:
  void Refresh() {
    q_ = columns_.householderQr().householderQ() *
         Eigen::MatrixXd::Identity(columns_.rows(), columns_.cols());
    residual_ = force_ - q_ * (q_.transpose() * force_);
  }

  Eigen::MatrixXd columns_;
  Eigen::VectorXd force_;
  Eigen::MatrixXd q_;
  Eigen::VectorXd residual_;
};

/// Depths at which what is left (times the sign of the strain) is larger than around it.
std::vector<std::size_t> Peaks(const StrainedRows& rows, const Eigen::VectorXd& residual) {
  std::vector<std::size_t> peaks;
  const std::size_t n = rows.depth_mm.size();
  for (std::size_t i = 0; i < n; ++i) {
    bool largest = true;
    for (std::size_t j = i; j-- > 0 && largest;) {
      if (std::abs(rows.depth_mm[i] - rows.depth_mm[j]) > kPeakWithinMm) break;
      largest = residual(static_cast<Eigen::Index>(i)) >= residual(static_cast<Eigen::Index>(j));
    }
    for (std::size_t j = i + 1; j < n && largest; ++j) {
      if (std::abs(rows.depth_mm[i] - rows.depth_mm[j]) > kPeakWithinMm) break;
      largest = residual(static_cast<Eigen::Index>(i)) > residual(static_cast<Eigen::Index>(j));
    }
    if (largest) peaks.push_back(i);
  }
  return peaks;
}

/// Rising, rising with the square, and the change that stays.
Shape PunctureShape(const StrainedRows& rows, double contact_mm, double rise_mm,
                    double recovery_mm) {
  const auto n = static_cast<Eigen::Index>(rows.depth_mm.size());
  Shape shape{{contact_mm, rise_mm, recovery_mm}, Eigen::MatrixXd::Zero(n, 3)};
  for (Eigen::Index i = 0; i < n; ++i) {
    const double x = rows.depth_mm[static_cast<std::size_t>(i)] - contact_mm;
    if (x <= 0.0) continue;
    const double strain = rows.strain[static_cast<std::size_t>(i)];
    const double fading = x <= rise_mm ? 1.0 : std::exp(-(x - rise_mm) / recovery_mm);
    const double within = std::min(x, rise_mm);
    shape.columns(i, 0) = strain * within * fading;
    shape.columns(i, 1) = strain * within * within * fading;
    shape.columns(i, 2) = x <= rise_mm ? 0.0 : strain * (1.0 - fading);
  }
  return shape;
}

Shape ReleaseShape(const StrainedRows& rows, double at_mm, double width_mm) {
  const auto n = static_cast<Eigen::Index>(rows.depth_mm.size());
  Shape shape{{at_mm, width_mm}, Eigen::MatrixXd::Zero(n, 1)};
  const Release unit{at_mm, width_mm, 1.0};
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto k = static_cast<std::size_t>(i);
    shape.columns(i, 0) = rows.strain[k] * unit.ForceN(rows.depth_mm[k]);
  }
  return shape;
}

/// How many events are worth their parameters: the least of the Bayesian information criterion,
/// with the number of independent samples of what the longest list leaves (before it, the events
/// that are still to come would be taken for correlated noise).
std::size_t Worth(const std::vector<double>& squares, const Eigen::VectorXd& left,
                  double parameters) {
  const auto rows = static_cast<double>(left.size());
  const double samples = std::max(
      kFewestIndependent, rows / Inflation({left.data(), static_cast<std::size_t>(left.size())}));
  std::size_t best = 0;
  double least = 0.0;
  for (std::size_t k = 0; k < squares.size(); ++k) {
    const double criterion = samples * std::log(std::max(squares[k], 1e-30)) +
                             parameters * static_cast<double>(k) * std::log(samples);
    if (k == 0 || criterion < least) {
      least = criterion;
      best = k;
    }
  }
  return best;
}

using Candidates = std::function<void(const Pursuit&, Choice&)>;
using Size = std::function<double(const Choice&)>;

std::vector<Choice> Search(const StrainedRows& rows, const std::vector<double>& knots,
                           const SearchLimits& limits, const Candidates& candidates,
                           const Size& size, double parameters) {
  Pursuit pursuit(ProfileColumns(rows, knots), AsVector(rows.force_n));
  std::vector<Choice> choices;
  std::vector<double> squares = {pursuit.squares()};
  while (static_cast<int>(choices.size()) < limits.most_events) {
    Choice best;
    candidates(pursuit, best);
    if (best.gain <= 0.0 || size(best) < limits.least_n) break;
    pursuit.Add(best);
    squares.push_back(pursuit.squares());
    choices.push_back(std::move(best));
  }
  choices.resize(Worth(squares, pursuit.residual(), parameters));
  std::ranges::stable_sort(choices, {}, [](const Choice& c) { return c.place[0]; });
  return choices;
}

/// Scales the events and sets the profile as they fit best together, places held.
void Balance(const StrainedRows& rows, std::vector<Choice>& choices, ResistanceProfile& profile) {
  const auto knots = static_cast<Eigen::Index>(profile.depth_mm.size());
  const auto count = static_cast<Eigen::Index>(choices.size());
  Eigen::MatrixXd columns(static_cast<Eigen::Index>(rows.depth_mm.size()), knots + count);
  columns.leftCols(knots) = ProfileColumns(rows, profile.depth_mm);
  for (Eigen::Index k = 0; k < count; ++k) {
    const Choice& choice = choices[static_cast<std::size_t>(k)];
    columns.col(knots + k) = choice.columns * choice.factor;
  }
  const Eigen::VectorXd solution = columns.colPivHouseholderQr().solve(AsVector(rows.force_n));
  std::copy_n(solution.begin(), knots, profile.force_n.begin());
  for (Eigen::Index k = 0; k < count; ++k) {
    choices[static_cast<std::size_t>(k)].factor *= solution(knots + k);
  }
}

std::vector<SeriesParameter> ProfileParameters(const ResistanceProfile& profile) {
  std::vector<SeriesParameter> parameters;
  for (const double force : profile.force_n) {
    parameters.push_back({"profile", std::clamp(force, -50.0, 100.0), -50.0, 100.0});
  }
  return parameters;
}

/// Profile (the first parameters) plus events, at all rows.
SeriesModel WholeModel(const StrainedRows& rows, const std::vector<double>& knots,
                       std::function<double(std::span<const double>, double)> events) {
  return [&rows, knots, events = std::move(events)](std::span<const double> p,
                                                    std::span<double> predicted) {
    const std::size_t count = knots.size();
    for (std::size_t i = 0; i < predicted.size(); ++i) {
      const double depth = rows.depth_mm[i];
      const auto above = std::upper_bound(knots.begin(), knots.end(), depth);
      const std::size_t k =
          std::clamp<std::size_t>(static_cast<std::size_t>(above - knots.begin()), 1, count - 1);
      const double along = (depth - knots[k - 1]) / (knots[k] - knots[k - 1]);
      const double base = p[k - 1] + along * (p[k] - p[k - 1]);
      predicted[i] = rows.strain[i] * (base + events(p.subspan(count), depth));
    }
  };
}

InternalPuncture PunctureFrom(std::span<const double> p) {
  return {p[0], p[1], p[2], p[3], p[4], p[5]};
}

}  // namespace

std::vector<FoundPuncture> FindInternalPunctures(const StrainedRows& rows,
                                                 const SearchLimits& limits,
                                                 ResistanceProfile& profile) {
  FitProfile(rows, {}, profile);
  if (rows.depth_mm.size() < 60) return {};
  const Candidates candidates = [&](const Pursuit& pursuit, Choice& best) {
    for (const std::size_t peak : Peaks(rows, pursuit.residual())) {
      for (const double rise : kRisesMm) {
        const double contact = rows.depth_mm[peak] - rise;
        if (contact < rows.depth_mm.front() - 0.1) break;
        for (const double recovery : kRecoveriesMm) {
          pursuit.Try(PunctureShape(rows, contact, rise, recovery), 2, best);
        }
      }
    }
  };
  const Size size = [](const Choice& c) {
    const double rise = c.place[1];
    return std::max(std::abs((c.factor(0) + c.factor(1) * rise) * rise), std::abs(c.factor(2)));
  };
  std::vector<Choice> choices = Search(rows, profile.depth_mm, limits, candidates, size, 6.0);
  if (choices.empty()) return {};
  Balance(rows, choices, profile);

  std::vector<SeriesParameter> parameters = ProfileParameters(profile);
  const std::size_t base = parameters.size();
  for (const Choice& c : choices) {
    const double rise = c.place[1];
    parameters.push_back(
        {"contact", c.place[0], c.place[0] - 0.5 * rise - 0.2, c.place[0] + 0.5 * rise});
    parameters.push_back({"puncture", rise, 0.3 * rise, 2.0 * rise});
    parameters.push_back({"a1", std::clamp(c.factor(0), 0.0, 50.0), 0.0, 100.0});
    parameters.push_back({"a2", std::clamp(c.factor(1), 0.0, 50.0), 0.0, 100.0});
    parameters.push_back({"recovery", c.place[2], 0.02, 10.0});
    parameters.push_back({"step", std::clamp(c.factor(2), -20.0, 20.0), -50.0, 50.0});
  }
  const SeriesModel model =
      WholeModel(rows, profile.depth_mm, [](std::span<const double> p, double depth) {
        double sum = 0.0;
        for (std::size_t k = 0; k < p.size(); k += 6)
          sum += PunctureFrom(p.subspan(k)).ForceN(depth);
        return sum;
      });
  const SeriesFit fit = FitSeries(model, rows.force_n, parameters, {.most_iterations = 25});
  const std::span<const double> solution(fit.parameters);
  std::ranges::copy(solution.first(base), profile.force_n.begin());
  std::vector<FoundPuncture> found;
  for (std::size_t k = base; k < solution.size(); k += 6) {
    FoundPuncture puncture;
    puncture.law = PunctureFrom(solution.subspan(k));
    puncture.contact_mm = fit.Bounded(k);
    puncture.puncture_mm = fit.Bounded(k + 1);
    Eigen::VectorXd gradient = Eigen::VectorXd::Zero(fit.covariance.rows());
    const double x = puncture.law.puncture_mm;
    const auto row = static_cast<Eigen::Index>(k);
    gradient(row + 1) = puncture.law.a1_n_per_mm + 2.0 * puncture.law.a2_n_per_mm2 * x;
    gradient(row + 2) = x;
    gradient(row + 3) = x * x;
    puncture.peak_n = fit.Of(puncture.law.PeakN(), gradient);
    puncture.step_n = fit.Bounded(k + 5);
    found.push_back(puncture);
  }
  return found;
}

std::vector<FoundRelease> FindReleases(const StrainedRows& rows, const SearchLimits& limits,
                                       ResistanceProfile& profile) {
  FitProfile(rows, {}, profile);
  if (rows.depth_mm.size() < 60) return {};
  const Candidates candidates = [&](const Pursuit& pursuit, Choice& best) {
    double last_mm = 1e9;
    for (const double depth : rows.depth_mm) {
      if (std::abs(depth - last_mm) < 0.5) continue;
      last_mm = depth;
      for (const double width : kWidthsMm) pursuit.Try(ReleaseShape(rows, depth, width), 0, best);
    }
  };
  const Size size = [](const Choice& c) { return std::abs(c.factor(0)); };
  std::vector<Choice> choices = Search(rows, profile.depth_mm, limits, candidates, size, 3.0);
  if (choices.empty()) return {};
  Balance(rows, choices, profile);

  const auto [low_mm, high_mm] = std::ranges::minmax(rows.depth_mm);
  std::vector<SeriesParameter> parameters = ProfileParameters(profile);
  const std::size_t base = parameters.size();
  for (const Choice& c : choices) {
    parameters.push_back({"at", c.place[0], std::max(low_mm - 0.1, c.place[0] - 2.0),
                          std::min(high_mm + 0.1, c.place[0] + 2.0)});
    parameters.push_back({"width", c.place[1], 0.02, 4.0});
    parameters.push_back({"step", std::clamp(c.factor(0), -20.0, 20.0), -50.0, 50.0});
  }
  const SeriesModel model =
      WholeModel(rows, profile.depth_mm, [](std::span<const double> p, double depth) {
        double sum = 0.0;
        for (std::size_t k = 0; k < p.size(); k += 3) {
          sum += Release{p[k], p[k + 1], p[k + 2]}.ForceN(depth);
        }
        return sum;
      });
  const SeriesFit fit = FitSeries(model, rows.force_n, parameters, {.most_iterations = 25});
  std::ranges::copy(std::span(fit.parameters).first(base), profile.force_n.begin());
  std::vector<FoundRelease> found;
  for (std::size_t k = base; k < fit.parameters.size(); k += 3) {
    found.push_back({{fit.parameters[k], fit.parameters[k + 1], fit.parameters[k + 2]},
                     fit.Bounded(k),
                     fit.Bounded(k + 2)});
  }
  return found;
}

}  // namespace acus::fitting
