#include "acus/physics/tissue/triangular_factor.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "acus/base/core/error.h"

namespace acus::tissue {
namespace {

// A pivot below this share of its diagonal is rounding error: kept positive so that forces stay
// finite.
constexpr double kLeastPivotShare = 1e-13;
constexpr int kBlock = 8;
constexpr int kMostColumns = 1024;

template <int kWidth>
inline void SubtractBlock(double* acc, const double* coefficient, const double* rows,
                          std::ptrdiff_t stride, int num_rows) noexcept {
  using Block = Eigen::Array<double, kWidth, 1>;
  Block sum = Eigen::Map<const Block>(acc);
  for (int k = 0; k < num_rows; ++k) {
    sum -= coefficient[k] * Eigen::Map<const Block>(rows + k * stride);
  }
  Eigen::Map<Block>{acc} = sum;
}

}  // namespace

void SubtractRows(double* acc, int width, const double* coefficient, const double* rows,
                  std::ptrdiff_t stride, int num_rows) noexcept {
  int j = 0;
  for (; j + 16 <= width; j += 16) {
    SubtractBlock<16>(acc + j, coefficient, rows + j, stride, num_rows);
  }
  for (; j + 4 <= width; j += 4) {
    SubtractBlock<4>(acc + j, coefficient, rows + j, stride, num_rows);
  }
  for (; j < width; ++j) SubtractBlock<1>(acc + j, coefficient, rows + j, stride, num_rows);
}

double Dot(const double* a, const double* b, int size) noexcept {
  using Block = Eigen::Array<double, kBlock, 1>;
  Block sum = Block::Zero();
  int i = 0;
  for (; i + kBlock <= size; i += kBlock) {
    sum += Eigen::Map<const Block>(a + i) * Eigen::Map<const Block>(b + i);
  }
  double rest = 0.0;
  for (; i < size; ++i) rest += a[i] * b[i];
  return ((sum[0] + sum[1]) + (sum[2] + sum[3])) + ((sum[4] + sum[5]) + (sum[6] + sum[7])) + rest;
}

TriangularFactor::TriangularFactor(int capacity)
    : stride_((capacity + 15) / 16 * 16),
      u_(static_cast<std::size_t>(stride_) * static_cast<std::size_t>(capacity), 0.0),
      inverse_(static_cast<std::size_t>(capacity), 0.0) {
  ACUS_ASSERT(capacity <= kMostColumns);
}

void TriangularFactor::Truncate(int size) noexcept {
  size_ = std::min(size_, size);
}

bool TriangularFactor::SetPivot(int k, double pivot, double diagonal) noexcept {
  const double least = kLeastPivotShare * std::abs(diagonal);
  const bool good = pivot > least;
  const double root = std::sqrt(good ? pivot : std::max(least, 1e-300));
  Row(k)[k] = root;
  inverse_[k] = 1.0 / root;
  return good;
}

bool TriangularFactor::Append(double* column) noexcept {
  const double diagonal = column[size_];
  SolveLower(column);
  double pivot = diagonal;
  for (int k = 0; k < size_; ++k) {
    Row(k)[size_] = column[k];
    pivot -= column[k] * column[k];
  }
  const bool good = SetPivot(size_, pivot, diagonal);
  column[size_] = Row(size_)[size_];
  ++size_;
  return good;
}

int TriangularFactor::FinishColumns(int count) noexcept {
  const int first = size_;
  const int last = size_ + count;
  int raised = 0;
  double above[kMostColumns];
  for (int k = 0; k < last; ++k) {
    const int begin = std::max(k, first);
    double* row = Row(k);
    for (int q = 0; q < k; ++q) above[q] = Row(q)[k];
    const double diagonal = row[k];
    SubtractRows(row + begin, last - begin, above, u_.data() + begin, stride_, k);
    if (k >= first && !SetPivot(k, row[k], diagonal)) ++raised;
    for (int j = std::max(k + 1, first); j < last; ++j) row[j] *= inverse_[k];
  }
  size_ = last;
  return raised;
}

void TriangularFactor::SolveLower(double* x) const noexcept {
  for (int begin = 0; begin < size_; begin += kBlock) {
    const int end = std::min(begin + kBlock, size_);
    for (int k = begin; k < end; ++k) {
      x[k] *= inverse_[k];
      const double* row = Row(k);
      for (int j = k + 1; j < end; ++j) x[j] -= x[k] * row[j];
    }
    SubtractRows(x + end, size_ - end, x + begin, Row(begin) + end, stride_, end - begin);
  }
}

void TriangularFactor::SolveUpper(double* x) const noexcept {
  for (int k = size_ - 1; k >= 0; --k) {
    const double* row = Row(k);
    x[k] = (x[k] - Dot(row + k + 1, x + k + 1, size_ - k - 1)) * inverse_[k];
  }
}

}  // namespace acus::tissue
