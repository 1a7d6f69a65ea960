#include "acus/patient/segmentation/imported_vertebrae.h"

#include <map>

#include "acus/patient/segmentation/voxels/mask.h"

namespace acus::segmentation {
namespace {

constexpr double kLeastCoreVoxels = 20;  ///< Of a body that is used.
constexpr double kStrayShare = 0.05;     ///< Of its heights; labels have stray voxels.
constexpr int kBesideSteps = 4;          ///< A disc that was found so near to a gap is that gap's.
constexpr double kThickestShare = 0.5;  ///< Of the greatest depth: the body, without its processes.

/// The steps along the canal's line between which the body of a vertebra lies.
struct BodyExtent {
  int number, low, high;
};

/// Calls visit(at, i, j, k) for the voxels of vertebrae.
template <typename Visit>
void ForVertebrae(const volume::LabelMap& map, const Visit& visit) {
  const volume::Geometry& g = map.geometry;
  for (int k = 0; k < g.size[2]; ++k) {
    for (int j = 0; j < g.size[1]; ++j) {
      for (int i = 0; i < g.size[0]; ++i) {
        const volume::Label label = map.At(i, j, k);
        if (label != 0) visit(label, g.ct_from_index() * Eigen::Vector3d(i, j, k));
      }
    }
  }
}

/// From the feet to the head.
std::vector<BodyExtent> ExtentsOf(const volume::LabelMap& imported, const CanalLine& line) {
  const std::vector<DiscPlane> none;
  const SpineFrame frame(line, none);
  const int last = static_cast<int>(line.points_mm.size()) - 1;
  std::map<int, std::vector<int>> steps;
  ForVertebrae(imported, [&](volume::Label label, const Eigen::Vector3d& p) {
    const SpinePlace place = frame.PlaceOf(p);
    const auto step = static_cast<int>(place.step);
    if (BodyCore::Has(place) && step > 0 && step < last) steps[label - 1].push_back(step);
  });
  std::vector<BodyExtent> extents;
  for (auto& [number, all] : steps) {
    if (static_cast<double>(all.size()) < kLeastCoreVoxels) continue;
    std::ranges::sort(all);
    const auto at = [&](double share) {
      return all[static_cast<std::size_t>(share * static_cast<double>(all.size() - 1))];
    };
    extents.push_back({number, at(kStrayShare), at(1.0 - kStrayShare)});
  }
  std::ranges::sort(extents, {}, &BodyExtent::low);
  return extents;
}

DiscPlane PlaneAt(const CanalLine& line, int step) {
  const auto s = static_cast<std::size_t>(step);
  return {
      .point_mm = line.points_mm[s], .normal = line.tangent[s], .contrast_hu = 0.0, .step = step};
}

}  // namespace

volume::LabelMap VertebraeIn(const ImportedLabels& import) {
  std::map<std::int32_t, volume::Label> label_of;
  for (const auto& [value, structure] : import.structures) {
    std::string name = structure.structure.name;
    if (name == "sacrum") name = "S1";
    if (const auto underscore = name.find('_'); underscore != std::string::npos) {
      if (name.starts_with("vertebra")) name = name.substr(underscore + 1);
    }
    if (const auto number = NumberOfVertebra(name)) {
      label_of[value] = static_cast<volume::Label>(1 + *number);
    }
  }
  volume::LabelMap out(import.values.geometry);
  for (std::size_t n = 0; n < out.voxels.size(); ++n) {
    const auto found = label_of.find(import.values.voxels[n]);
    if (found != label_of.end()) out.voxels[n] = found->second;
  }
  return out;
}

std::vector<DiscPlane> DiscsBetweenImported(const volume::LabelMap& imported, const CanalLine& line,
                                            std::vector<DiscPlane> found) {
  const std::vector<BodyExtent> extents = ExtentsOf(imported, line);
  if (extents.empty()) return found;
  std::vector<DiscPlane> discs;
  const auto in_gap = [&](int low, int high) {
    for (const DiscPlane& disc : found) {
      if (disc.step >= low - kBesideSteps && disc.step <= high + kBesideSteps) return disc;
    }
    return PlaneAt(line, (low + high) / 2);
  };
  for (const DiscPlane& disc : found) {
    if (disc.step <= extents.front().low + kBesideSteps) discs.push_back(disc);
  }
  for (std::size_t n = 0; n + 1 < extents.size(); ++n) {
    // What is missing between two that are named is found in the CT.
    const bool adjacent = extents[n].number == extents[n + 1].number + 1;
    if (adjacent) discs.push_back(in_gap(extents[n].high, extents[n + 1].low));
    for (const DiscPlane& disc : found) {
      if (!adjacent && disc.step >= extents[n].high - kBesideSteps &&
          disc.step <= extents[n + 1].low + kBesideSteps) {
        discs.push_back(disc);
      }
    }
  }
  for (const DiscPlane& disc : found) {
    if (disc.step >= extents.back().high - kBesideSteps) discs.push_back(disc);
  }
  return discs;
}

void AddKnownNames(const volume::LabelMap& imported, const SpineFrame& frame,
                   std::vector<VertebraEvidence>& evidence) {
  const std::size_t count = evidence.size();
  std::map<int, std::vector<std::size_t>> votes;  // By number, then by place from the feet.
  ForVertebrae(imported, [&](volume::Label label, const Eigen::Vector3d& p) {
    if (!BodyCore::Has(frame.PlaceOf(p))) return;
    const int from_feet = frame.Between(p);
    if (from_feet < 0) return;
    auto& of = votes[label - 1];
    of.resize(count, 0);
    ++of[static_cast<std::size_t>(from_feet)];
  });
  for (const auto& [number, of] : votes) {
    const auto most = std::ranges::max_element(of);
    if (static_cast<double>(*most) < kLeastCoreVoxels) continue;
    evidence[count - 1 - static_cast<std::size_t>(most - of.begin())].known = number;
  }
}

Vertebrae VertebraeOfImport(const volume::LabelMap& imported) {
  Vertebrae out;
  out.labels = volume::LabelMap(imported.geometry);
  out.named_from = NamedFrom::kImport;
  const double ml = imported.geometry.voxel_volume_mm3() / 1000.0;
  for (int number = 0; number <= 24; ++number) {
    const Mask mask = MaskOf(imported, static_cast<volume::Label>(number + 1));
    if (Count(mask) == 0) continue;
    Mask outside = mask;
    for (auto& voxel : outside.voxels) voxel = voxel == 0 ? 1 : 0;
    const auto depth = DistanceMm(outside, 1);
    const float least = static_cast<float>(kThickestShare) * std::ranges::max(depth.voxels);
    Vertebra vertebra{.name = VertebraByNumber(number), .is_whole = true};
    double inner = 0.0;
    const auto label = static_cast<volume::Label>(out.list.size() + 1);
    ForVertebrae(imported, [&](volume::Label here, const Eigen::Vector3d& p) {
      if (here != number + 1) return;
      const Eigen::Array3i v = (imported.geometry.index_from_ct() * p).array().round().cast<int>();
      out.labels.At(v[0], v[1], v[2]) = label;
      vertebra.volume_ml += ml;
      if (depth.At(v[0], v[1], v[2]) < least) return;
      vertebra.centre_mm += p;
      inner += 1.0;
    });
    vertebra.centre_mm /= inner;
    out.labels.names[label] = vertebra.name;
    out.list.push_back(vertebra);
  }
  return out;
}

}  // namespace acus::segmentation
