#include "acus/patient/segmentation/spine/vertebrae.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <queue>

#include "acus/base/core/csv.h"
#include "acus/base/core/text_table.h"
#include "acus/base/core/words.h"
#include "acus/base/math/point_text.h"
#include "acus/data/volume/labels.h"
#include "acus/patient/segmentation/imported_vertebrae.h"
#include "acus/patient/segmentation/spine_frame.h"
#include "acus/patient/segmentation/spine_profile.h"
#include "acus/patient/segmentation/voxels/mask.h"

namespace acus::segmentation {
namespace {

constexpr double kLongestWayMm = 62.0;
constexpr double kFarthestAsideMm = 50.0;
constexpr double kLongestRibWayMm = 160.0;  ///< Ribs are followed so far, to see whether there are.
constexpr double kFarthestRibMm = 75.0;     ///< From the midline.
constexpr double kFarthestMm = 85.0;
constexpr double kCortexHu = 350.0;  ///< Ways through less dense bone count for more.
constexpr double kPorousCost = 2.5;  ///< At 0 HU, in addition to 1.
constexpr double kMarrowHalfWidthMm = 22.0;
constexpr double kMarrowFromMm = 6.0;
constexpr double kMarrowToMm = 42.0;
constexpr int kLeastMarrowInBodyHu = -60;

/// The voxels within reach of the canal.
Box BoxAround(const CanalLine& line, const volume::Geometry& g) {
  Eigen::Array3d low = Eigen::Array3d::Constant(1e9), high = Eigen::Array3d::Constant(-1e9);
  const auto index_from_ct = g.index_from_ct();
  for (const Eigen::Vector3d& p : line.points_mm) {
    const Eigen::Array3d index = (index_from_ct * p).array();
    low = low.min(index);
    high = high.max(index);
  }
  const Eigen::Array3d reach = kFarthestMm / g.spacing_mm;
  const Eigen::Array3d last = (g.size - 1).cast<double>();
  Box box;
  box.low = (low - reach).max(0.0).floor().cast<int>();
  box.high = (high + reach).min(last).ceil().cast<int>();
  return box;
}

/// Grows the bodies along bone: Dijkstra's shortest ways from all of them together.
class Growth {
 public:
  Growth(const volume::CtVolume& ct, const volume::LabelMap& tissues, const SpineFrame& frame,
         const Box& box)
      : ct_(ct), bone_(volume::LabelOf("bone")), tissues_(tissues), frame_(frame), box_(box) {
    number_ = volume::Grid<volume::Label>(ct.geometry);
    way_mm_.assign(ct.voxels.size(), 1e9F);
    reach_mm_.assign(256, {0.0, 0.0});
  }

  volume::Grid<volume::Label> Run() {
    Seed();
    while (!queue_.empty()) {  // Dense bone first, so that joints part what touches.
      const auto [way, at] = queue_.top();
      queue_.pop();
      if (way > way_mm_[at]) continue;
      Visit(at, way);
    }
    return std::move(number_);
  }

  /// How far the bone of each vertebra reaches to the left and right, by number.
  const std::vector<std::array<double, 2>>& reach_mm() const { return reach_mm_; }
  /// Distance of each voxel that was grown to from its body.
  const std::vector<float>& way_mm() const { return way_mm_; }

 private:
  using Entry = std::pair<float, std::size_t>;

  void Seed() {
    for (int k = box_.low[2]; k <= box_.high[2]; ++k) {
      for (int j = box_.low[1]; j <= box_.high[1]; ++j) {
        for (int i = box_.low[0]; i <= box_.high[0]; ++i) {
          if (tissues_.At(i, j, k) != bone_) continue;
          const Eigen::Vector3d p = ct_.geometry.ct_from_index() * Eigen::Vector3d(i, j, k);
          const SpinePlace place = frame_.PlaceOf(p);
          if (!BodyCore::Has(place)) continue;
          const int number = frame_.Between(p);
          if (number >= 0) Set(ct_.geometry.Index(i, j, k), 0.0F, number + 1);
        }
      }
    }
  }

  void Set(std::size_t at, float way, int number) {
    way_mm_[at] = way;
    number_.voxels[at] = static_cast<volume::Label>(number);
    queue_.emplace(way, at);
  }

