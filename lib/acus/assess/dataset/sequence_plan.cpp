#include "acus/assess/dataset/sequence_plan.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>

#include "acus/base/core/random.h"

namespace acus::dataset {
namespace {

namespace fs = std::filesystem;

/// An integer below `count`.
std::size_t DrawBelow(std::size_t count, RandomStream& random) {
  const auto drawn = static_cast<std::size_t>(random.Uniform() * static_cast<double>(count));
  return std::min(drawn, count - 1);
}

fs::path DrawPreset(const std::vector<fs::path>& presets, RandomStream& random) {
  const double drawn = random.Uniform();  // Also without presets: later draws stay the same.
  if (presets.empty()) return {};
  const auto place = static_cast<std::size_t>(drawn * static_cast<double>(presets.size()));
  return presets[std::min(place, presets.size() - 1)];
}

std::optional<double> DrawValue(const std::optional<ValueRange>& range, RandomStream& random) {
  const double share = random.Uniform();
  if (!range) return std::nullopt;
  return range->low + share * (range->high - range->low);
}

/// Number of patients in each split.
std::array<std::size_t, kSplitNames.size()> SplitSizes(const DatasetConfig& config) {
  const auto patients = static_cast<double>(config.patients.size());
  std::array<std::size_t, kSplitNames.size()> size{};
  for (std::size_t n = 0; n < size.size(); ++n) {
    if (config.split_shares[n] > 0.0) size[n] = 1;
  }
  // The next patient goes to the split with the largest deficit.
  while (std::accumulate(size.begin(), size.end(), std::size_t{0}) < config.patients.size()) {
    const auto lacking = [&](std::size_t n) {
      return config.split_shares[n] * patients - static_cast<double>(size[n]);
    };
    std::size_t most = 0;
    for (std::size_t n = 1; n < size.size(); ++n) {
      if (lacking(n) > lacking(most) + 1e-9) most = n;
    }
    ++size[most];
  }
  return size;
}

}  // namespace

std::string SequencePlan::Name() const {
  char name[16];
  std::snprintf(name, sizeof name, "%05d", number);
  return name;
}

std::vector<std::size_t> SplitPatients(const DatasetConfig& config, std::uint64_t seed) {
  RandomStream random(seed, "splits of a data set");
  std::vector<std::size_t> order(config.patients.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  for (std::size_t left = order.size(); left > 1; --left) {
    std::swap(order[left - 1], order[DrawBelow(left, random)]);
  }
  const auto size = SplitSizes(config);
  std::vector<std::size_t> split(order.size());
  std::size_t at = 0;
  for (std::size_t n = 0; n < size.size(); ++n) {
    for (std::size_t k = 0; k < size[n]; ++k) split[order[at++]] = n;
  }
  return split;
}

SequencePlan DrawSequence(const DatasetConfig& config, std::uint64_t seed, int number) {
  RandomStream random(seed, "sequence of a data set", static_cast<std::uint64_t>(number));
  SequencePlan plan;
  plan.number = number;
  plan.patient = static_cast<std::size_t>(number) % config.patients.size();
  plan.scenario = DrawPreset(config.patients[plan.patient].scenarios, random);
  plan.probe = DrawPreset(config.probes, random);
  plan.needle = DrawPreset(config.needles, random);
  plan.display = DrawPreset(config.displays, random);
  plan.trainee = DrawPreset(config.trainees, random);
  plan.probe_change.gain_offset_db = DrawValue(config.gain_offset_db, random).value_or(0.0);
  plan.probe_change.depth_mm = DrawValue(config.depth_mm, random);
  plan.probe_change.frequency_mhz = DrawValue(config.frequency_mhz, random);
  plan.probe_change.dynamic_range_db = DrawValue(config.dynamic_range_db, random);
  plan.probe_change.image_width_px = config.image_width_px;
  plan.probe_change.image_height_px = config.image_height_px;
  plan.motion_seed = random.Next();
  plan.speckle_seed = random.Next() >> 32U;
  return plan;
}

}  // namespace acus::dataset
