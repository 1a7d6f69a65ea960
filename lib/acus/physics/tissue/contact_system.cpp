#include "acus/physics/tissue/contact_system.h"

#include <algorithm>
#include <cmath>

#include "acus/base/core/error.h"
#include "acus/physics/tissue/compliance_sums.h"

namespace acus::tissue {
namespace {

constexpr int kPointsPerCopy = 8;
constexpr int kSolvesPerCheck = 16;
// Share of the largest displacement requested, but at least of 1 mm. A force is wrong by no more
// than this over the compliance of a point, some mm/N.
constexpr double kLargestResidualShare = 1e-10;

}  // namespace

ContactSystem::ContactSystem(mechanics::Compliance compliance, Capacity capacity,
                             const mechanics::Relaxation& relaxation)
    : compliance_(std::move(compliance)), capacity_(capacity), relaxation_(relaxation) {
  ACUS_ASSERT(capacity.points >= 1 && capacity.slots >= 0);
  ACUS_ASSERT(2 * capacity.points + capacity.slots <= 1000);
}

ContactState ContactSystem::NewState() const {
  const std::size_t points = capacity_.points;
  const std::size_t columns = points + capacity_.slots;
  ContactState state;
  state.num_slots_ = capacity_.slots;
  state.stride_ = static_cast<std::ptrdiff_t>((columns + 15) / 16 * 16);
  const std::size_t stride = state.stride_;
  state.point_place_.resize(points);
  state.point_local_.resize(points);
  state.slot_place_.resize(capacity_.slots);
  state.slot_direction_.resize(capacity_.slots, Eigen::Vector3d::UnitZ());
  state.slot_local_.resize(capacity_.slots, 0.0);
  state.slot_used_.resize(capacity_.slots, 0);
  state.lateral_factor_ = TriangularFactor(2 * capacity_.points);
  state.w_.resize(2 * points * stride, 0.0);
  state.s_.resize(columns * stride, 0.0);
  state.birth_.resize(points * stride, 0.0);
  state.copies_.resize(CopyBegin(capacity_.points / kPointsPerCopy + 1), 0.0);
  state.seen_mm_per_n_.resize(compliance_.num_nodes(), Eigen::Vector3d::Zero());
  state.seen_when_.resize(compliance_.num_nodes(), 0);
  state.solver_ = BoxSolver(static_cast<int>(columns));
  for (auto* of_points : {&state.lateral_mm_, &state.lateral_n_, &state.reduced_mm_, &state.first_,
                          &state.second_, &state.third_}) {
    of_points->resize(std::max(2 * points, stride), 0.0);
  }
  state.slot_extra_n_.resize(capacity_.slots, 0.0);
  state.relaxation_ = relaxation_;
  const std::size_t terms = static_cast<std::size_t>(relaxation_.num_terms);
  if (terms > 0) {
    state.held_lateral_n_.resize(2 * points, 0.0);
    state.held_n_.resize(columns, 0.0);
    state.lost_lateral_n_.resize(terms * 2 * points, 0.0);
    state.lost_n_.resize(terms * columns, 0.0);
    state.decay_.fill(1.0);
  }
  for (auto* of_columns :
       {&state.demand_mm_, &state.low_n_, &state.high_n_, &state.bounded_n_, &state.rhs_}) {
    of_columns->resize(stride, 0.0);
  }
  return state;
}

/// Where the packed copy of S after index * kPointsPerCopy points begins.
std::ptrdiff_t ContactSystem::CopyBegin(int index) const noexcept {
  std::ptrdiff_t begin = 0;
  for (int c = 0; c < index; ++c) {
    const std::ptrdiff_t size = capacity_.slots + c * kPointsPerCopy;
    begin += size * (size + 1) / 2;
  }
  return begin;
}

void ContactSystem::SaveCopy(ContactState& state, int index) const noexcept {
  double* out = state.copies_.data() + CopyBegin(index);
  const int size = capacity_.slots + index * kPointsPerCopy;
  for (int i = 0; i < size; ++i) out = std::copy_n(state.S(i), i + 1, out);
}

void ContactSystem::Pass(ContactState& state, double duration_s) const noexcept {
  if (relaxation_.num_terms == 0) return;
  const auto settle = [](double decay, double share, const double* elastic_n, const double* extra_n,
                         std::size_t num_extra, double* lost_n, std::size_t size) {
    for (std::size_t i = 0; i < size; ++i) {
      const double whole_n = elastic_n[i] + (i < num_extra ? extra_n[i] : 0.0);
      lost_n[i] = decay * lost_n[i] + (1.0 - decay) * share * whole_n;
    }
  };
  const std::size_t laterals = state.held_lateral_n_.size();
  const std::size_t columns = state.held_n_.size();
  std::ranges::fill(state.held_lateral_n_, 0.0);
  std::ranges::fill(state.held_n_, 0.0);
  state.alpha_ = 1.0;
  for (int k = 0; k < relaxation_.num_terms; ++k) {
    const std::size_t at = static_cast<std::size_t>(k);
    const auto& [share, time_s] = relaxation_.term[at];
    double* lost_lateral_n = state.lost_lateral_n_.data() + at * laterals;
    double* lost_n = state.lost_n_.data() + at * columns;
    settle(state.decay_[at], share, state.lateral_n_.data(), nullptr, 0, lost_lateral_n, laterals);
    settle(state.decay_[at], share, state.bounded_n_.data(), state.slot_extra_n_.data(),
           state.slot_extra_n_.size(), lost_n, columns);
    const double decay = std::exp(-duration_s / time_s);
    state.decay_[at] = decay;
    state.alpha_ -= share * (1.0 - decay);
    for (std::size_t i = 0; i < laterals; ++i)
      state.held_lateral_n_[i] += decay * lost_lateral_n[i];
    for (std::size_t i = 0; i < columns; ++i) state.held_n_[i] += decay * lost_n[i];
  }
}

/// Resets a column: its tissue has no history.
void ContactSystem::Forget(ContactState& state, int column) const noexcept {
  if (relaxation_.num_terms == 0) return;
  const std::size_t laterals = state.held_lateral_n_.size();
  const std::size_t columns = state.held_n_.size();
  const int point = column - state.num_slots_;
  state.held_n_[column] = 0.0;
  for (int k = 0; k < relaxation_.num_terms; ++k) state.lost_n_[k * columns + column] = 0.0;
  if (point < 0) return;
  for (int row : {2 * point, 2 * point + 1}) {
    state.held_lateral_n_[row] = 0.0;
    for (int k = 0; k < relaxation_.num_terms; ++k) state.lost_lateral_n_[k * laterals + row] = 0.0;
  }
}

void ContactSystem::Restart(ContactState& state, const Eigen::Matrix3d& frame) const noexcept {
  TruncatePoints(state, 0);
  state.frame_ = frame;
}

Eigen::Matrix3d ContactSystem::Between(const ContactPlace& a,
                                       const ContactPlace& b) const noexcept {
  return compliance_.storage() == mechanics::Storage::kFloat
             ? SumBetween<float>(compliance_, a, b)
             : SumBetween<double>(compliance_, a, b);
}

double ContactSystem::SlotBetween(const ContactState& state, int a, int b) const noexcept {
  if (a == b) {
    return compliance_.storage() == mechanics::Storage::kFloat
               ? SumWithin<float>(compliance_, state.slot_place_[a], state.slot_direction_[a])
               : SumWithin<double>(compliance_, state.slot_place_[a], state.slot_direction_[a]);
  }
  const int later = std::max(a, b);  // In one order only: the same bits whichever is asked first.
  const int earlier = std::min(a, b);
  return state.slot_direction_[later].dot(
      Between(state.slot_place_[later], state.slot_place_[earlier]) *
      state.slot_direction_[earlier]);
}

/// Displacement of a node by 1 N on a slot.
Eigen::Vector3d ContactSystem::SlotToNode(ContactState& state, int slot, int row) const noexcept {
  const bool is_kept = slot == state.seen_slot_;
  if (is_kept && state.seen_when_[row] == state.seen_now_) return state.seen_mm_per_n_[row];
  const ContactPlace& place = state.slot_place_[slot];
  const Eigen::Vector3d& direction = state.slot_direction_[slot];
  const Eigen::Vector3d moved = compliance_.storage() == mechanics::Storage::kFloat
                                    ? SumAtNode<float>(compliance_, row, place, direction)
                                    : SumAtNode<double>(compliance_, row, place, direction);
  if (is_kept) {
    state.seen_mm_per_n_[row] = moved;
    state.seen_when_[row] = state.seen_now_;
  }
  return moved;
}

Eigen::Vector3d ContactSystem::SlotToPoint(ContactState& state, int slot,
                                           const ContactPlace& point) const noexcept {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int j = 0; j < point.num_rows; ++j) {
    sum += point.weight[j] * SlotToNode(state, slot, point.row[j]);
  }
  return state.frame_.transpose() * sum;
}

