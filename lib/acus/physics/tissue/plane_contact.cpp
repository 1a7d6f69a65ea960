#include "acus/physics/tissue/plane_contact.h"

#include <algorithm>
#include <cmath>

#include "acus/base/core/error.h"

namespace acus::tissue {
namespace {

constexpr double kForceSlackN = 1e-10;  // Beyond a bound by less is at the bound.
constexpr double kSlideSlackMm = 1e-10;
constexpr int kBlockTries = 8;       // Rounds of many swaps that may fail to lessen what is wrong.
constexpr double kShortStep = 1e-3;  // Below it a series is exact and differences are not.

/// A first-order lag over a step in which its input changes evenly: what remains of it, and its
/// answer to the input at both ends.
struct RampStep {
  double decay = 1.0;
  double by_begin = 0.0;
  double by_end = 0.0;
};

/// @param x  duration over time constant, > 0.
RampStep RampStepOf(double x) noexcept {
  RampStep step;
  const double gone = -std::expm1(-x);
  step.decay = 1.0 - gone;
  step.by_end =
      x < kShortStep ? x * (0.5 - x * (1.0 / 6.0 - x * (1.0 / 24.0 - x / 120.0))) : 1.0 - gone / x;
  step.by_begin = gone - step.by_end;
  return step;
}

}  // namespace

PlaneContact::PlaneContact(const Eigen::MatrixXd& compliance, int capacity, PlaneUpdate update,
                           const mechanics::Relaxation& relaxation)
    : compliance_(&compliance),
      update_(update),
      base_(RowMajor::Zero(capacity, capacity)),
      swept_(update == PlaneUpdate::kFull ? mechanics::SweptMatrix::Of(compliance)
                                          : mechanics::SweptMatrix(capacity)),
      dof_(capacity / 2, 0),
      cosine_(capacity / 2, 1.0),
      sine_(capacity / 2, 0.0),
      status_(capacity, SlotStatus::kAtLow),
      relaxation_(relaxation),
      lag_(RowMajor::Zero(relaxation.num_terms, capacity)) {
  ACUS_ASSERT(capacity % 2 == 0);
  for (Eigen::VectorXd* v : {&target_, &low_, &high_, &elastic_low_, &elastic_high_, &given_,
                             &found_, &force_, &moved_, &residual_, &held_}) {
    v->setZero(capacity);
  }
}

void PlaneContact::Pass(double duration_s) noexcept {
  if (relaxation_.num_terms == 0) return;
  held_.head(size_).setZero();
  alpha_ = 1.0;
  for (int k = 0; k < relaxation_.num_terms; ++k) {
    const auto& [share, time_s] = relaxation_.term[k];
    const RampStep step = RampStepOf(duration_s / time_s);
    auto lag = lag_.row(k).head(size_).transpose();
    const auto elastic = force_.head(size_);
    lag += gain_[k] * elastic;  // q at the end of the last step.
    lag = step.decay * lag + share * step.by_begin * elastic;
    held_.head(size_) += lag;
    gain_[k] = share * step.by_end;
    alpha_ -= gain_[k];
  }
}

PlaneContact::Past PlaneContact::PastOf(int pair) const noexcept {
  Past past{};
  for (int k = 0; k < relaxation_.num_terms; ++k) {
    past[k] = {lag_(k, 2 * pair), lag_(k, 2 * pair + 1)};
  }
  return past;
}

void PlaneContact::SetPast(int pair, const Past& past_n) noexcept {
  for (const int i : {0, 1}) {
    Forget(2 * pair + i);
    for (int k = 0; k < relaxation_.num_terms; ++k) {
      lag_(k, 2 * pair + i) = past_n[k][i];
      held_[2 * pair + i] += past_n[k][i];
    }
  }
}

void PlaneContact::Forget(int i) noexcept {
  held_[i] = 0.0;
  for (int k = 0; k < relaxation_.num_terms; ++k) lag_(k, i) = 0.0;
}

void PlaneContact::Append(int dof, double cosine, double sine) noexcept {
  ACUS_ASSERT(size_ + 2 <= capacity());
  const int pair = size_ / 2;
  dof_[pair] = dof;
  cosine_[pair] = cosine;
  sine_[pair] = sine;
  const Eigen::MatrixXd& c = *compliance_;
  for (int p = 0; p <= pair; ++p) {
    const double block[2][2] = {{c(dof_[p], dof), c(dof_[p], dof + 1)},
                                {c(dof_[p] + 1, dof), c(dof_[p] + 1, dof + 1)}};
    const double theirs[2][2] = {{cosine_[p], sine_[p]}, {-sine_[p], cosine_[p]}};
    const double ours[2][2] = {{cosine, sine}, {-sine, cosine}};
    for (int i = 0; i < 2; ++i) {
      for (int j = 0; j < 2; ++j) {
        double sum = 0.0;
        for (int k = 0; k < 2; ++k) {
          for (int l = 0; l < 2; ++l) sum += theirs[i][k] * block[k][l] * ours[j][l];
        }
        base_(2 * p + i, size_ + j) = base_(size_ + j, 2 * p + i) = sum;
      }
    }
  }
  if (update_ == PlaneUpdate::kFull) {
    swept_.Rotate(dof, cosine, sine);
  } else {
    swept_.Append(base_.row(size_).data());
    swept_.Append(base_.row(size_ + 1).data());
  }
  for (const int i : {size_, size_ + 1}) {
    status_[i] = SlotStatus::kAtLow;
    target_[i] = low_[i] = high_[i] = given_[i] = force_[i] = 0.0;
    elastic_low_[i] = elastic_high_[i] = 0.0;
    Forget(i);
  }
  size_ += 2;
  Apply();  // Where the node is by what the others do.
}

void PlaneContact::DropLast() noexcept {
  for (const int i : {size_ - 1, size_ - 2}) {
    if (status_[i] == SlotStatus::kStick) Swap(i, SlotStatus::kAtLow);
  }
  size_ -= 2;
  if (update_ == PlaneUpdate::kFull) {
    const int pair = size_ / 2;
    swept_.Rotate(dof_[pair], cosine_[pair], -sine_[pair]);
  } else {
    swept_.DropLast();
    swept_.DropLast();
  }
}

void PlaneContact::Clear() noexcept {
  size_ = 0;
  if (update_ == PlaneUpdate::kFull) {
    ResetFull();
  } else {
    swept_.Clear();
  }
}

void PlaneContact::ResetFull() noexcept {
  swept_.Reset(*compliance_);
  for (int pair = 0; pair < size_ / 2; ++pair) {
    swept_.Rotate(dof_[pair], cosine_[pair], sine_[pair]);
  }
}

void PlaneContact::Rebuild() noexcept {
  ++num_rebuilds_;
  if (update_ == PlaneUpdate::kRestricted) {
    swept_.Rebuild(base_.data(), capacity());
    return;
  }
  ResetFull();
  for (int i = 0; i < size_; ++i) {
    if (status_[i] == SlotStatus::kStick) swept_.Swap(RowOf(i));
  }
}

void PlaneContact::Swap(int i, SlotStatus to) noexcept {
  const bool was_stick = status_[i] == SlotStatus::kStick;
  const bool is_stick = to == SlotStatus::kStick;
  if (was_stick != is_stick) {
    if (!swept_.Swap(RowOf(i))) return;  // No usable pivot: it stays as it is.
    ++num_swaps_;
  }
  status_[i] = to;
  given_[i] =
      is_stick ? target_[i] : (to == SlotStatus::kAtLow ? elastic_low_[i] : elastic_high_[i]);
}

void PlaneContact::Gather(const double* y, double* x) const noexcept {
  if (update_ == PlaneUpdate::kRestricted) {
    swept_.Solve(y, x);
    return;
  }
  for (int i = 0; i < size_; ++i) {
    double sum = 0.0;
    for (int j = 0; j < size_; ++j) sum += swept_.At(RowOf(i), RowOf(j)) * y[j];
    x[i] = status_[i] == SlotStatus::kStick ? -sum : sum;
  }
}

void PlaneContact::Apply() noexcept {
  Gather(given_.data(), found_.data());
  for (int i = 0; i < size_; ++i) {
    const bool sticks = status_[i] == SlotStatus::kStick;
    force_[i] = sticks ? spoil_ * found_[i] : given_[i];
    moved_[i] = sticks ? given_[i] : found_[i];
  }
}

/// The displacements that the compliance gives for these forces, compared with what was given, as
/// forces.
double PlaneContact::ForceError() noexcept {
  for (int i = 0; i < size_; ++i) {
    residual_[i] = 0.0;
    if (status_[i] != SlotStatus::kStick) continue;
    residual_[i] = given_[i] - base_.row(i).head(size_).dot(force_.head(size_));
  }
  Gather(residual_.data(), found_.data());
  double largest = 0.0;
  for (int i = 0; i < size_; ++i) {
    if (status_[i] != SlotStatus::kStick) continue;
    if (!(std::abs(found_[i]) <= largest)) largest = std::abs(found_[i]);  // NaN counts.
  }
  return largest;
}

bool PlaneContact::IsWrong(int i, SlotStatus& to) const noexcept {
  if (low_[i] >= high_[i]) return false;
  switch (status_[i]) {
    case SlotStatus::kStick:
      to = force_[i] > elastic_high_[i] ? SlotStatus::kAtHigh : SlotStatus::kAtLow;
      return force_[i] > elastic_high_[i] + kForceSlackN ||
             force_[i] < elastic_low_[i] - kForceSlackN;
    case SlotStatus::kAtHigh:  // Pushed as hard as it may: the tissue must stay behind.
      to = SlotStatus::kStick;
      return moved_[i] > target_[i] + kSlideSlackMm;
    case SlotStatus::kAtLow:
      to = SlotStatus::kStick;
      return moved_[i] < target_[i] - kSlideSlackMm;
  }
  return false;
}

/// Block principal pivoting; when that does not lessen what is wrong, the one with the highest
/// number only, which must end for a positive definite matrix (Murty 1974).
bool PlaneContact::Pivot() noexcept {
  int fewest = size_ + 1;
  int tries = kBlockTries;
  const int most_rounds = 40 + 4 * size_;
  for (int round = 1; round <= most_rounds; ++round) {
    Apply();
    most_rounds_ = std::max(most_rounds_, round);
    int num_wrong = 0;
    int last_wrong = -1;
    SlotStatus to = SlotStatus::kStick;
    for (int i = 0; i < size_; ++i) {
      if (!IsWrong(i, to)) continue;
      ++num_wrong;
      last_wrong = i;
    }
    if (num_wrong == 0) return true;
    if (num_wrong < fewest) {
      fewest = num_wrong;
      tries = kBlockTries;
    } else {
      --tries;
    }
    for (int i = tries > 0 ? 0 : last_wrong; i <= last_wrong; ++i) {
      if (IsWrong(i, to)) Swap(i, to);
    }
  }
  return false;
}

bool PlaneContact::Solve(double force_error_n) noexcept {
  for (int i = 0; i < size_; ++i) {
    SlotStatus to = status_[i];
    if (low_[i] >= high_[i]) to = SlotStatus::kAtLow;
    Swap(i, to);  // Takes in the new demands.
  }
  bool solved = Pivot();
  if (ForceError() > force_error_n) {
    spoil_ = 1.0;
    Rebuild();
    solved = Pivot();
  }
  if (solved) return true;
  ++num_unresolved_;
  for (int i = 0; i < size_; ++i) {
    if (low_[i] < high_[i]) {
      force_[i] = std::clamp(force_[i], elastic_low_[i], elastic_high_[i]);
    }
    if (!std::isfinite(force_[i])) force_[i] = elastic_low_[i];
  }
  return false;
}

}  // namespace acus::tissue
