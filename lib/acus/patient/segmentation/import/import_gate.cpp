#include "acus/patient/segmentation/import/import_gate.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "acus/base/core/words.h"
#include "acus/data/volume/labels.h"

namespace acus::segmentation {
namespace {

constexpr int kAirHu = -300;               // Denser is tissue, as for the body.
constexpr double kSideMarginMm = 15.0;     // A centroid nearer to the midline is on no side.
constexpr double kHeightMarginMm = 80.0;   // Of typical heights, from which on the order counts.
constexpr double kLeastMl = 2.0;           // Smaller pieces have no reliable centroid or HU.
constexpr double kMostOutsideBody = 0.10;  // Shares of voxels.
constexpr double kUnusualOutsideBody = 0.01;
constexpr double kMostWrongHu = 0.25;  // In one structure.
constexpr double kUnusualWrongHu = 0.12;
constexpr double kMostWrongHuOfAll = 0.06;  // In all together, where misplaced edges add up.
constexpr double kUnusualWrongHuOfAll = 0.015;
constexpr double kJudgedMl = 50.0;    // Smaller structures alone do not refuse a map.
constexpr int kDenseBoneHu = 100;     // Of cortex and of most marrow.
constexpr double kLeastDense = 0.25;  // Shares of the bones' voxels.
constexpr double kUsualDense = 0.45;
constexpr std::size_t kMostFindings = 8;

/// All voxels of one structure.
struct PartOfImport {
  NamedStructure what;
  std::string name;  ///< In the import.
  double count = 0.0;
  double outside_body = 0.0;
  double wrong_hu = 0.0;
  double air = 0.0;
  double dense = 0.0;
  Eigen::Vector3d sum_mm = Eigen::Vector3d::Zero();
  bool touches_border = false;
  double ml = 0.0;
  Eigen::Vector3d centroid_mm() const { return sum_mm / count; }
};

using Parts = std::vector<PartOfImport>;

/// Parts by structure and side, in the order of their values.
Parts PartsOf(const ImportedLabels& import, const volume::CtVolume& ct,
              const volume::LabelMap& found) {
  Parts parts;
  std::map<std::pair<std::string, Side>, std::size_t> index;
  std::map<std::int32_t, std::size_t> part_of_value;
  for (const auto& [value, what] : import.structures) {
    const auto [place, is_new] = index.try_emplace({what.structure.name, what.side}, parts.size());
    if (is_new) parts.push_back({.what = what, .name = import.mapping.name.at(value)});
    part_of_value[value] = place->second;
  }
  std::vector<std::optional<HuRange>> range;
  for (const PartOfImport& part : parts) {
    range.push_back(import.names.HuOf(part.what.structure.tissue));
  }
  const volume::Geometry& grid = ct.geometry;
  const Eigen::Affine3d ct_from_index = grid.ct_from_index();
  std::int32_t last_value = 0;
  std::size_t last = 0;
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        const std::size_t n = grid.Index(i, j, k);
        const std::int32_t value = import.values.voxels[n];
        if (value == 0) continue;
        if (value != last_value) {
          const auto place = part_of_value.find(value);
          if (place == part_of_value.end()) continue;
          last_value = value;
          last = place->second;
        }
        PartOfImport& part = parts[last];
        const int hu = ct.voxels[n];
        part.count += 1.0;
        part.sum_mm += ct_from_index * Eigen::Vector3d(i, j, k);
        part.outside_body += found.voxels[n] == 0 ? 1.0 : 0.0;
        part.air += hu < kAirHu ? 1.0 : 0.0;
        part.dense += hu > kDenseBoneHu ? 1.0 : 0.0;
        if (range[last]) part.wrong_hu += hu < range[last]->least || hu > range[last]->most;
        part.touches_border |= i == 0 || j == 0 || k == 0 || i + 1 == grid.size[0] ||
                               j + 1 == grid.size[1] || k + 1 == grid.size[2];
      }
    }
  }
  for (PartOfImport& part : parts) part.ml = part.count * grid.voxel_volume_mm3() / 1000.0;
  std::erase_if(parts, [](const PartOfImport& part) { return part.count == 0.0; });
  return parts;
}

