#include "acus/imaging/volume_rendering/transfer_function.h"

#include <algorithm>
#include <cmath>

#include "acus/base/core/error.h"

namespace acus::volume_rendering {
namespace {

/// Where a value lies in the table.
int EntryOf(float hu) noexcept {
  // NaN becomes the lowest value: std::max returns its first argument then.
  const float place = std::max(0.0F, hu - TransferFunction::kLowestHu);
  return static_cast<int>(std::min(place, static_cast<float>(TransferFunction::kCount - 1)));
}

}  // namespace

TransferFunction::TransferFunction(std::span<const VolumeLayer> layers) {
  std::vector<TransferFile> files;
  for (const VolumeLayer& layer : layers) {
    files.push_back(ReadTransferFunction(FindTransferFunction(layer.preset, {})));
    ACUS_REQUIRE(layer.opacity >= 0.0 && layer.opacity <= 1.0, "volume layer \"", layer.preset,
                 "\" has an opacity of ", layer.opacity, "; allowed is 0 to 1");
    if (layer.opacity == 0.0) files.back().tissues.clear();
  }
  SetClasses(files);
  for (std::size_t n = 0; n < layers.size(); ++n) {
    if (!(layers[n].opacity > 0.0)) continue;
    std::vector<int> classes;
    for (const volume::Label label : files[n].tissues) classes.push_back(class_of_label_[label]);
    for (int c = 0; files[n].tissues.empty() && c < num_classes_; ++c) classes.push_back(c);
    for (const int c : classes) Add(files[n].nodes, layers[n].opacity, c);
  }
  Integrate();
}

TransferFunction::TransferFunction(const std::vector<OpacityNode>& nodes) {
  CheckNodes(nodes, "transfer function");
  Add(nodes, 1.0, 0);
  Integrate();
}

/// A class for each label that a file names.
void TransferFunction::SetClasses(std::span<const TransferFile> files) {
  for (const TransferFile& file : files) {
    for (const volume::Label label : file.tissues) {
      if (class_of_label_[label] != 0) continue;
      ACUS_REQUIRE(num_classes_ < TissueClasses::kMaxClasses, "volume layers hold in more than ",
                   TissueClasses::kMaxClasses - 1, " tissues");
      class_of_label_[label] = static_cast<std::uint8_t>(num_classes_++);
    }
  }
}

void TransferFunction::Add(std::span<const OpacityNode> nodes, double opacity, int tissue_class) {
  if (value_.empty())
    value_.assign(static_cast<std::size_t>(kCount * num_classes_), Emission::Zero());
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
    Emission& value = value_[static_cast<std::size_t>(tissue_class * kCount + n)];
    value.head<3>() += extinction * colour;
    value[3] += extinction;
  }
}

void TransferFunction::Integrate() {
  if (value_.empty()) return;
  integral_.assign(value_.size(), Emission::Zero());
  float most = 0.0F;
  for (std::size_t n = 1; n < value_.size(); ++n) {
    if (n % kCount == 0) continue;
    integral_[n] = integral_[n - 1] + 0.5F * (value_[n - 1] + value_[n]);
    most = std::max(most, integral_[n][3]);
  }
  if (!(most > 0.0F)) integral_.clear();
}

TransferFunction::Emission TransferFunction::Between(float from_hu, float to_hu,
                                                     int tissue_class) const noexcept {
  const auto first = static_cast<std::size_t>(tissue_class * kCount);
  const int from = EntryOf(from_hu);
  const int to = EntryOf(to_hu);
  if (from == to) return value_[first + static_cast<std::size_t>(from)];
  const Emission sum = integral_[first + static_cast<std::size_t>(to)] -
                       integral_[first + static_cast<std::size_t>(from)];
  return sum / static_cast<float>(to - from);
}

bool TransferFunction::Shows(float low_hu, float high_hu,
                             TissueClasses::Set classes) const noexcept {
  if (integral_.empty()) return false;
  for (int c = 0; c < num_classes_; ++c) {
    if ((classes >> static_cast<unsigned>(c) & 1U) == 0) continue;
    const auto low = static_cast<std::size_t>(c * kCount + EntryOf(low_hu));
    const auto high = static_cast<std::size_t>(c * kCount + EntryOf(high_hu));
    if (integral_[high][3] > integral_[low][3] || value_[low][3] > 0.0F || value_[high][3] > 0.0F) {
      return true;
    }
  }
  return false;
}

}  // namespace acus::volume_rendering
