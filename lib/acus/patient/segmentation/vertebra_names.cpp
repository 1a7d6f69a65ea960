#include "acus/patient/segmentation/vertebra_names.h"

#include <algorithm>

#include "acus/base/core/error.h"
#include "acus/base/core/text_table.h"
#include "acus/base/core/words.h"
#include "acus/base/math/point_text.h"

namespace acus::segmentation {
namespace {

constexpr std::array kNames = {"C1",  "C2", "C3", "C4", "C5", "C6", "C7", "T1",  "T2",
                               "T3",  "T4", "T5", "T6", "T7", "T8", "T9", "T10", "T11",
                               "T12", "L1", "L2", "L3", "L4", "L5", "S1"};
constexpr int kT12 = 18;
constexpr int kS1 = 24;
// Neighbours are within a seventh of each other; a disc that is missed or found twice makes it two.
constexpr double kMostHeightRatio = 1.45;
constexpr double kLeastLumbarMm = 24.0;  ///< Mean height of the three vertebrae above a sacrum.

std::string AllNames() {
  return Message(kNames.front(), " to C7, T1 to T12, L1 to L5, ", kNames.back());
}

/// One vertebra whose name follows from the CT.
struct Anchor {
  std::size_t place;
  int number;
};

bool HasRibs(const VertebraEvidence& v) {
  return std::ranges::min(v.reach_mm) >= VertebraEvidence::kRibMm;
}

bool HasNoRibs(const VertebraEvidence& v) {
  return v.shows_flanks && v.is_whole &&
         std::ranges::max(v.reach_mm) <= VertebraEvidence::kTransverseMm;
}

/// T12: the lowest vertebra with ribs on both sides, above two whole ones without any. One that is
/// not whole may be two, of which the upper has the ribs.
std::optional<Anchor> LastRib(const std::vector<VertebraEvidence>& list) {
  for (std::size_t n = 0; n + 2 < list.size(); ++n) {
    if (HasRibs(list[n]) && HasNoRibs(list[n + 1]) && HasNoRibs(list[n + 2])) {
      return Anchor{n, kT12};
    }
  }
  return std::nullopt;
}

/// Whether the vertebrae above a sacrum are as high as lumbar ones.
bool IsLumbarAbove(const std::vector<VertebraEvidence>& list) {
  double sum = 0.0;
  int count = 0;
  for (std::size_t n = list.size() - 1; n-- > 0 && count < 3;) {
    if (list[n].height_mm == 0.0) continue;
    sum += list[n].height_mm;
    ++count;
  }
  return count > 0 && sum / count >= kLeastLumbarMm;
}

std::string Numbered(std::size_t place) {
  return Message("vertebra_", place + 1);
}

/// Whether two neighbours are about as high; true where one is not whole.
bool AreAlike(const VertebraEvidence& a, const VertebraEvidence& b) {
  if (a.height_mm == 0.0 || b.height_mm == 0.0) return true;
  const auto [low, high] = std::minmax(a.height_mm, b.height_mm);
  return high <= kMostHeightRatio * low;
}

/// Names up and down from one vertebra; with `checked` up to where heights break off.
VertebraNames From(const std::vector<VertebraEvidence>& list, const Anchor& anchor, NamedFrom from,
                   bool checked) {
  VertebraNames out;
  out.from = from;
  for (std::size_t n = 0; n < list.size(); ++n) out.names.push_back(Numbered(n));
  const auto name = [&](std::size_t n) {
    const int number = anchor.number + static_cast<int>(n) - static_cast<int>(anchor.place);
    if (number < 0 || number > kS1) return false;
    out.names[n] = VertebraByNumber(number);
    return true;
  };
  name(anchor.place);
  for (const int way : {-1, 1}) {
    for (std::size_t n = anchor.place; (way > 0 ? n + 1 < list.size() : n > 0);) {
      const std::size_t next = way > 0 ? n + 1 : n - 1;
      if (checked && !AreAlike(list[n], list[next])) {
        out.doubt =
            Message("beyond ", out.names[n], " the heights of vertebrae do not fit their ",
                    "adjacent ones (", FixedText(list[n].height_mm, 0), " and ",
                    FixedText(list[next].height_mm, 0), " mm): a disc is missed there, or is none");
        break;
      }
      if (!name(next)) {
        out.doubt = Message("there are more vertebrae than names beyond ", out.names[n]);
        break;
      }
      n = next;
    }
  }
  return out;
}

VertebraNames Unnamed(std::size_t count, std::string doubt) {
  VertebraNames out;
  for (std::size_t n = 0; n < count; ++n) out.names.push_back(Numbered(n));
  out.doubt = std::move(doubt);
  return out;
}

/// By a label map; its own names stay even where they do not follow each other.
VertebraNames FromImport(const std::vector<VertebraEvidence>& list) {
  std::optional<Anchor> first;
  bool agree = true;
  for (std::size_t n = 0; n < list.size(); ++n) {
    if (!list[n].known) continue;
    if (!first) first = Anchor{n, *list[n].known};
    agree = agree && *list[n].known - first->number == static_cast<int>(n - first->place);
  }
  if (agree) return From(list, *first, NamedFrom::kImport, false);
  VertebraNames out = Unnamed(list.size(),
                              "the names of the label map do not follow each other; "
                              "what it does not name has numbers");
  out.from = NamedFrom::kImport;
  for (std::size_t n = 0; n < list.size(); ++n) {
    if (list[n].known) out.names[n] = VertebraByNumber(*list[n].known);
  }
  return out;
}

/// Without the doubtful: a disc that closed foramina show to lie within a lumbar vertebra.
VertebraNames WithOpenForamina(const std::vector<VertebraEvidence>& list, VertebraNames names) {
  for (std::size_t n = 0; n < list.size(); ++n) {
    const auto number = NumberOfVertebra(names.names[n]);
    if (!number || *number <= kT12 || *number >= kS1 - 1 || list[n].lies_on_open_disc) continue;
    return Unnamed(list.size(), Message("the disc below what would be ", names.names[n],
                                        " lies between pedicles, where no disc is"));
  }
  return names;
}

VertebraNames FromCt(const std::vector<VertebraEvidence>& list, bool ends_on_sacrum) {
  auto rib = LastRib(list);
  const bool sacrum = ends_on_sacrum && IsLumbarAbove(list);
  const bool fits = rib && rib->place + 7 == list.size();
  if (rib && !list[rib->place].is_whole && !(sacrum && fits)) rib.reset();
  if (sacrum && rib) {
    if (fits) return WithOpenForamina(list, From(list, *rib, NamedFrom::kSacrumAndLastRib, true));
    return Unnamed(list.size(),
                   Message(list.size() - 2 - rib->place,
                           " vertebrae, not 5, were found between the last pair of ribs "
                           "and the sacrum"));
  }
  if (sacrum)
    return WithOpenForamina(list, From(list, {list.size() - 1, kS1}, NamedFrom::kSacrum, true));
  if (rib) return WithOpenForamina(list, From(list, *rib, NamedFrom::kLastRib, true));
  return Unnamed(
      list.size(),
      ends_on_sacrum
          ? "the vertebrae above what looks like a sacrum are lower than lumbar ones"
          : "the CT shows neither the sacrum with both wings, nor a whole vertebra with the "
            "last pair of ribs and two vertebrae without ribs below it");
}

}  // namespace

NamedVertebra ParseVertebra(const std::string& text) {
  const std::size_t equals = std::min(text.find('='), text.size());
  NamedVertebra out{.name = text.substr(0, equals), .point_mm = Eigen::Vector3d::Zero()};
  out.point_mm = math::PointFromText(
      text.substr(std::min(equals + 1, text.size())),
      Message("--vertebra '", text,
              "': must be a name and a point of its body in CT mm, such as L3=-2.5,110,140"));
  ACUS_REQUIRE(NumberOfVertebra(out.name), "'", out.name,
               "' is no vertebra; allowed: ", AllNames());
  return out;
}

std::optional<int> NumberOfVertebra(const std::string& name) {
  const auto found = std::ranges::find(kNames, name);
  if (found == kNames.end()) return std::nullopt;
  return static_cast<int>(found - kNames.begin());
}

std::string VertebraByNumber(int number) {
  return kNames.at(static_cast<std::size_t>(number));
}

VertebraNames NameVertebrae(const std::vector<VertebraEvidence>& list,
                            const std::optional<GivenName>& by_user, bool ends_on_sacrum) {
  if (by_user) {
    const int above = static_cast<int>(by_user->place);
    const int below = static_cast<int>(list.size()) - 1 - above;
    // The lowest may be the sacrum as a whole, but nothing lies below it.
    ACUS_REQUIRE(by_user->number >= above && by_user->number + below <= kS1, "vertebra ",
                 VertebraByNumber(by_user->number), ": ", above, " vertebrae lie above and ", below,
                 " below it in the CT, which does not fit this name");
    return From(list, {by_user->place, by_user->number}, NamedFrom::kUser, false);
  }
  const bool imported =
      std::ranges::any_of(list, [](const VertebraEvidence& v) { return v.known.has_value(); });
  return imported ? FromImport(list) : FromCt(list, ends_on_sacrum);
}

}  // namespace acus::segmentation
