#include "acus/patient/fitting/event_pursuit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "acus/patient/fitting/least_squares.h"

namespace acus::fitting {
namespace {

constexpr double kFewestIndependent = 30.0;

Eigen::Map<const Eigen::VectorXd> AsVector(const std::vector<double>& values) {
  return {values.data(), static_cast<Eigen::Index>(values.size())};
}

/// The basis so far, orthonormal, and what it leaves.
class Pursuit {
 public:
  Pursuit(const Eigen::MatrixXd& columns, const Eigen::VectorXd& force)
      : columns_(columns), force_(force) {
    Refresh();
  }

  const Eigen::VectorXd& residual() const { return residual_; }
  double squares() const { return residual_.squaredNorm(); }

  /// What an event would bring; columns that call for a negative factor are omitted.
  void Try(const EventShape& shape, Eigen::Index positive, EventChoice& best) const {
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
  void Add(const EventChoice& choice) {
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

/// How many events are worth their parameters: the least of Akaike's criterion, with the number of
/// independent samples of what the longest list leaves (before it, the events that are still to
/// come would be taken for correlated noise).
std::size_t Worth(const std::vector<double>& squares, const Eigen::VectorXd& left,
                  double parameters) {
  const auto rows = static_cast<double>(left.size());
  const double samples = std::max(
      kFewestIndependent, rows / Inflation({left.data(), static_cast<std::size_t>(left.size())}));
  std::size_t best = 0;
  double least = 0.0;
  for (std::size_t k = 0; k < squares.size(); ++k) {
    const double criterion =
        samples * std::log(std::max(squares[k], 1e-30)) + 2.0 * parameters * static_cast<double>(k);
    if (k == 0 || criterion < least) {
      least = criterion;
      best = k;
    }
  }
  return best;
}

/// Moves the choice's place on ever finer steps while that helps.
void Refine(const Pursuit& pursuit, const EventKind& kind, EventChoice& best) {
  for (double step = 0.25; step > 0.02; step *= 0.5) {
    for (int round = 0; round < 4; ++round) {
      const double before = best.gain;
      for (std::size_t k = 0; k < best.place.size(); ++k) {
        for (const double sign : {-1.0, 1.0}) {
          std::vector<double> moved = best.place;
          // Lengths by factors; the depth by a share of the event's own length.
          moved[k] += sign * step * (k == 0 ? std::max(0.2, 0.3 * moved[1]) : moved[k]);
          pursuit.Try(kind.shape_at(moved), kind.positive, best);
        }
      }
      if (!(best.gain > before * (1.0 + 1e-6))) break;
    }
  }
}

/// Scales the events and sets the profile as they fit best together, places held.
void Balance(const StrainedRows& rows, std::vector<EventChoice>& choices,
             ResistanceProfile& profile) {
  const auto knots = static_cast<Eigen::Index>(profile.depth_mm.size());
  const auto count = static_cast<Eigen::Index>(choices.size());
  Eigen::MatrixXd columns(static_cast<Eigen::Index>(rows.depth_mm.size()), knots + count);
  columns.leftCols(knots) = ProfileColumns(rows, profile.depth_mm);
  for (Eigen::Index k = 0; k < count; ++k) {
    const EventChoice& choice = choices[static_cast<std::size_t>(k)];
    columns.col(knots + k) = choice.columns * choice.factor;
  }
  const Eigen::VectorXd solution = columns.colPivHouseholderQr().solve(AsVector(rows.force_n));
  std::copy_n(solution.begin(), knots, profile.force_n.begin());
  for (Eigen::Index k = 0; k < count; ++k) {
    choices[static_cast<std::size_t>(k)].factor *= solution(knots + k);
  }
}

}  // namespace

std::vector<EventChoice> FindEvents(const StrainedRows& rows, const EventKind& kind, double least_n,
                                    int most, ResistanceProfile& profile) {
  Pursuit pursuit(ProfileColumns(rows, profile.depth_mm), AsVector(rows.force_n));
  std::vector<EventChoice> choices;
  std::vector<double> squares = {pursuit.squares()};
  while (static_cast<int>(choices.size()) < most) {
    EventChoice best;
    for (const std::vector<double>& place : kind.places(pursuit.residual())) {
      pursuit.Try(kind.shape_at(place), kind.positive, best);
    }
    if (best.gain <= 0.0) break;
    Refine(pursuit, kind, best);
    if (kind.size_n(best) < least_n) break;
    pursuit.Add(best);
    squares.push_back(pursuit.squares());
    choices.push_back(std::move(best));
  }
  choices.resize(Worth(squares, pursuit.residual(), kind.parameters));
  std::ranges::stable_sort(choices, {}, [](const EventChoice& c) { return c.place[0]; });
  if (!choices.empty()) Balance(rows, choices, profile);
  return choices;
}

}  // namespace acus::fitting