Eigen::Vector3d ContactSystem::AppendPoint(ContactState& state, const ContactPlace& place,
                                           const LocalCompliance& local) const noexcept {
  const int n = state.num_points_;
  const int column = state.num_slots_ + n;
  const Eigen::Matrix3d& frame = state.frame_;
  double* row_a = state.W(2 * n);  // Become the new rows of W.
  double* row_b = state.W(2 * n + 1);
  double* row_s = state.S(column);
  double* above_a = state.first_.data();
  double* above_b = state.second_.data();
  double* axial = state.third_.data();
  Eigen::Vector3d displacement = Eigen::Vector3d::Zero();

  for (int s = 0; s < state.num_slots_; ++s) {
    Eigen::Vector3d block = Eigen::Vector3d::Zero();
    if (state.slot_used_[s] != 0) block = SlotToPoint(state, s, place);
    row_a[s] = block[0];
    row_b[s] = block[1];
    row_s[s] = block[2];
    displacement += block * state.bounded_n_[s];
  }
  for (int q = 0; q <= n; ++q) {
    const ContactPlace& other = q < n ? state.point_place_[q] : place;
    Eigen::Matrix3d block = frame.transpose() * Between(place, other) * frame;
    if (q < n) displacement += block * state.ElasticPointN(q);
    if (q == n) {
      block.diagonal() +=
          Eigen::Vector3d(local.lateral_mm_per_n, local.lateral_mm_per_n, local.axial_mm_per_n);
    }
    above_a[2 * q] = block(0, 0);
    above_b[2 * q] = block(1, 0);
    above_b[2 * q + 1] = block(1, 1);
    row_a[state.num_slots_ + q] = block(0, 2);
    row_b[state.num_slots_ + q] = block(1, 2);
    row_s[state.num_slots_ + q] = block(2, 2);
    if (q == n) break;
    above_a[2 * q + 1] = block(0, 1);
    axial[2 * q] = block(2, 0);
    axial[2 * q + 1] = block(2, 1);
  }

  // W's new column above the new rows, then the rows themselves.
  TriangularFactor& factor = state.lateral_factor_;
  factor.SolveLower(axial);
  for (int k = 0; k < 2 * n; ++k) state.W(k)[column] = axial[k];
  for (int r = 0; r < 2; ++r) {
    double* above = r == 0 ? above_a : above_b;
    double* row = r == 0 ? row_a : row_b;
    factor.Append(above);
    SubtractRows(row, column + 1, above, state.w_.data(), state.stride_, 2 * n + r);
    const double inverse = 1.0 / above[2 * n + r];  // As TriangularFactor divides.
    for (int j = 0; j <= column; ++j) row[j] *= inverse;
    axial[2 * n + r] = row[column];
  }
  SubtractRows(row_s, column + 1, axial, state.w_.data(), state.stride_, 2 * n + 2);
  std::copy_n(row_s, column + 1, state.Birth(n));
  for (int i = 0; i < column; ++i) {
    const double pair[2] = {row_a[i], row_b[i]};
    SubtractRows(state.S(i), i + 1, pair, row_a, state.stride_, 2);
  }

  state.point_place_[n] = place;
  state.point_local_[n] = local;
  state.lateral_n_[2 * n] = state.lateral_n_[2 * n + 1] = state.bounded_n_[column] = 0.0;
  state.solver_.SetStatus(column, ContactStatus::kStick);
  state.num_points_ = n + 1;
  if ((n + 1) % kPointsPerCopy == 0) SaveCopy(state, (n + 1) / kPointsPerCopy);
  state.solver_.Forget(0);
  return displacement;
}

