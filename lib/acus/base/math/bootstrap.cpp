#include "acus/base/math/bootstrap.h"

#include <algorithm>

#include "acus/base/math/statistics.h"

namespace acus::math {

std::vector<double> Redrawn(std::span<const double> values, RandomStream& random) {
  std::vector<double> drawn(values.size());
  for (double& value : drawn) {
    const auto place =
        static_cast<std::size_t>(random.Uniform() * static_cast<double>(values.size()));
    value = values[std::min(place, values.size() - 1)];
  }
  return drawn;
}

Interval PercentileInterval(std::span<const double> statistics, double confidence) {
  const double tail = 0.5 * (1.0 - confidence);
  return {Quantile(statistics, tail), Quantile(statistics, 1.0 - tail)};
}

Interval BootstrapIntervalOfMean(std::span<const double> values, double confidence, int draws,
                                 std::uint64_t seed, std::string_view name) {
  RandomStream random(seed, name);
  std::vector<double> means(static_cast<std::size_t>(draws));
  for (double& mean : means) mean = Mean(Redrawn(values, random));
  return PercentileInterval(means, confidence);
}

}  // namespace acus::math
