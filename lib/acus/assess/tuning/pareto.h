// Which settings are worth their price: none other is both cheaper and more accurate.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace acus::tuning {

/// A setting as the front sees it. Less is better for both; units are the caller's.
struct CostAndError {
  double cost = 0.0;
  double error = 0.0;
};

/// Indices of the settings that no other one beats: none has at most the cost and at most the error
/// and less of one of them. In order of cost. Of settings with the same cost and error the first
/// stands for all. What is NaN in either was not measured and is left out; an error of infinity is
/// only on the front if nothing is cheaper.
std::vector<std::size_t> ParetoFront(std::span<const CostAndError> settings);

}  // namespace acus::tuning
