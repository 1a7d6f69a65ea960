// The Pareto front of settings: none other is both cheaper and more accurate.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace acus::tuning {

/// Cost and error of a setting. Less is better for both; units are the caller's.
struct CostAndError {
  double cost = 0.0;
  double error = 0.0;
};

/// Indices of the settings that no other one dominates: none has at most the cost and at most the
/// error and less of one of them. In order of cost. Of settings with the same cost and error only
/// the first is included. NaN in either stands for not measured: such settings are omitted; an
/// infinite error is only on the front if nothing is cheaper.
std::vector<std::size_t> ParetoFront(std::span<const CostAndError> settings);

}  // namespace acus::tuning
