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

std::array<const JudgedTissue*, 256> JudgedTissues(const LabelMap& labels) {
  std::array<const JudgedTissue*, 256> judged{};
  for (const auto& [label, name] : labels.names) {
    for (const JudgedTissue& tissue : kJudged) {
      if (name == tissue.name) judged[label] = &tissue;
    }
  }
  return judged;
}

/// Pairs of voxels beside each other in a slice, of which one is bone: those whose bone has more HU
/// than the other voxel fit. Pairs in one voxel of the CT do not count.
Count EdgesOfBone(const CtVolume& ct, const LabelMap& labels,
                  const std::array<const JudgedTissue*, 256>& judged) {
  const Eigen::Affine3d index_from_index =
      ct.geometry.index_from_ct() * labels.geometry.ct_from_index();
  const Eigen::Array3i size = labels.geometry.size;
  const auto is_bone = [&](int i, int j, int k) {
    const JudgedTissue* tissue = judged[labels.At(i, j, k)];
    return tissue != nullptr && tissue->is_bone;
  };
  const auto in_ct = [&](int i, int j, int k) -> Eigen::Array3i {
    return (index_from_index * Eigen::Vector3d(i, j, k)).array().round().cast<int>();
  };
  const auto contains = [&](const Eigen::Array3i& at) {
    return (at >= 0).all() && (at < ct.geometry.size).all();
  };
  Count edges;
  const auto judge = [&](bool first_is_bone, const Eigen::Array3i& first,
                         const Eigen::Array3i& second) {
    if (!contains(first) || !contains(second) || (first == second).all()) return;
    const int fall = ct.At(first[0], first[1], first[2]) - ct.At(second[0], second[1], second[2]);
    ++edges.voxels;
    edges.fit += (first_is_bone ? fall > 0 : fall < 0) ? 1 : 0;
  };
  for (int k = 0; k < size[2]; ++k) {
    for (int j = 0; j < size[1]; ++j) {
      for (int i = 0; i < size[0]; ++i) {
        const bool bone = is_bone(i, j, k);
        if (i + 1 < size[0] && bone != is_bone(i + 1, j, k)) {
          judge(bone, in_ct(i, j, k), in_ct(i + 1, j, k));
        }
        if (j + 1 < size[1] && bone != is_bone(i, j + 1, k)) {
          judge(bone, in_ct(i, j, k), in_ct(i, j + 1, k));
        }
      }
    }
  }
  return edges;
}

}  // namespace

std::optional<std::string> WhyLabelsAreOfAnother(const CtVolume& ct, const LabelMap& labels) {
  const auto judged = JudgedTissues(labels);
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

std::optional<std::string> DoubtAboutLabels(const CtVolume& ct, const LabelMap& labels) {
  const Count edges = EdgesOfBone(ct, labels, JudgedTissues(labels));
  const double share =
      static_cast<double>(edges.fit) / static_cast<double>(std::max<std::size_t>(1, edges.voxels));
  if (edges.voxels < kLeastVoxels || share >= kLeastEdgeShare) return std::nullopt;
  return Message(
      "only at ", FixedText(100.0 * share, 0),
      " % of the edges of its bone does the CT have an edge of bone (labels drawn to the "
      "voxel: 93 to 99 %). It may be of another scan or patient, shifted, or drawn a "
      "voxel too wide or too narrow: membranes are felt where the labels have them");
}

}  // namespace acus::volume