std::string Ml(double ml) {
  return Message(ml < 10.0 ? std::round(ml * 10.0) / 10.0 : std::round(ml), " ml");
}

std::string Percent(double share) {
  return Message(std::round(1000.0 * share) / 10.0, " %");
}

void CheckVolumes(const Parts& parts, ImportFindings& findings) {
  for (const PartOfImport& part : parts) {
    const Structure& what = part.what.structure;
    const double sides = what.is_paired && part.what.side == Side::kNone ? 2.0 : 1.0;
    if (what.most_ml > 0.0 && part.ml > sides * what.most_ml) {
      findings.impossible.push_back(Message("'", part.name, "' has ", Ml(part.ml), "; at most ",
                                            Ml(sides * what.most_ml), " are possible"));
    } else if (part.ml < what.least_ml && !part.touches_border) {
      findings.unusual.push_back(Message("'", part.name, "' has only ", Ml(part.ml),
                                         "; expected are at least ", Ml(what.least_ml),
                                         ", unless the border of the CT cuts it"));
    }
  }
}

/// x of the plane between left and right: of structures in the midline, otherwise of the body.
double MidlineMm(const Parts& parts, const volume::LabelMap& found) {
  double sum = 0.0;
  double count = 0.0;
  for (const PartOfImport& part : parts) {
    if (!part.what.structure.is_midline) continue;
    sum += part.sum_mm[0];
    count += part.count;
  }
  if (count > 0.0) return sum / count;
  const volume::Geometry& grid = found.geometry;
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        if (found.At(i, j, k) == 0) continue;
        sum += (grid.ct_from_index() * Eigen::Vector3d(i, j, k))[0];
        count += 1.0;
      }
    }
  }
  return count > 0.0 ? sum / count : 0.0;
}

/// The parts whose half of the body is given, and whether each lies in the other one.
struct SideCheck {
  std::vector<std::string> right, wrong;
};

SideCheck CheckHalves(const Parts& parts, const volume::LabelMap& found) {
  SideCheck check;
  const double midline = MidlineMm(parts, found);
  for (const PartOfImport& part : parts) {
    const Structure& what = part.what.structure;
    const Side side = part.what.side != Side::kNone ? part.what.side : what.half;
    if (side == Side::kNone || part.ml < kLeastMl) continue;
    double from_middle = part.centroid_mm()[0] - midline;  // LPS: left is positive.
    for (const PartOfImport& other : parts) {
      const bool is_pair = other.what.structure.name == what.name &&
                           other.what.side != Side::kNone && other.what.side != part.what.side &&
                           part.what.side != Side::kNone;
      if (is_pair) from_middle = part.centroid_mm()[0] - other.centroid_mm()[0];
    }
    const double to_its_side = side == Side::kLeft ? from_middle : -from_middle;
    if (to_its_side > kSideMarginMm) check.right.push_back(part.name);
    if (to_its_side < -kSideMarginMm) check.wrong.push_back(part.name);
  }
  return check;
}

std::string SomeOf(const std::vector<std::string>& names) {
  const std::size_t count = std::min<std::size_t>(names.size(), 5);
  std::string text = Joined(std::span(names).first(count));
  if (names.size() > count) text += Message(" and ", names.size() - count, " more");
  return text;
}

void CheckSides(const Parts& parts, const volume::LabelMap& found, ImportFindings& findings) {
  const SideCheck check = CheckHalves(parts, found);
  if (check.wrong.empty()) return;
  if (check.right.empty()) {
    findings.impossible.push_back(
        Message("left and right are swapped: ", SomeOf(check.wrong),
                check.wrong.size() == 1 ? " lies" : " lie",
                " on the other side of the patient. The map was mirrored, or written without the "
                "CT's orientation"));
  } else {
    findings.impossible.push_back(
        Message(SomeOf(check.wrong), check.wrong.size() == 1 ? " lies" : " lie",
                " on the other side of the patient, but not ", SomeOf(check.right)));
  }
}

