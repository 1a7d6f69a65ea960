#include "acus/physics/mechanics/sparse/back_substitution.h"

#include <algorithm>

#include "acus/physics/mechanics/sparse/blas.h"

namespace acus::mechanics {

BackSubstitution::BackSubstitution(const CondensedFactor& factor, std::span<const int> wanted)
    : factor_(factor),
      groups_(factor.supernodes()),
      num_condensed_(static_cast<int>(factor.ComplianceMmPerN().rows())),
      is_needed_(static_cast<std::size_t>(groups_.count), 0) {
  const std::span<const long> order = factor.order();
  const long num_rows = static_cast<long>(order.size());
  std::vector<long> group_of(order.size());
  for (int s = 0; s < groups_.count; ++s) {
    for (long j = groups_.first_column[s]; j < groups_.first_column[s + 1]; ++j) group_of[j] = s;
  }
  std::vector<long> rank(order.size());
  for (long k = 0; k < num_rows; ++k) rank[order[k]] = k;

  is_needed_.back() = 1;
  for (const int node : wanted) is_needed_[group_of[rank[3L * node]]] = 1;
  for (const int node : wanted) is_needed_[group_of[rank[3L * node + 2]]] = 1;
  for (const int node : wanted) is_needed_[group_of[rank[3L * node + 1]]] = 1;
  for (int s = 0; s + 1 < groups_.count; ++s) {
    const long columns = groups_.first_column[s + 1] - groups_.first_column[s];
    const long below = groups_.first_row[s] + columns;
    // The first row below is the parent in the elimination tree; all others are its ancestors.
    if (is_needed_[s] && below < groups_.first_row[s + 1]) {
      is_needed_[group_of[groups_.rows[below]]] = 1;
    }
  }
  place_.assign(order.size(), -1);
  long next = 0;
  for (long k = 0; k < num_rows; ++k) {
    if (is_needed_[group_of[k]]) place_[k] = next++;
  }
  for (const int node : wanted) {
    for (int axis = 0; axis < 3; ++axis) wanted_.push_back(place_[rank[3L * node + axis]]);
  }
  solution_.resize(0);
}

void BackSubstitution::SolveGroup(int group, int count) {
  const long first = groups_.first_column[group];
  const long last_interior = static_cast<long>(place_.size()) - num_condensed_;
  // Columns of R are solved already, also where they share a group with others.
  const int columns =
      static_cast<int>(std::min(groups_.first_column[group + 1], last_interior) - first);
  if (columns <= 0) return;
  const long* rows = groups_.rows + groups_.first_row[group];
  const int stride = static_cast<int>(groups_.first_row[group + 1] - groups_.first_row[group]);
  const int num_below = stride - columns;
  const double* values = groups_.values + groups_.first_value[group];
  double* here = solution_.data() + place_[first] * count;
  const double one = 1.0, minus = -1.0, zero = 0.0;
  if (num_below == 0) {
    std::fill_n(here, static_cast<long>(columns) * count, 0.0);
    return;
  }
  gathered_.resize(static_cast<std::size_t>(num_below) * count);
  for (int k = 0; k < num_below; ++k) {
    std::copy_n(solution_.data() + place_[rows[columns + k]] * count, count,
                gathered_.data() + static_cast<long>(k) * count);
  }
  dgemm_("N", "N", &count, &columns, &num_below, &minus, gathered_.data(), &count, values + columns,
         &stride, &zero, here, &count);
  dtrsm_("R", "L", "N", "N", &count, &columns, &one, values, &stride, here, &count);
}

void BackSubstitution::Columns(int first, int count, float* out) {
  const long num_places = *std::ranges::max_element(place_) + 1;
  solution_.resize(static_cast<std::size_t>(num_places * count));
  const auto compliance = factor_.ComplianceMmPerN();
  double* condensed = solution_.data() + (num_places - num_condensed_) * count;
  for (int j = 0; j < count; ++j) {
    const double* column = compliance.col(first + j).data();
    for (int i = 0; i < num_condensed_; ++i)
      condensed[static_cast<long>(i) * count + j] = column[i];
  }
  for (int s = groups_.count - 1; s >= 0; --s) {
    if (is_needed_[s]) SolveGroup(s, count);
  }
  for (std::size_t i = 0; i < wanted_.size(); ++i) {
    const double* row = solution_.data() + wanted_[i] * count;
    for (int j = 0; j < count; ++j) {
      out[static_cast<std::size_t>(j) * wanted_.size() + i] = static_cast<float>(row[j]);
    }
  }
}

}  // namespace acus::mechanics