void ContactSystem::TruncatePoints(ContactState& state, int count) const noexcept {
  if (count >= state.num_points_) return;
  const int copy = count / kPointsPerCopy;
  const int first = copy * kPointsPerCopy;
  const double* from = state.copies_.data() + CopyBegin(copy);
  for (int i = 0; i < state.num_slots_ + first; ++i) {
    std::copy_n(from, i + 1, state.S(i));
    from += i + 1;
  }
  for (int q = first; q < count; ++q) {
    const int column = state.num_slots_ + q;
    std::copy_n(state.Birth(q), column + 1, state.S(column));
    const double* rows = state.W(2 * q);
    for (int i = 0; i < column; ++i) {
      const double pair[2] = {rows[i], rows[state.stride_ + i]};
      SubtractRows(state.S(i), i + 1, pair, rows, state.stride_, 2);
    }
  }
  for (int q = count; q < state.num_points_; ++q) {
    state.lateral_n_[2 * q] = state.lateral_n_[2 * q + 1] = 0.0;
    state.bounded_n_[state.num_slots_ + q] = 0.0;
    Forget(state, state.num_slots_ + q);
  }
  state.num_points_ = count;
  state.lateral_factor_.Truncate(2 * count);
  state.solver_.Forget(0);
}

void ContactSystem::SetSlot(ContactState& state, int slot, const ContactPlace& place,
                            const Eigen::Vector3d& direction,
                            double local_mm_per_n) const noexcept {
  const int n = state.num_points_;
  const int slots = state.num_slots_;
  if (state.slot_used_[slot] == 0) state.solver_.SetStatus(slot, ContactStatus::kStick);
  state.slot_place_[slot] = place;
  state.slot_direction_[slot] = direction;
  state.slot_local_[slot] = local_mm_per_n;
  state.slot_used_[slot] = 1;
  state.seen_slot_ = slot;
  ++state.seen_now_;

  double* lateral = state.first_.data();
  double* row = state.second_.data();
  for (int s = 0; s < slots; ++s) {
    row[s] = state.slot_used_[s] != 0 ? SlotBetween(state, slot, s) : 0.0;
  }
  row[slot] += local_mm_per_n;
  for (int q = 0; q < n; ++q) {
    const Eigen::Vector3d block = SlotToPoint(state, slot, state.point_place_[q]);
    lateral[2 * q] = block[0];
    lateral[2 * q + 1] = block[1];
    row[slots + q] = block[2];
  }
  state.lateral_factor_.SolveLower(lateral);
  for (int k = 0; k < 2 * n; ++k) state.W(k)[slot] = lateral[k];

  // The row of S as it was after each point: into the copies, and into what points were born with.
  const auto save = [&](int index) {
    double* copy = state.copies_.data() + CopyBegin(index);
    for (int j = 0; j < slots + index * kPointsPerCopy; ++j) {
      const std::ptrdiff_t i = std::max(j, slot);
      copy[i * (i + 1) / 2 + std::min(j, slot)] = row[j];
    }
  };
  save(0);
  for (int q = 0; q < n; ++q) {
    SubtractRows(row, slots + n, lateral + 2 * q, state.W(2 * q), state.stride_, 2);
    state.Birth(q)[slot] = row[slots + q];
    if ((q + 1) % kPointsPerCopy == 0) save((q + 1) / kPointsPerCopy);
  }
  for (int j = 0; j < slots + n; ++j) state.S(std::max(j, slot))[std::min(j, slot)] = row[j];
  state.solver_.Forget(slot);
}