/// Pairs of structures that lie at each other's height.
void CheckHeights(const Parts& parts, ImportFindings& findings) {
  std::size_t num_right = 0;
  std::vector<std::string> wrong;
  for (const PartOfImport& high : parts) {
    for (const PartOfImport& low : parts) {
      const auto& above = high.what.structure.height_mm;
      const auto& below = low.what.structure.height_mm;
      if (!above || !below || *above <= *below + kHeightMarginMm) continue;
      if (high.ml < kLeastMl || low.ml < kLeastMl) continue;
      if (high.centroid_mm()[2] > low.centroid_mm()[2]) {
        ++num_right;
      } else {
        wrong.push_back(Message(high.name, " below ", low.name));
      }
    }
  }
  if (wrong.empty()) return;
  findings.impossible.push_back(num_right == 0
                                    ? Message("up and down are swapped: ", SomeOf(wrong))
                                    : Message("up and down do not fit: ", SomeOf(wrong)));
}

void CheckVertebrae(const Parts& parts, ImportFindings& findings) {
  std::vector<const PartOfImport*> vertebrae;
  for (const PartOfImport& part : parts) {
    if (part.what.structure.order > 0 && part.ml >= kLeastMl) vertebrae.push_back(&part);
  }
  std::ranges::sort(vertebrae, {}, [](const auto* part) { return part->what.structure.order; });
  std::vector<std::string> wrong;
  for (std::size_t n = 1; n < vertebrae.size(); ++n) {
    const double drop = vertebrae[n - 1]->centroid_mm()[2] - vertebrae[n]->centroid_mm()[2];
    if (drop < 0.0) {
      wrong.push_back(Message(vertebrae[n - 1]->name, " below ", vertebrae[n]->name));
    }
  }
  if (!wrong.empty()) {
    findings.impossible.push_back(Message("vertebrae are not in order: ", SomeOf(wrong)));
  }
}

void CheckBody(const Parts& parts, ImportFindings& findings) {
  double count = 0.0;
  double outside = 0.0;
  for (const PartOfImport& part : parts) {
    if (part.what.structure.tissue == 0) continue;  // A body may be drawn generously.
    count += part.count;
    outside += part.outside_body;
  }
  const double share = count > 0.0 ? outside / count : 0.0;
  if (share > kUnusualOutsideBody) {
    auto& list = share > kMostOutsideBody ? findings.impossible : findings.unusual;
    list.push_back(Message(Percent(share), " of its labels lie outside the body in the CT"));
  }
}

/// Structures whose HU the CT contradicts: air or fat in an organ, bone in a lung.
void CheckHu(const Parts& parts, const LabelNames& names, ImportFindings& findings) {
  for (const PartOfImport& part : parts) {
    const auto range = names.HuOf(part.what.structure.tissue);
    if (!range || part.ml < kLeastMl) continue;
    const double share = part.wrong_hu / part.count;
    if (share <= kUnusualWrongHu) continue;
    auto& list =
        share > kMostWrongHu && part.ml > kJudgedMl ? findings.impossible : findings.unusual;
    list.push_back(Message("'", part.name, "' has ", Percent(share), " of its voxels outside ",
                           range->least, " to ", range->most,
                           " HU (air: ", Percent(part.air / part.count), ")"));
  }
}

