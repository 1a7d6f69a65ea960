#include "acus/imaging/volume_rendering/transfer_function.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "acus/base/core/error.h"

namespace acus::volume_rendering {
namespace {

constexpr std::array<std::string_view, 4> kNames = {"skin", "bone", "soft_tissue", "vessels"};

void CheckNodes(std::span<const OpacityNode> nodes) {
  ACUS_REQUIRE(nodes.size() >= 2, "transfer function: ", nodes.size(),
               " nodes; at least two are needed");
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    ACUS_REQUIRE(std::isfinite(nodes[n].hu) && nodes[n].colour.allFinite(),
                 "transfer function: node ", n, " is not finite");
    ACUS_REQUIRE(nodes[n].extinction_per_mm >= 0.0 && nodes[n].extinction_per_mm <= 100.0,
                 "transfer function: node ", n, " has an extinction of ",
                 nodes[n].extinction_per_mm, " per mm; allowed is 0 to 100");
    ACUS_REQUIRE(n == 0 || nodes[n].hu > nodes[n - 1].hu, "transfer function: node ", n, " at ",
                 nodes[n].hu, " HU does not lie above the one before it");
  }
}

/// Where a value lies in the table.
int EntryOf(float hu) noexcept {
  // NaN becomes the lowest value: std::max returns its first argument then.
  const float place = std::max(0.0F, hu - TransferFunction::kLowestHu);
  return static_cast<int>(std::min(place, static_cast<float>(TransferFunction::kCount - 1)));
}

}  // namespace

std::span<const std::string_view> TransferPresetNames() {
  return kNames;
}

std::vector<OpacityNode> TransferPreset(std::string_view name) {
  if (name == "skin") {
    return {{-420, 0.0, {0.86F, 0.66F, 0.54F}},
            {-250, 2.5, {0.93F, 0.76F, 0.65F}},
            {-120, 2.5, {0.93F, 0.76F, 0.65F}},
            {0, 2.5, {0.80F, 0.48F, 0.40F}}};
  }
  if (name == "bone") {
    return {{170, 0.0, {0.85F, 0.72F, 0.55F}},
            {280, 0.35, {0.92F, 0.84F, 0.70F}},
            {600, 1.6, {0.97F, 0.94F, 0.86F}},
            {1500, 2.5, {1.0F, 1.0F, 0.97F}}};
  }
  if (name == "soft_tissue") {
    return {{-30, 0.0, {0.80F, 0.55F, 0.35F}},   {10, 0.006, {0.80F, 0.42F, 0.32F}},
            {45, 0.030, {0.72F, 0.25F, 0.20F}},  {80, 0.060, {0.75F, 0.22F, 0.18F}},
            {140, 0.060, {0.85F, 0.30F, 0.22F}}, {220, 0.0, {0.85F, 0.30F, 0.22F}}};
  }
  if (name == "vessels") {
    return {{130, 0.0, {0.80F, 0.12F, 0.12F}},
            {170, 0.5, {0.86F, 0.14F, 0.12F}},
            {260, 1.2, {0.92F, 0.22F, 0.16F}},
            {420, 1.6, {0.97F, 0.80F, 0.66F}},
            {1500, 2.5, {1.0F, 1.0F, 0.97F}}};
  }
  std::string known;
  for (const std::string_view one : kNames) known += (known.empty() ? "" : ", ") + std::string(one);
  throw InputError(Message("there is no transfer function \"", name, "\"; allowed are ", known));
}

TransferFunction::TransferFunction(std::span<const VolumeLayer> layers) {
  for (const VolumeLayer& layer : layers) {
    const std::vector<OpacityNode> nodes = TransferPreset(layer.preset);
    ACUS_REQUIRE(layer.opacity >= 0.0 && layer.opacity <= 1.0, "volume layer \"", layer.preset,
                 "\" has an opacity of ", layer.opacity, "; allowed is 0 to 1");
    if (layer.opacity > 0.0) Add(nodes, layer.opacity);
  }
  Integrate();
}

TransferFunction::TransferFunction(std::span<const OpacityNode> nodes) {
  CheckNodes(nodes);
  Add(nodes, 1.0);
  Integrate();
}

void TransferFunction::Add(std::span<const OpacityNode> nodes, double opacity) {
  if (value_.empty()) value_.assign(kCount, Emission::Zero());
  for (int n = 0; n < kCount; ++n) {
    const double hu = static_cast<double>(kLowestHu) + n;
    const auto after = std::ranges::upper_bound(nodes, hu, {}, &OpacityNode::hu);
    const OpacityNode& high = after == nodes.end() ? nodes.back() : *after;
    const OpacityNode& low = after == nodes.begin() ? high : *(after - 1);
    const double span = high.hu - low.hu;
    const double share = span > 0.0 ? (hu - low.hu) / span : 0.0;
    const auto extinction =
        static_cast<float>(opacity * (low.extinction_per_mm +
                                      share * (high.extinction_per_mm - low.extinction_per_mm)));
    const Eigen::Array3f colour =
        low.colour + static_cast<float>(share) * (high.colour - low.colour);
    Emission& value = value_[static_cast<std::size_t>(n)];
    value.head<3>() += extinction * colour;
    value[3] += extinction;
  }
}

void TransferFunction::Integrate() {
  if (value_.empty()) return;
  integral_.assign(kCount, Emission::Zero());
  for (std::size_t n = 1; n < value_.size(); ++n) {
    integral_[n] = integral_[n - 1] + 0.5F * (value_[n - 1] + value_[n]);
  }
  if (!(integral_.back()[3] > 0.0F)) integral_.clear();
}

TransferFunction::Emission TransferFunction::Between(float from_hu, float to_hu) const noexcept {
  const int from = EntryOf(from_hu);
  const int to = EntryOf(to_hu);
  if (from == to) return value_[static_cast<std::size_t>(from)];
  const Emission sum =
      integral_[static_cast<std::size_t>(to)] - integral_[static_cast<std::size_t>(from)];
  return sum / static_cast<float>(to - from);
}

bool TransferFunction::Shows(float low_hu, float high_hu) const noexcept {
  if (integral_.empty()) return false;
  const auto low = static_cast<std::size_t>(EntryOf(low_hu));
  const auto high = static_cast<std::size_t>(EntryOf(high_hu));
  return integral_[high][3] > integral_[low][3] || value_[low][3] > 0.0F || value_[high][3] > 0.0F;
}

}  // namespace acus::volume_rendering
