#include "acus/physics/mechanics/sparse/swept_matrix.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "acus/base/core/error.h"

namespace acus::mechanics {

SweptMatrix::SweptMatrix(int capacity)
    : a_(RowMajor::Zero(capacity, capacity)),
      displacement_(capacity, 0),
      column_(Eigen::VectorXd::Zero(capacity)),
      residual_(Eigen::VectorXd::Zero(capacity)) {}

SweptMatrix SweptMatrix::Of(const Eigen::MatrixXd& compliance) {
  ACUS_ASSERT(compliance.rows() == compliance.cols());
  SweptMatrix out(static_cast<int>(compliance.rows()));
  out.a_ = compliance;
  out.size_ = out.capacity();
  return out;
}

void SweptMatrix::Append(const double* row) noexcept {
  const int k = size_;
  // t_i = sum over D of A_il C_lk; A_DD is -C_DD^-1 and A_SD is C_SD C_DD^-1.
  double pivot = row[k];
  for (int i = 0; i < k; ++i) {
    double t = 0.0;
    for (int l = 0; l < k; ++l) {
      if (displacement_[l] != 0) t += At(i, l) * row[l];
    }
    a_(k, i) = displacement_[i] != 0 ? -t : row[i] - t;
    if (displacement_[i] != 0) pivot += row[i] * t;
  }
  a_(k, k) = pivot;
  displacement_[k] = 0;
  ++size_;
}

void SweptMatrix::DropLast() noexcept {
  ACUS_ASSERT(size_ > 0 && displacement_[size_ - 1] == 0);
  --size_;
}

bool SweptMatrix::Swap(int k) noexcept {
  const bool sweep = displacement_[k] == 0;
  const double pivot = a_(k, k);
  // Free: a compliance, > 0. Displaced: minus a stiffness, < 0.
  if (!(sweep ? pivot > 0.0 : pivot < 0.0) || !std::isfinite(pivot)) return false;
  column_.head(k) = a_.row(k).head(k).transpose();
  column_[k] = 0.0;
  for (int i = k + 1; i < size_; ++i) column_[i] = a_(i, k);
  const double inverse = 1.0 / pivot;
  for (int i = 0; i < size_; ++i) {
    const double factor = column_[i] * inverse;
    if (factor == 0.0) continue;
    a_.row(i).head(i + 1) -= factor * column_.head(i + 1).transpose();
  }
  const double sign = sweep ? inverse : -inverse;
  a_.row(k).head(k) = sign * column_.head(k).transpose();
  for (int i = k + 1; i < size_; ++i) a_(i, k) = sign * column_[i];
  a_(k, k) = -inverse;
  displacement_[k] = sweep ? 1 : 0;
  return true;
}

double SweptMatrix::SolveOne(const double* y, int i) const noexcept {
  double sum = 0.0;
  for (int j = 0; j <= i; ++j) sum += a_(i, j) * y[j];
  for (int j = i + 1; j < size_; ++j) sum += a_(j, i) * y[j];
  return displacement_[i] != 0 ? -sum : sum;
}

void SweptMatrix::Solve(const double* y, double* x, int count) const noexcept {
  if (count < 0) count = size_;
  for (int i = 0; i < count; ++i) x[i] = 0.0;
  for (int i = 0; i < size_; ++i) {
    const double* row = a_.row(i).data();
    const int end = i < count ? i : count;
    double sum = 0.0;
    for (int j = 0; j < end; ++j) {
      sum += row[j] * y[j];
      x[j] += row[j] * y[i];
    }
    if (i < count) x[i] += sum + row[i] * y[i];
  }
  for (int i = 0; i < count; ++i) {
    if (displacement_[i] != 0) x[i] = -x[i];
  }
}

double SweptMatrix::ForceError(const double* compliance, int stride, const double* y,
                               const double* x) noexcept {
  for (int i = 0; i < size_; ++i) column_[i] = displacement_[i] != 0 ? x[i] : y[i];
  for (int i = 0; i < size_; ++i) {
    residual_[i] = 0.0;
    if (displacement_[i] == 0) continue;
    const double* row = compliance + static_cast<std::ptrdiff_t>(i) * stride;
    double displacement = 0.0;
    for (int j = 0; j < size_; ++j) displacement += row[j] * column_[j];
    residual_[i] = y[i] - displacement;
  }
  Solve(residual_.data(), column_.data());
  double largest = 0.0;
  for (int i = 0; i < size_; ++i) {
    if (displacement_[i] == 0) continue;
    if (!(std::abs(column_[i]) <= largest)) largest = std::abs(column_[i]);  // NaN counts.
  }
  return largest;
}

bool SweptMatrix::Rebuild(const double* compliance, int stride) noexcept {
  for (int i = 0; i < size_; ++i) {
    for (int j = 0; j <= i; ++j) a_(i, j) = compliance[static_cast<std::ptrdiff_t>(i) * stride + j];
  }
  bool good = true;
  for (int k = 0; k < size_; ++k) {
    if (displacement_[k] == 0) continue;
    displacement_[k] = 0;
    good = Swap(k) && good;
  }
  return good;
}

void SweptMatrix::Reset(const Eigen::MatrixXd& compliance) noexcept {
  ACUS_ASSERT(compliance.rows() == capacity());
  // Symmetric: its columns are the rows, without the buffer that a change of order would take.
  for (int i = 0; i < capacity(); ++i)
    a_.row(i).head(i + 1) = compliance.col(i).head(i + 1).transpose();
  std::fill(displacement_.begin(), displacement_.end(), 0);
  size_ = capacity();
}

void SweptMatrix::Rotate(int k, double cosine, double sine) noexcept {
  ACUS_ASSERT(displacement_[k] == 0 && displacement_[k + 1] == 0);
  const auto turn = [&](double& first, double& second) {
    const double old = first;
    first = cosine * old + sine * second;
    second = cosine * second - sine * old;
  };
  for (int j = 0; j < k; ++j) turn(a_(k, j), a_(k + 1, j));
  for (int i = k + 2; i < size_; ++i) turn(a_(i, k), a_(i, k + 1));
  const double aa = a_(k, k);
  const double ab = a_(k + 1, k);
  const double bb = a_(k + 1, k + 1);
  a_(k, k) = cosine * cosine * aa + 2.0 * cosine * sine * ab + sine * sine * bb;
  a_(k + 1, k + 1) = sine * sine * aa - 2.0 * cosine * sine * ab + cosine * cosine * bb;
  a_(k + 1, k) = cosine * sine * (bb - aa) + (cosine * cosine - sine * sine) * ab;
}

}  // namespace acus::mechanics