  void Visit(std::size_t at, float way) {
    const volume::Geometry& g = ct_.geometry;
    const auto row = static_cast<std::size_t>(g.size[0]);
    const std::size_t slice = g.Index(0, 0, 1);
    const auto i = static_cast<int>(at % row);
    const auto j = static_cast<int>(at % slice / row);
    const auto k = static_cast<int>(at / slice);
    for (int dk = -1; dk <= 1; ++dk) {
      for (int dj = -1; dj <= 1; ++dj) {
        for (int di = -1; di <= 1; ++di) {
          const Eigen::Array3i to(i + di, j + dj, k + dk);
          if ((to < box_.low).any() || (to > box_.high).any()) continue;
          const std::size_t there = g.Index(to[0], to[1], to[2]);
          if (tissues_.voxels[there] != bone_) continue;
          const double length_mm =
              std::sqrt(std::pow(di * g.spacing_mm[0], 2) + std::pow(dj * g.spacing_mm[1], 2) +
                        std::pow(dk * g.spacing_mm[2], 2));
          const double sparse =
              std::clamp(1.0 - static_cast<double>(ct_.voxels[there]) / kCortexHu, 0.0, 1.0);
          const auto next = static_cast<float>(way + length_mm * (1.0 + kPorousCost * sparse));
          if (next >= way_mm_[there] || next > kLongestRibWayMm) continue;
          const double left_mm =
              frame_.PlaceOf(g.ct_from_index() * to.cast<double>().matrix()).left_mm;
          if (std::abs(left_mm) > kFarthestRibMm) continue;
          Set(there, next, number_.voxels[at]);
          double& reach = reach_mm_[number_.voxels[at]][left_mm > 0.0 ? 0 : 1];
          reach = std::max(reach, std::abs(left_mm));
        }
      }
    }
  }

