// Dense Cholesky factors that grow and shrink at their end, for a few hundred unknowns.
#pragma once

#include <cstddef>
#include <vector>

namespace acus::tissue {

/// acc[j] -= sum over k of coefficient[k] * rows[k * stride + j], j < width, k ascending for each
/// j: the same bits however the work is cut up.
void SubtractRows(double* acc, int width, const double* coefficient, const double* rows,
                  std::ptrdiff_t stride, int num_rows) noexcept;

/// Scalar product with a fixed order of the sum.
double Dot(const double* a, const double* b, int size) noexcept;

/// U of A = U^T U, row by row with a fixed stride. All storage is made at construction.
///
/// Column j of U depends on columns 0 to j of A only. So dropping columns at the end and appending
/// others leaves, bit for bit, the factor that a fresh start would give: nothing drifts.
class TriangularFactor {
 public:
  TriangularFactor() = default;
  explicit TriangularFactor(int capacity);

  int size() const { return size_; }
  void Truncate(int size) noexcept;

  /// Appends a column. @param column  A's values above and on the diagonal, size() + 1 of them;
  /// overwritten by the column of U. @return false if the pivot had to be raised to stay positive.
  bool Append(double* column) noexcept;

  /// Appends `count` columns at once; same bits as one by one. The caller has put A's values on and
  /// above the diagonal where U's will be, see Row(). @return number of pivots that had to be
  /// raised.
  int FinishColumns(int count) noexcept;

  /// Row k; entries j >= k are U's.
  double* Row(int k) noexcept { return u_.data() + k * stride_; }
  const double* Row(int k) const noexcept { return u_.data() + k * stride_; }
  std::ptrdiff_t stride() const { return stride_; }

  /// x := U^-T x.
  void SolveLower(double* x) const noexcept;
  /// x := U^-1 x.
  void SolveUpper(double* x) const noexcept;

 private:
  bool SetPivot(int k, double pivot, double diagonal) noexcept;

  int size_ = 0;
  std::ptrdiff_t stride_ = 0;
  std::vector<double> u_;
  std::vector<double> inverse_;  ///< Of the diagonal.
};

}  // namespace acus::tissue
