#include "acus/patient/segmentation/vertebrae.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <queue>

#include "acus/base/core/csv.h"
#include "acus/base/core/text_table.h"
#include "acus/base/core/words.h"
#include "acus/base/math/point_text.h"
#include "acus/data/volume/labels.h"
#include "acus/patient/segmentation/mask.h"

namespace acus::segmentation {
namespace {

constexpr std::array kNames = {"C1",  "C2", "C3", "C4", "C5", "C6", "C7", "T1",  "T2",
                               "T3",  "T4", "T5", "T6", "T7", "T8", "T9", "T10", "T11",
                               "T12", "L1", "L2", "L3", "L4", "L5", "S1"};
// The core of a body, from the canal's middle; growth starts there.
constexpr double kCoreHalfWidthMm = 12.0;
constexpr double kCoreFromMm = 11.0;
constexpr double kCoreToMm = 28.0;
constexpr double kPlateMm = 2.0;  ///< The core keeps away from the discs' planes.
constexpr double kLongestWayMm = 62.0;
constexpr double kFarthestAsideMm = 50.0;
constexpr double kFarthestMm = 85.0;
constexpr double kCortexHu = 350.0;  ///< Ways through less dense bone count for more.
constexpr double kPorousCost = 2.5;  ///< At 0 HU, in addition to 1.
constexpr double kMarrowHalfWidthMm = 22.0;
constexpr double kMarrowFromMm = 6.0;
constexpr double kMarrowToMm = 42.0;
constexpr int kLeastMarrowInBodyHu = -60;
constexpr double kLeastSacralTiltDeg = 27.0;
constexpr double kEndMm = 45.0;  ///< Beyond the last disc; no vertebra is higher.

/// Where a point is along the spine.
struct SpinePlace {
  std::size_t step = 0;
  double left_mm = 0.0, forward_mm = 0.0;
};

class SpineFrame {
 public:
  SpineFrame(const CanalLine& line, const std::vector<DiscPlane>& discs)
      : line_(line), discs_(discs) {}

  SpinePlace PlaceOf(const Eigen::Vector3d& p) const {
    // The line runs upwards, nearly along that axis.
    const Eigen::Vector3d up = line_.axes.col(2);
    const Eigen::Vector3d& bottom = line_.points_mm.front();
    const double length_mm = up.dot(line_.points_mm.back() - bottom);
    const auto last = static_cast<double>(line_.points_mm.size() - 1);
    double at = std::clamp(up.dot(p - bottom) / length_mm, 0.0, 1.0) * last;
    for (int round = 0; round < 4; ++round) {
      const auto s = static_cast<std::size_t>(std::lround(at));
      at = std::clamp(at + (p - line_.points_mm[s]).dot(line_.tangent[s]) / line_.step_mm, 0.0,
                      last);
    }
    SpinePlace place;
    place.step = static_cast<std::size_t>(std::lround(at));
    const Eigen::Vector3d d = p - line_.points_mm[place.step];
    place.left_mm = d.dot(line_.Left(place.step));
    place.forward_mm = d.dot(line_.forward[place.step]);
    return place;
  }

  /// Vertebrae are numbered from the feet here: n lies above disc n - 1 and below disc n. -1 near a
  /// disc's plane, or too far beyond the last one.
  int Between(const Eigen::Vector3d& p) const {
    int number = 0;
    for (const DiscPlane& disc : discs_) {
      const double above = (p - disc.point_mm).dot(disc.normal);
      if (std::abs(above) < kPlateMm) return -1;
      if (above > 0.0) ++number;
    }
    const auto beyond = [&](const DiscPlane& disc) {
      return std::abs((p - disc.point_mm).dot(disc.normal)) > kEndMm;
    };
    if (number == 0 && beyond(discs_.front())) return -1;
    if (number == static_cast<int>(discs_.size()) && beyond(discs_.back())) return -1;
    return number;
  }

 private:
  const CanalLine& line_;
  const std::vector<DiscPlane>& discs_;  ///< From the feet to the head.
};

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
  }

  volume::Grid<volume::Label> Run() {
    Seed();
    while (!queue_.empty()) {
      const auto [way, at] = queue_.top();
      queue_.pop();
      if (way > way_mm_[at] || way > kLongestWayMm) continue;
      Visit(at, way);
    }
    return std::move(number_);
  }

 private:
  using Entry = std::pair<float, std::size_t>;

