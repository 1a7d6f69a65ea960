#include "acus/data/volume/labels_of_ct.h"

#include <array>
#include <cmath>
#include <string_view>

#include "acus/base/core/text_table.h"

namespace acus::volume {
namespace {

constexpr int kLeastBoneHu = 60;
constexpr int kMostGasHu = -200;
constexpr std::size_t kLeastVoxels = 1000;  ///< Fewer are noise, and partial volume.

struct Count {
  std::size_t voxels = 0;
  std::size_t fit = 0;
};

struct JudgedTissue {
  std::string_view name;
  bool is_bone;
};
constexpr std::array kJudged = {JudgedTissue{"bone", true}, JudgedTissue{"lung", false},
                                JudgedTissue{"gas", false}};

/// Calls `count(label, hu)` for each labelled voxel inside the CT.
template <typename Action>
void ForEachLabelled(const CtVolume& ct, const LabelMap& labels, const Action& count) {
  const Eigen::Affine3d index_from_index =
      ct.geometry.index_from_ct() * labels.geometry.ct_from_index();
  const Eigen::Array3i size = labels.geometry.size;
  for (int k = 0; k < size[2]; ++k) {
    for (int j = 0; j < size[1]; ++j) {
      for (int i = 0; i < size[0]; ++i) {
        const Label label = labels.At(i, j, k);
        if (label == 0) continue;
        const Eigen::Array3i at =
            (index_from_index * Eigen::Vector3d(i, j, k)).array().round().cast<int>();
        if ((at < 0).any() || (at >= ct.geometry.size).any()) continue;
        count(label, ct.At(at[0], at[1], at[2]));
      }
    }
  }
}

}  // namespace

std::optional<std::string> WhyLabelsAreOfAnother(const CtVolume& ct, const LabelMap& labels) {
  std::array<const JudgedTissue*, 256> judged{};
  for (const auto& [label, name] : labels.names) {
    for (const JudgedTissue& tissue : kJudged) {
      if (name == tissue.name) judged[label] = &tissue;
    }
  }
  std::array<Count, kJudged.size()> counts{};
  ForEachLabelled(ct, labels, [&](Label label, int hu) {
    const JudgedTissue* tissue = judged[label];
    if (tissue == nullptr) return;
    Count& count = counts[static_cast<std::size_t>(tissue - kJudged.data())];
    ++count.voxels;
    count.fit += (tissue->is_bone ? hu >= kLeastBoneHu : hu <= kMostGasHu) ? 1 : 0;
  });
  for (std::size_t n = 0; n < counts.size(); ++n) {
    const auto [voxels, fit] = counts[n];
    const double share =
        static_cast<double>(fit) / static_cast<double>(std::max<std::size_t>(1, voxels));
    if (voxels < kLeastVoxels || share >= kLeastShare) continue;
    return Message("only ", FixedText(100.0 * share, 0), " % of its ", kJudged[n].name, " has ",
                   kJudged[n].is_bone ? Message(kLeastBoneHu, " HU or more")
                                      : Message(kMostGasHu, " HU or less"),
                   " in the CT (of a patient's own labels at least 80 %)");
  }
  return std::nullopt;
}

}  // namespace acus::volume
