#include "acus/physics/tissue/box_solver.h"

#include <algorithm>
#include <cmath>

namespace acus::tissue {
namespace {

constexpr int kBlockRoundsWithoutGain = 5;
constexpr int kMostBlockRounds = 30;
constexpr int kMostRounds = 120;
constexpr int kProjectedSweeps = 60;
// Share of the force (N) within which a bound counts as kept, and of the displacement through S.
constexpr double kForceTolerance = 1e-13;

}  // namespace

BoxSolver::BoxSolver(int capacity)
    : factor_(capacity),
      status_(static_cast<std::size_t>(capacity), ContactStatus::kOff),
      before_(status_),
      wrong_(status_.size(), 0),
      excess_(status_.size(), 0.0),
      work_(status_.size(), 0.0) {
  free_.reserve(status_.size());
  factored_.reserve(status_.size());
}

void BoxSolver::Forget(int first) noexcept {
  const auto keep = std::ranges::lower_bound(factored_, first) - factored_.begin();
  factored_.resize(static_cast<std::size_t>(keep));
  factor_.Truncate(static_cast<int>(keep));
}

/// Puts bound unknowns on their bounds and lists the free ones. Returns how many are free.
int BoxSolver::Bind(const Problem& problem, double* x) noexcept {
  free_.clear();
  for (int i = 0; i < problem.size; ++i) {
    if (status_[i] == ContactStatus::kStick && !(problem.low[i] < problem.high[i])) {
      status_[i] = ContactStatus::kAtLow;
    }
    if (status_[i] == ContactStatus::kAtHigh && !std::isfinite(problem.high[i])) {
      status_[i] = ContactStatus::kStick;
    }
    switch (status_[i]) {
      case ContactStatus::kOff:
        x[i] = 0.0;
        break;
      case ContactStatus::kAtLow:
        x[i] = problem.low[i];
        break;
      case ContactStatus::kAtHigh:
        x[i] = problem.high[i];
        break;
      case ContactStatus::kStick:
        x[i] = 0.0;
        free_.push_back(i);
        break;
    }
  }
  return static_cast<int>(free_.size());
}

void BoxSolver::SolveFree(const Problem& problem, double* x) noexcept {
  const auto same = std::ranges::mismatch(free_, factored_).in1 - free_.begin();
  const int keep = static_cast<int>(same);
  const int count = static_cast<int>(free_.size());
  factor_.Truncate(keep);
  factored_.resize(free_.size());
  for (int j = keep; j < count; ++j) {
    factored_[j] = free_[j];
    const double* row = problem.matrix + free_[j] * problem.stride;
    for (int k = 0; k <= j; ++k) factor_.Row(k)[j] = row[free_[k]];
  }
  counts_.num_weak_pivots += factor_.FinishColumns(count - keep);

  ComputeExcess(problem, x);  // With 0 for the free ones: minus the right-hand side.
  for (int k = 0; k < count; ++k) work_[k] = -excess_[free_[k]];
  factor_.SolveLower(work_.data());
  factor_.SolveUpper(work_.data());
  for (int k = 0; k < count; ++k) x[free_[k]] = work_[k];
}

void BoxSolver::ComputeExcess(const Problem& problem, const double* x) noexcept {
  for (int i = 0; i < problem.size; ++i) excess_[i] = -problem.rhs[i];
  for (int i = 0; i < problem.size; ++i) {
    const double* row = problem.matrix + i * problem.stride;
    if (status_[i] == ContactStatus::kOff) continue;
    excess_[i] += Dot(row, x, i) + row[i] * x[i];
    if (x[i] == 0.0) continue;
    const double minus = -x[i];
    SubtractRows(excess_.data(), i, &minus, row, 0, 1);
  }
}

/// Marks the unknowns that are on the wrong side and returns their number.
int BoxSolver::MarkWrong(const Problem& problem, const double* x) noexcept {
  double largest_n = 1.0;
  double largest_mm = 0.0;
  for (int i = 0; i < problem.size; ++i) {
    largest_n = std::max(largest_n, std::abs(x[i]));
    largest_mm = std::max(largest_mm, std::abs(problem.rhs[i]));
  }
  const double slack_n = kForceTolerance * largest_n;
  int num_wrong = 0;
  for (int i = 0; i < problem.size; ++i) {
    const double slack_mm =
        10.0 * slack_n * problem.matrix[i * problem.stride + i] + kForceTolerance * largest_mm;
    bool wrong = false;
    switch (status_[i]) {
      case ContactStatus::kOff:
        break;
      case ContactStatus::kStick:
        wrong = !(x[i] >= problem.low[i] - slack_n && x[i] <= problem.high[i] + slack_n);
        break;
      case ContactStatus::kAtLow:
        wrong = !(excess_[i] >= -slack_mm) && problem.low[i] < problem.high[i];
        break;
      case ContactStatus::kAtHigh:
        wrong = !(excess_[i] <= slack_mm) && problem.low[i] < problem.high[i];
        break;
    }
    wrong_[i] = wrong ? 1 : 0;
    num_wrong += wrong_[i];
  }
  return num_wrong;
}

void BoxSolver::SwapOne(int i, const Problem& problem, const double* x) noexcept {
  if (status_[i] == ContactStatus::kStick) {
    status_[i] = x[i] > problem.high[i] ? ContactStatus::kAtHigh : ContactStatus::kAtLow;
  } else {
    status_[i] = ContactStatus::kStick;
  }
}

bool BoxSolver::Solve(const Problem& problem, double* x) noexcept {
  ++counts_.num_solves;
  std::copy_n(status_.begin(), problem.size, before_.begin());
  int least_wrong = problem.size + 1;
  int tries = kBlockRoundsWithoutGain;
  int round = 0;
  bool solved = false;
  while (round < kMostRounds) {
    ++round;
    Bind(problem, x);
    SolveFree(problem, x);
    ComputeExcess(problem, x);
    const int num_wrong = MarkWrong(problem, x);
    if (num_wrong == 0) {
      solved = true;
      break;
    }
    if (num_wrong < least_wrong) {
      least_wrong = num_wrong;
      tries = kBlockRoundsWithoutGain;
    } else {
      --tries;
    }
    if (tries > 0 && round < kMostBlockRounds) {
      for (int i = 0; i < problem.size; ++i) {
        if (wrong_[i] != 0) SwapOne(i, problem, x);
      }
    } else {
      ++counts_.num_single;
      int last = problem.size - 1;
      while (wrong_[last] == 0) --last;
      SwapOne(last, problem, x);
    }
  }
  if (!solved) {
    ++counts_.num_fallbacks;
    Project(problem, x);
  }
  for (int i = 0; i < problem.size; ++i) {
    if (status_[i] == ContactStatus::kOff) continue;
    x[i] = std::clamp(x[i], problem.low[i], problem.high[i]);
    if (status_[i] != before_[i]) ++counts_.num_swaps;
  }
  counts_.num_rounds += round;
  counts_.most_rounds = std::max(counts_.most_rounds, round);
  return solved;
}

/// Projected Gauss-Seidel: every sweep lowers the energy and keeps to the bounds.
void BoxSolver::Project(const Problem& problem, double* x) noexcept {
  const auto at = [&](int i, int j) {
    return problem.matrix[std::max(i, j) * problem.stride + std::min(i, j)];
  };
  for (int i = 0; i < problem.size; ++i) {
    if (status_[i] == ContactStatus::kOff) continue;
    if (!std::isfinite(x[i])) x[i] = 0.0;
    x[i] = std::clamp(x[i], problem.low[i], problem.high[i]);
  }
  for (int sweep = 0; sweep < kProjectedSweeps; ++sweep) {
    for (int i = 0; i < problem.size; ++i) {
      if (status_[i] == ContactStatus::kOff) continue;
      double excess = -problem.rhs[i];
      for (int j = 0; j < problem.size; ++j) excess += at(i, j) * x[j];
      if (!std::isfinite(excess)) continue;
      x[i] = std::clamp(x[i] - excess / at(i, i), problem.low[i], problem.high[i]);
    }
  }
  for (int i = 0; i < problem.size; ++i) {
    if (status_[i] == ContactStatus::kOff) continue;
    status_[i] = x[i] <= problem.low[i]    ? ContactStatus::kAtLow
                 : x[i] >= problem.high[i] ? ContactStatus::kAtHigh
                                           : ContactStatus::kStick;
  }
  ComputeExcess(problem, x);
}

}  // namespace acus::tissue