void ContactSystem::ClearSlot(ContactState& state, int slot) const noexcept {
  if (state.slot_used_[slot] == 0) return;
  state.slot_used_[slot] = 0;
  state.bounded_n_[slot] = state.slot_extra_n_[slot] = 0.0;
  Forget(state, slot);
  for (int k = 0; k < 2 * state.num_points_; ++k) state.W(k)[slot] = 0.0;
  if (state.seen_slot_ == slot) state.seen_slot_ = -1;
  state.solver_.SetStatus(slot, ContactStatus::kOff);
  state.solver_.Forget(slot);
}

void ContactSystem::Refactor(ContactState& state) const noexcept {
  const int points = state.num_points_;
  ++state.num_refactors_;
  state.num_points_ = 0;
  state.lateral_factor_.Truncate(0);
  for (int s = 0; s < state.num_slots_; ++s) {
    if (state.slot_used_[s] != 0) {
      SetSlot(state, s, state.slot_place_[s], state.slot_direction_[s], state.slot_local_[s]);
    }
  }
  for (int q = 0; q < points; ++q) {
    const ContactStatus status = state.PointStatus(q);
    AppendPoint(state, state.point_place_[q], state.point_local_[q]);
    state.solver_.SetStatus(state.num_slots_ + q, status);
  }
  state.solver_.Forget(0);
}

