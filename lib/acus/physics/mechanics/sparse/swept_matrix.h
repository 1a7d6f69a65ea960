// Mixed boundary conditions on an explicit inverse: a degree of freedom changes between "force
// given" and "displacement given" by one pivot, without a new inversion.
//
// Augmented-2010, section II.B, after DiMaio and Salcudean: x = K^-1 y, where y holds what is given
// and x what is sought. The update is the sweep operator (Goodnight 1979), which keeps the matrix
// symmetric:
//   pivot b = A_kk:  A_kk' = -1/b,  A_ik' = +-A_ik/b,  A_ij' = A_ij - A_ik A_jk / b
#pragma once

#include <Eigen/Core>
#include <vector>

namespace acus::mechanics {

/// A compliance C of up to `capacity` degrees of freedom, swept on the set D of those whose
/// displacement is given. Only its lower triangle is kept. No function but the constructors
/// allocates. Copies are independent; a copy continues with the same bits.
///
/// Two uses. The *full* update of the paper: all degrees of freedom from the beginning, O(n^2) per
/// swap. The *restricted* update: only those that touch the needle, appended with their rows of C
/// when they come into contact and dropped when they leave it, O(m^2).
class SweptMatrix {
 public:
  explicit SweptMatrix(int capacity);
  /// All of a symmetric compliance, every force given.
  static SweptMatrix Of(const Eigen::MatrixXd& compliance);

  int size() const { return size_; }
  int capacity() const { return static_cast<int>(a_.rows()); }
  bool IsDisplacement(int i) const { return displacement_[i] != 0; }

  /// Appends a degree of freedom whose force is given: what it would be, had it been there from the
  /// beginning. O(size |D|).
  /// @param row  C(size(), 0 ... size()), i.e. size() + 1 values, not swept.
  /// @pre size() < capacity().
  void Append(const double* row) noexcept;

  /// Forgets the last. @pre its force is given.
  void DropLast() noexcept;
  void Clear() noexcept { size_ = 0; }

  /// Changes `k` from force given to displacement given or back.
  /// @return false, and nothing is changed, if the pivot is not a positive compliance (stiffness).
  bool Swap(int k) noexcept;

  /// x_i for the first `count` (< 0: all) of size(): the displacement where the force is given, the
  /// force where the displacement is. y holds what is given.
  void Solve(const double* y, double* x, int count = -1) const noexcept;

  /// The same for one unknown.
  double SolveOne(const double* y, int i) const noexcept;

  /// How wrong the forces in x are, N: the displacements that C gives for them, compared with those
  /// that were given, as forces. Zero if nothing is displaced. O(size^2).
  /// @param compliance  C, not swept, row by row at `stride`; @param x  what Solve() gave for y.
  double ForceError(const double* compliance, int stride, const double* y,
                    const double* x) noexcept;

  /// Starts again from C, row by row at `stride`, and sweeps the same set D: removes what a long
  /// history of swaps has left. O(size^2 |D|). @return false if a pivot was not positive.
  bool Rebuild(const double* compliance, int stride) noexcept;

  /// Starts again from all of a compliance of the same size, every force given.
  void Reset(const Eigen::MatrixXd& compliance) noexcept;

  /// Turns the pair (k, k + 1) of degrees of freedom to other axes in their plane: new first axis =
  /// cosine * first + sine * second. @pre both forces are given.
  void Rotate(int k, double cosine, double sine) noexcept;

  /// Element (i, j) of the swept matrix.
  double At(int i, int j) const { return i >= j ? a_(i, j) : a_(j, i); }

 private:
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  RowMajor a_;
  std::vector<char> displacement_;
  Eigen::VectorXd column_;  ///< Scratch, as the next.
  Eigen::VectorXd residual_;
  int size_ = 0;
};

}  // namespace acus::mechanics
