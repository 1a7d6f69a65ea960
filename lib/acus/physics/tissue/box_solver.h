// Least energy within bounds: which contact points stick, which slip, and with what force.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "acus/physics/tissue/triangular_factor.h"

namespace acus::tissue {

enum class ContactStatus : std::uint8_t {
  kOff,     ///< The unknown is not in use; its force is 0.
  kStick,   ///< Within its bounds: the prescribed displacement is met.
  kAtLow,   ///< At the lower bound: the displacement may be larger than prescribed.
  kAtHigh,  ///< At the upper bound: the displacement may be smaller than prescribed.
};

struct BoxCounts {
  std::int64_t num_solves = 0;
  std::int64_t num_rounds = 0;     ///< Sets of sticking points that were tried.
  std::int64_t num_swaps = 0;      ///< Unknowns that ended in another status than they began in.
  std::int64_t num_single = 0;     ///< Rounds that swapped one unknown only.
  std::int64_t num_fallbacks = 0;  ///< Solves given up for projected Gauss-Seidel.
  std::int64_t num_weak_pivots = 0;
  int most_rounds = 0;
};

/// Finds the x in [low, high] that minimises x^T S x / 2 - r^T x, S symmetric positive definite.
/// At the solution w = S x - r is 0 where x sticks, >= 0 at the lower and <= 0 at the upper bound.
///
/// Block principal pivoting as by Judice and Pires (1994, Computers & Operations Research 21,
/// 587-596): all wrong unknowns are swapped at once; when that does not help for a while, only the
/// one with the highest number, which must end (Murty 1974) as S is positive definite. The number
/// of rounds is bounded; when it is used up, projected Gauss-Seidel gives forces that keep to their
/// bounds, and the next step continues from there.
///
/// Starts from the statuses of the last solve and keeps what is still right of its factor. The
/// result depends on S, r, the bounds and those statuses only. Nothing is allocated.
class BoxSolver {
 public:
  BoxSolver() = default;
  explicit BoxSolver(int capacity);

  struct Problem {
    int size = 0;
    const double* matrix = nullptr;  ///< Lower triangle of S, row by row.
    std::ptrdiff_t stride = 0;
    const double* rhs = nullptr;
    const double* low = nullptr;
    const double* high = nullptr;
  };

  /// Unknowns in kOff are omitted. @param x  the solution, 0 where off.
  /// @return false if the rounds were used up.
  bool Solve(const Problem& problem, double* x) noexcept;

  /// S changed in these rows or columns: from `first` on nothing of the factor is right any more.
  void Forget(int first) noexcept;

  ContactStatus status(int i) const { return status_[i]; }
  void SetStatus(int i, ContactStatus status) noexcept { status_[i] = status; }

  /// S x - r of the last solution.
  double Excess(int i) const { return excess_[i]; }
  const BoxCounts& counts() const { return counts_; }

 private:
  int Bind(const Problem& problem, double* x) noexcept;
  void SolveFree(const Problem& problem, double* x) noexcept;
  void ComputeExcess(const Problem& problem, const double* x) noexcept;
  int MarkWrong(const Problem& problem, const double* x) noexcept;
  void SwapOne(int i, const Problem& problem, const double* x) noexcept;
  void Project(const Problem& problem, double* x) noexcept;

  TriangularFactor factor_;
  std::vector<ContactStatus> status_;
  std::vector<ContactStatus> before_;
  std::vector<int> free_;      ///< Sticking unknowns, ascending.
  std::vector<int> factored_;  ///< Those that the factor is of.
  std::vector<std::uint8_t> wrong_;
  std::vector<double> excess_;
  std::vector<double> work_;
  BoxCounts counts_;
};

}  // namespace acus::tissue