/// Edges that do not meet those of the CT: each of the two signs alone may have another cause (bone
/// that has lost its calcium, gas), both together are a map of another patient or place.
void CheckEdges(const Parts& parts, const LabelNames& names, ImportFindings& findings) {
  PartOfImport all, bones;
  for (const PartOfImport& part : parts) {
    const volume::Label tissue = part.what.structure.tissue;
    if (!names.HuOf(tissue)) continue;
    all.count += part.count;
    all.ml += part.ml;
    all.wrong_hu += part.wrong_hu;
    if (tissue != volume::LabelOf("bone")) continue;
    bones.count += part.count;
    bones.ml += part.ml;
    bones.dense += part.dense;
  }
  const double wrong = all.ml > kJudgedMl ? all.wrong_hu / all.count : 0.0;
  const double dense = bones.ml > kJudgedMl ? bones.dense / bones.count : 1.0;
  if (wrong <= kUnusualWrongHuOfAll && dense >= kUsualDense) return;
  const bool both = wrong > kUnusualWrongHuOfAll && dense < kUsualDense;
  auto& list = both || wrong > kMostWrongHuOfAll || dense < kLeastDense ? findings.impossible
                                                                        : findings.unusual;
  std::string text = Message(Percent(wrong),
                             " of its voxels have HU that their tissues do not have (usual: below ",
                             Percent(kUnusualWrongHuOfAll), ")");
  if (bones.ml > kJudgedMl) {
    text += Message(", and ", Percent(dense), " of its bone is above ", kDenseBoneHu,
                    " HU (usual: ", Percent(kUsualDense), " or more)");
  }
  list.push_back(text + ": another patient, or a map that is shifted");
}

/// The table and the file's own names must mean the same.
void CheckNames(const ImportedLabels& import, ImportFindings& findings) {
  for (const auto& [value, tissue] : import.mapping.tissue) {
    const auto own = import.own_names.find(value);
    if (own == import.own_names.end() || !import.structures.contains(value)) continue;
    const auto by_file = import.names.Find(own->second);
    const auto by_table = import.names.Find({.text = import.mapping.name.at(value), .codes = {}});
    if (!by_file || !by_table || by_file->structure.name == by_table->structure.name) continue;
    if (by_file->structure.tissue == tissue) continue;
    findings.impossible.push_back(Message("value ", value, " is '", own->second.text,
                                          "' for the file, but '", import.mapping.name.at(value),
                                          "' for the table"));
  }
}

std::string Listed(const std::vector<std::string>& findings) {
  std::string text;
  for (std::size_t n = 0; n < findings.size() && n < kMostFindings; ++n) {
    text += "\n  " + findings[n];
  }
  if (findings.size() > kMostFindings) {
    text += Message("\n  and ", findings.size() - kMostFindings, " more");
  }
  return text;
}

}  // namespace

ImportFindings CheckImport(const ImportedLabels& import, const volume::CtVolume& ct,
                           const volume::LabelMap& found) {
  ACUS_ASSERT(import.values.voxels.size() == ct.voxels.size());
  ACUS_ASSERT(found.voxels.size() == ct.voxels.size());
  ImportFindings findings;
  const Parts parts = PartsOf(import, ct, found);
  CheckNames(import, findings);
  CheckVolumes(parts, findings);
  CheckSides(parts, found, findings);
  CheckHeights(parts, findings);
  CheckVertebrae(parts, findings);
  CheckBody(parts, findings);
  CheckHu(parts, import.names, findings);
  CheckEdges(parts, import.names, findings);
  return findings;
}

void RequirePlausible(const ImportFindings& findings, const ImportedLabels& import,
                      bool accept_implausible, const RunContext& context) {
  const std::string file = import.file.string();
  if (!findings.unusual.empty()) {
    context.Warn(Message(file, ": please check in the previews:", Listed(findings.unusual)));
  }
  if (findings.impossible.empty()) return;
  const std::string text =
      Message(file, ": cannot be labels of the patient in the CT (values understood ",
              import.named_by, "):", Listed(findings.impossible));
  if (accept_implausible) {
    context.Warn(text + "\n  accepted");
    return;
  }
  throw InputError(text +
                   "\nAre the values those of another version or task (--mapping TABLE)? Is it the "
                   "map of this CT, in its orientation? --accept-implausible uses it as it is");
}

}  // namespace acus::segmentation