void ContactSystem::SolveOnce(ContactState& state, bool& solved) const noexcept {
  const int columns = state.num_slots_ + state.num_points_;
  const int rows = 2 * state.num_points_;
  double* reduced = state.reduced_mm_.data();
  std::copy_n(state.lateral_mm_.data(), rows, reduced);
  state.lateral_factor_.SolveLower(reduced);
  std::copy_n(state.demand_mm_.data(), columns, state.rhs_.data());
  SubtractRows(state.rhs_.data(), columns, reduced, state.w_.data(), state.stride_, rows);
  solved = state.solver_.Solve({.size = columns,
                                .matrix = state.s_.data(),
                                .stride = state.stride_,
                                .rhs = state.rhs_.data(),
                                .low = state.low_n_.data(),
                                .high = state.high_n_.data()},
                               state.bounded_n_.data());
  for (int k = 0; k < rows; ++k) {
    state.lateral_n_[k] = reduced[k] - Dot(state.W(k), state.bounded_n_.data(), columns);
  }
  state.lateral_factor_.SolveUpper(state.lateral_n_.data());
}

bool ContactSystem::Solve(ContactState& state) const noexcept {
  bool solved = true;
  SolveOnce(state, solved);
  if (++state.num_solves_ % kSolvesPerCheck != 0 || state.num_points_ == 0) return solved;
  state.check_next_ = (state.check_next_ + 1) % state.num_points_;
  ++state.num_checks_;
  double largest_mm = 1.0;
  for (int k = 0; k < 2 * state.num_points_; ++k) {
    largest_mm = std::max(largest_mm, std::abs(state.lateral_mm_[k]));
  }
  const double residual_mm = ResidualMm(state, state.check_next_);
  if (residual_mm <= kLargestResidualShare * largest_mm) {
    state.largest_residual_mm_ = std::max(state.largest_residual_mm_, residual_mm);
    return solved;
  }
  Refactor(state);
  SolveOnce(state, solved);
  return solved;
}

Eigen::Vector3d ContactSystem::DisplacementMm(const ContactState& state,
                                              const ContactPlace& place) const noexcept {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int s = 0; s < state.num_slots_; ++s) {
    if (state.slot_used_[s] == 0 || state.bounded_n_[s] == 0.0) continue;
    sum += Between(place, state.slot_place_[s]) * (state.slot_direction_[s] * state.bounded_n_[s]);
  }
  for (int q = 0; q < state.num_points_; ++q) {
    sum += Between(place, state.point_place_[q]) * (state.frame_ * state.ElasticPointN(q));
  }
  return sum;
}

double ContactSystem::ResidualMm(const ContactState& state, int point) const noexcept {
  const Eigen::Vector3d force_n = state.ElasticPointN(point);
  const LocalCompliance& local = state.point_local_[point];
  Eigen::Vector3d u = state.frame_.transpose() * DisplacementMm(state, state.point_place_[point]);
  u += Eigen::Vector3d(local.lateral_mm_per_n, local.lateral_mm_per_n, local.axial_mm_per_n)
           .cwiseProduct(force_n);
  const Eigen::Vector3d asked(
      state.lateral_mm_[2 * point], state.lateral_mm_[2 * point + 1],
      state.demand_mm_[state.num_slots_ + point] + state.PointExcessMm(point));
  return (u - asked).cwiseAbs().maxCoeff();
}

}  // namespace acus::tissue
