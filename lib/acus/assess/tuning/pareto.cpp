#include "acus/assess/tuning/pareto.h"

#include <algorithm>
#include <cmath>

namespace acus::tuning {

std::vector<std::size_t> ParetoFront(std::span<const CostAndError> settings) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < settings.size(); ++i) {
    if (!std::isnan(settings[i].cost) && !std::isnan(settings[i].error)) order.push_back(i);
  }
  std::ranges::stable_sort(order, [&](std::size_t a, std::size_t b) {
    if (settings[a].cost != settings[b].cost) return settings[a].cost < settings[b].cost;
    return settings[a].error < settings[b].error;
  });
  std::vector<std::size_t> front;
  for (const std::size_t i : order) {
    // All before it are as cheap or cheaper: it must be more accurate than each of them.
    if (front.empty() || settings[i].error < settings[front.back()].error) front.push_back(i);
  }
  return front;
}

}  // namespace acus::tuning