  const volume::CtVolume& ct_;
  const volume::Label bone_;
  const volume::LabelMap& tissues_;
  const SpineFrame& frame_;
  const Box box_;
  volume::Grid<volume::Label> number_;
  std::vector<float> way_mm_;
  std::vector<std::array<double, 2>> reach_mm_;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue_;
};

/// In how many of 8 directions in the plane of `left` and `forward` bone lies within 30 mm.
int NumHidden(const volume::LabelMap& tissues, volume::Label bone, const Eigen::Vector3d& p,
              const Eigen::Vector3d& left, const Eigen::Vector3d& forward) {
  const volume::Geometry& g = tissues.geometry;
  const auto index_from_ct = g.index_from_ct();
  const double step_mm = g.spacing_mm.minCoeff();
  int hidden = 0;
  for (int n = 0; n < 8; ++n) {
    const double angle = M_PI * n / 4.0;
    const Eigen::Vector3d way = std::cos(angle) * left + std::sin(angle) * forward;
    for (double at = step_mm; at <= 30.0; at += step_mm) {
      const Eigen::Array3i v = (index_from_ct * (p + at * way)).array().round().cast<int>();
      if (!g.Contains(v[0], v[1], v[2])) break;
      if (tissues.At(v[0], v[1], v[2]) != bone) continue;
      ++hidden;
      break;
    }
  }
  return hidden;
}

/// The middle of each body: half-way between its discs, or 15 mm beyond the last one.
void Centre(const CanalLine& line, const SpineFrame& frame, const std::vector<DiscPlane>& discs,
            Vertebrae& out) {
  const auto in_front = [&](const Eigen::Vector3d& on_line) -> Eigen::Vector3d {
    const auto step = frame.PlaceOf(on_line).step;
    return line.points_mm[step] + 0.5 * (BodyCore::kFromMm + BodyCore::kToMm) * line.forward[step];
  };
  const std::size_t count = out.list.size();
  for (std::size_t n = 0; n < count; ++n) {
    const std::size_t from_feet = count - 1 - n;
    out.list[n].is_whole = from_feet > 0 && from_feet < discs.size();
    if (out.list[n].is_whole) {
      out.list[n].centre_mm =
          in_front(0.5 * (discs[from_feet - 1].point_mm + discs[from_feet].point_mm));
    } else {
      const DiscPlane& disc = from_feet == 0 ? discs.front() : discs.back();
      out.list[n].centre_mm =
          in_front(disc.point_mm + (from_feet == 0 ? -15.0 : 15.0) * disc.normal);
    }
  }
}

/// Where the voxels of a label map's vertebrae and those that were grown are, measured.
void FillLabels(const volume::Grid<volume::Label>& number, const volume::LabelMap* imported,
                const std::vector<VertebraEvidence>& evidence, Vertebrae& out) {
  const std::size_t count = out.list.size();
  const volume::Geometry& g = number.geometry;
  const double ml = g.voxel_volume_mm3() / 1000.0;
  std::map<int, std::size_t> place_of;
  for (std::size_t n = 0; n < count; ++n) {
    if (evidence[n].known) place_of[*evidence[n].known] = n;
  }
  out.labels = volume::LabelMap(g);
  for (std::size_t at = 0; at < number.voxels.size(); ++at) {
    std::size_t place = count - number.voxels[at];  // 1 is the lowest.
    if (imported != nullptr && imported->voxels[at] != 0) {
      const auto known = place_of.find(imported->voxels[at] - 1);
      if (known != place_of.end()) place = known->second;
    } else if (number.voxels[at] == 0 || evidence[place].known) {
      continue;
    }
    if (place >= count) continue;
    out.labels.voxels[at] = static_cast<volume::Label>(place + 1);
    out.list[place].volume_ml += ml;
  }
  for (std::size_t n = 0; n < count; ++n) {
    out.labels.names[static_cast<volume::Label>(n + 1)] = out.list[n].name;
  }
}

/// Grown farther than the vertebrae themselves: ribs and what is far aside belong to none.
void CutRibs(const CanalLine& line, const std::vector<float>& way_mm, const SpineFrame& frame,
             volume::Grid<volume::Label>& number) {
  const volume::Geometry& g = number.geometry;
  const Box box = BoxAround(line, g);
  for (int k = box.low[2]; k <= box.high[2]; ++k) {
    for (int j = box.low[1]; j <= box.high[1]; ++j) {
      for (int i = box.low[0]; i <= box.high[0]; ++i) {
        const std::size_t at = g.Index(i, j, k);
        if (number.voxels[at] == 0) continue;
        const auto place = frame.PlaceOf(g.ct_from_index() * Eigen::Vector3d(i, j, k));
        if (way_mm[at] > kLongestWayMm || std::abs(place.left_mm) > kFarthestAsideMm) {
          number.voxels[at] = 0;
        }
      }
    }
  }
}

/// Whether the CT shows where ribs would be beside a vertebra.
bool ShowsFlanks(const volume::Geometry& g, const CanalLine& line, std::size_t step) {
  const Eigen::Affine3d index_from_ct = g.index_from_ct();
  for (const double left : {-VertebraEvidence::kRibMm, VertebraEvidence::kRibMm}) {
    for (const double forward : {-25.0, 10.0}) {
      const Eigen::Vector3d p =
          line.points_mm[step] + left * line.Left(step) + forward * line.forward[step];
      const Eigen::Array3i v = (index_from_ct * p).array().round().cast<int>();
      if (!g.Contains(v[0], v[1], v[2])) return false;
    }
  }
  return true;
}

/// What is seen of the vertebrae, from the head. @param discs  From the feet.
std::vector<VertebraEvidence> EvidenceOf(const volume::Geometry& g, const CanalLine& line,
                                         const SpineFrame& frame, const SpineProfile& profile,
                                         const std::vector<DiscPlane>& discs,
                                         const std::vector<std::array<double, 2>>& reach_mm,
                                         const Vertebrae& found) {
  std::vector<VertebraEvidence> evidence;
  for (std::size_t n = 0; n < found.list.size(); ++n) {
    const std::size_t from_feet = found.list.size() - 1 - n;
    VertebraEvidence seen{
        .is_whole = found.list[n].is_whole,
        .shows_flanks = ShowsFlanks(g, line, frame.PlaceOf(found.list[n].centre_mm).step),
        .reach_mm = reach_mm[from_feet + 1]};
    if (from_feet > 0) seen.lies_on_open_disc = IsOpenAt(profile, discs[from_feet - 1]);
    if (seen.is_whole) {
      seen.height_mm = (discs[from_feet].point_mm - discs[from_feet - 1].point_mm).norm();
    }
    evidence.push_back(seen);
  }
  return evidence;
}

/// The place from the head of the vertebra whose body a point lies in. @throws InputError
GivenName PlaceOf(const NamedVertebra& given, const SpineFrame& frame, std::size_t count) {
  const int from_feet = frame.Between(given.point_mm);
  const SpinePlace place = frame.PlaceOf(given.point_mm);
  ACUS_REQUIRE(from_feet >= 0 && std::abs(place.left_mm) < 25.0 && place.forward_mm > -10.0 &&
                   place.forward_mm < 50.0,
               "vertebra ", given.name, ": the point (", NumberText(given.point_mm[0]), ", ",
               NumberText(given.point_mm[1]), ", ", NumberText(given.point_mm[2]),
               ") mm is not in the body of a vertebra that was found; centres are in "
               "vertebrae.csv of a run without --vertebra");
  return {count - 1 - static_cast<std::size_t>(from_feet), *NumberOfVertebra(given.name)};
}

void SetNames(VertebraNames names, Vertebrae& out) {
  for (std::size_t n = 0; n < out.list.size(); ++n) out.list[n].name = names.names[n];
  out.named_from = names.from;
  out.doubt = std::move(names.doubt);
}

}  // namespace

Vertebrae FindVertebrae(const volume::CtVolume& ct, const volume::LabelMap& tissues,
                        const std::optional<NamedVertebra>& start,
                        const volume::LabelMap* imported) {
  Vertebrae out;
  const CanalLine line = CanalLineOf(tissues);
  std::vector<DiscPlane> discs = FindDiscPlanes(ct, line);
  bool ends_on_sacrum = false;
  const SpineProfile profile(line, tissues);
  if (!line.points_mm.empty()) {
    out.dropped_discs = DropDiscsWithinVertebrae(profile, discs);
    if (const auto sacral = DiscOnSacrum(profile, line, discs)) {
      ends_on_sacrum = true;
      discs.erase(discs.begin(), discs.begin() + static_cast<std::ptrdiff_t>(*sacral));
    }
    if (imported != nullptr) discs = DiscsBetweenImported(*imported, line, std::move(discs));
  }
  ACUS_REQUIRE(discs.size() >= 2 || !start, "vertebra ", start ? start->name : "",
               ": the CT shows no spine with at least two discs, so there is nothing to name");
  if (discs.size() < 2) return imported != nullptr ? VertebraeOfImport(*imported) : out;
  const SpineFrame frame(line, discs);
  Growth growth(ct, tissues, frame, BoxAround(line, ct.geometry));
  volume::Grid<volume::Label> number = growth.Run();
  CutRibs(line, growth.way_mm(), frame, number);
  out.list.resize(discs.size() + 1);
  out.discs.assign(discs.rbegin(), discs.rend());
  Centre(line, frame, discs, out);
  auto evidence = EvidenceOf(ct.geometry, line, frame, profile, discs, growth.reach_mm(), out);
  if (imported != nullptr) AddKnownNames(*imported, frame, evidence);
  std::optional<GivenName> by_user;
  if (start) by_user = PlaceOf(*start, frame, out.list.size());
  SetNames(NameVertebrae(evidence, by_user, ends_on_sacrum), out);
  FillLabels(number, imported, evidence, out);
  return out;
}

void FillBodies(const volume::CtVolume& ct, volume::LabelMap& tissues) {
  const CanalLine line = CanalLineOf(tissues);
  const std::vector<DiscPlane> discs = FindDiscPlanes(ct, line);
  if (discs.size() < 2) return;
  const SpineFrame frame(line, discs);
  const Box box = BoxAround(line, ct.geometry);
  const volume::Label bone = volume::LabelOf("bone");
  const std::array open = {volume::LabelOf("fat"), volume::LabelOf("soft_tissue"),
                           volume::LabelOf("muscle")};
  std::vector<std::size_t> marrow;
  for (int k = box.low[2]; k <= box.high[2]; ++k) {
    for (int j = box.low[1]; j <= box.high[1]; ++j) {
      for (int i = box.low[0]; i <= box.high[0]; ++i) {
        if (std::ranges::find(open, tissues.At(i, j, k)) == open.end()) continue;
        const Eigen::Vector3d p = ct.geometry.ct_from_index() * Eigen::Vector3d(i, j, k);
        const SpinePlace place = frame.PlaceOf(p);
        if (std::abs(place.left_mm) > kMarrowHalfWidthMm || place.forward_mm < kMarrowFromMm ||
            place.forward_mm > kMarrowToMm || ct.At(i, j, k) < kLeastMarrowInBodyHu ||
            frame.Between(p) < 0) {
          continue;
        }
        if (NumHidden(tissues, bone, p, line.Left(place.step), line.forward[place.step]) >= 7) {
          marrow.push_back(ct.geometry.Index(i, j, k));
        }
      }
    }
  }
  for (const std::size_t at : marrow) tissues.voxels[at] = bone;
}

std::string VertebraeSentence(const Vertebrae& vertebrae) {
  if (vertebrae.empty()) return "";
  static const std::map<NamedFrom, const char*> kFrom = {
      {NamedFrom::kNothing, ""},
      {NamedFrom::kUser, " Named from --vertebra."},
      {NamedFrom::kImport, " Named by the label map."},
      {NamedFrom::kSacrum, " Named from the sacrum, whose wings the CT shows."},
      {NamedFrom::kLastRib,
       " Named from the last pair of ribs, taken for those of T12; in some "
       "people they are not."},
      {NamedFrom::kSacrumAndLastRib, " Named from the sacrum and the last pair of ribs."}};
  std::string text =
      Message(vertebrae.list.size(), " vertebrae: ", vertebrae.list.front().name, " to ",
              vertebrae.list.back().name, ", from the head.", kFrom.at(vertebrae.named_from), "\n");
  if (vertebrae.dropped_discs > 0) {
    text += Message(vertebrae.dropped_discs,
                    " discs were dropped: vertebrae without pedicles lay beside them.\n");
  }
  if (!vertebrae.doubt.empty()) {
    text += Message("Not all vertebrae are named: ", vertebrae.doubt,
                    ". --vertebra L3=X,Y,Z names them from one that you recognise; their centres "
                    "are in vertebrae.csv.\n");
  }
  return text;
}

}  // namespace acus::segmentation