  void Seed() {
    for (int k = box_.low[2]; k <= box_.high[2]; ++k) {
      for (int j = box_.low[1]; j <= box_.high[1]; ++j) {
        for (int i = box_.low[0]; i <= box_.high[0]; ++i) {
          if (tissues_.At(i, j, k) != bone_) continue;
          const Eigen::Vector3d p = ct_.geometry.ct_from_index() * Eigen::Vector3d(i, j, k);
          const SpinePlace place = frame_.PlaceOf(p);
          if (std::abs(place.left_mm) > kCoreHalfWidthMm || place.forward_mm < kCoreFromMm ||
              place.forward_mm > kCoreToMm) {
            continue;
          }
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
          if (next >= way_mm_[there] || next > kLongestWayMm) continue;
          const SpinePlace place = frame_.PlaceOf(g.ct_from_index() * to.cast<double>().matrix());
          if (std::abs(place.left_mm) > kFarthestAsideMm) continue;
          Set(there, next, number_.voxels[at]);
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

std::string AllNames() {
  return Message(kNames.front(), " to C7, T1 to T12, L1 to L5, ", kNames.back());
}

/// Place of a name in kNames. @throws InputError
int NumberOf(const std::string& name) {
  const auto found = std::ranges::find(kNames, name);
  ACUS_REQUIRE(found != kNames.end(), "'", name, "' is no vertebra; allowed: ", AllNames());
  return static_cast<int>(found - kNames.begin());
}

/// The disc between L5 and the sacrum leans forward by about 30 to 45 degrees, others by less
/// than 22.
bool LiesOnSacrum(const DiscPlane& lowest, const CanalLine& line) {
  return lowest.normal.dot(line.axes.col(1)) < -std::sin(kLeastSacralTiltDeg * M_PI / 180.0);
}

/// Measures and numbers, from the head.
void FillList(const volume::Grid<volume::Label>& number, Vertebrae& out) {
  const auto count = static_cast<int>(out.list.size());
  const volume::Geometry& g = number.geometry;
  const double ml = g.voxel_volume_mm3() / 1000.0;
  out.labels = volume::LabelMap(g);
  for (std::size_t at = 0; at < number.voxels.size(); ++at) {
    if (number.voxels[at] == 0) continue;
    const int place = count - number.voxels[at];  // 1 is the lowest.
    out.labels.voxels[at] = static_cast<volume::Label>(place + 1);
    out.list[static_cast<std::size_t>(place)].volume_ml += ml;
  }
}

void Name(const std::optional<NamedVertebra>& start, const CanalLine& line, const SpineFrame& frame,
          Vertebrae& out) {
  const auto count = static_cast<int>(out.list.size());
  int first = -1;
  if (start) {
    const int from_feet = frame.Between(start->point_mm);
    const SpinePlace place = frame.PlaceOf(start->point_mm);
    ACUS_REQUIRE(from_feet >= 0 && std::abs(place.left_mm) < 25.0 && place.forward_mm > -10.0 &&
                     place.forward_mm < 50.0,
                 "vertebra ", start->name, ": the point (", NumberText(start->point_mm[0]), ", ",
                 NumberText(start->point_mm[1]), ", ", NumberText(start->point_mm[2]),
                 ") mm is not in the body of a vertebra that was found; centres are in "
                 "vertebrae.csv of a run without --vertebra");
    first = NumberOf(start->name) - (count - 1 - from_feet);
    // The lowest may be the sacrum as a whole, but nothing lies below it.
    ACUS_REQUIRE(first >= 0 && first + count <= static_cast<int>(kNames.size()), "vertebra ",
                 start->name, ": ", count - 1 - from_feet, " vertebrae lie above and ", from_feet,
                 " below it in the CT, which does not fit this name");
  }
  if (!start && LiesOnSacrum(out.discs.back(), line)) {
    first = NumberOf("S1") - (count - 1);
    out.named_from_sacrum = first >= 0;
  }
  for (int n = 0; n < count; ++n) {
    Vertebra& vertebra = out.list[static_cast<std::size_t>(n)];
    vertebra.name =
        first >= 0 ? kNames[static_cast<std::size_t>(first + n)] : Message("vertebra_", n + 1);
    out.labels.names[static_cast<volume::Label>(n + 1)] = vertebra.name;
  }
}

/// The middle of each body: half-way between its discs, or 15 mm beyond the last one.
void Centre(const CanalLine& line, const SpineFrame& frame, const std::vector<DiscPlane>& discs,
            Vertebrae& out) {
  const auto in_front = [&](const Eigen::Vector3d& on_line) -> Eigen::Vector3d {
    const auto step = frame.PlaceOf(on_line).step;
    return line.points_mm[step] + 0.5 * (kCoreFromMm + kCoreToMm) * line.forward[step];
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

}  // namespace

NamedVertebra ParseVertebra(const std::string& text) {
  const std::size_t equals = std::min(text.find('='), text.size());
  NamedVertebra out{.name = text.substr(0, equals), .point_mm = Eigen::Vector3d::Zero()};
  out.point_mm = math::PointFromText(
      text.substr(std::min(equals + 1, text.size())),
      Message("--vertebra '", text,
              "': must be a name and a point of its body in CT mm, such as L3=-2.5,110,140"));
  NumberOf(out.name);
  return out;
}

Vertebrae FindVertebrae(const volume::CtVolume& ct, const volume::LabelMap& tissues,
                        const std::optional<NamedVertebra>& start) {
  Vertebrae out;
  const CanalLine line = CanalLineOf(tissues);
  const std::vector<DiscPlane> discs = FindDiscPlanes(ct, line);
  ACUS_REQUIRE(discs.size() >= 2 || !start, "vertebra ", start ? start->name : "",
               ": the CT shows no spine with at least two discs, so there is nothing to name");
  if (discs.size() < 2) return out;
  const SpineFrame frame(line, discs);
  const auto number = Growth(ct, tissues, frame, BoxAround(line, ct.geometry)).Run();
  out.list.resize(discs.size() + 1);
  out.discs.assign(discs.rbegin(), discs.rend());
  FillList(number, out);
  Name(start, line, frame, out);
  Centre(line, frame, discs, out);
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
  return Message(vertebrae.list.size(), " vertebrae: ", vertebrae.list.front().name, " to ",
                 vertebrae.list.back().name, ", from the head",
                 vertebrae.named_from_sacrum ? ". Named from the tilt of the lowest disc; "
                                               "--vertebra names them otherwise.\n"
                                             : ".\n");
}

}  // namespace acus::segmentation
