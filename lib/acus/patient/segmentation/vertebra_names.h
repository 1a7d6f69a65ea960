// The names of vertebrae: given, or from what fixes them in a CT; otherwise numbers.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "acus/data/volume/volume.h"

namespace acus::segmentation {

/// A vertebra whose name is known, by any point of its body.
struct NamedVertebra {
  std::string name;          ///< C1 to C7, T1 to T12, L1 to L5, S1.
  Eigen::Vector3d point_mm;  ///< CT.
};

/// Reads "L3=X,Y,Z", mm. @throws InputError saying what is allowed.
NamedVertebra ParseVertebra(const std::string& text);

/// C1 is 0, S1 is 24. Nothing if it is no name of a vertebra.
std::optional<int> NumberOfVertebra(const std::string& name);
/// @pre 0 <= number <= 24
std::string VertebraByNumber(int number);

/// What is seen of one vertebra.
struct VertebraEvidence {
  bool is_whole = false;      ///< Between two discs.
  bool shows_flanks = false;  ///< The CT shows bone up to kRibMm to both sides of it.
  std::array<double, 2> reach_mm = {0.0, 0.0};  ///< Of its bone, to the left and right.
  double height_mm = 0.0;                       ///< From disc to disc; 0 if not whole.
  bool lies_on_open_disc = true;                ///< See IsOpenAt; true without a disc below.
  std::optional<int> known = {};                ///< The number of its name, by a label map.

  static constexpr double kRibMm = 62.0;         ///< A rib reaches at least so far.
  static constexpr double kTransverseMm = 57.0;  ///< A transverse process at most so far.
};

/// What of it names the vertebrae.
enum class NamedFrom { kNothing, kUser, kImport, kSacrum, kLastRib, kSacrumAndLastRib };

struct VertebraNames {
  std::vector<std::string> names;  ///< From the head; "vertebra_3" where no name is sure.
  NamedFrom from = NamedFrom::kNothing;
  std::string doubt;  ///< For people: why there are numbers; empty if all are named.
};

/// A name that is given to the vertebra at a place in the list.
struct GivenName {
  std::size_t place;
  int number;
};

/// Names from what a user gives, otherwise from a label map, otherwise from the CT: the sacrum with
/// both wings (its place in the list is the last), or the last pair of ribs, of a whole vertebra
/// above two without any; if both are seen, five lumbar vertebrae must lie between them. Foramina
/// are open at lumbar discs, or there are no names. Names go
/// on from there up to where the heights of vertebrae are no longer those of neighbours.
/// @throws InputError if the user's name leaves no room for as many vertebrae as there are.
VertebraNames NameVertebrae(const std::vector<VertebraEvidence>& from_head,
                            const std::optional<GivenName>& by_user, bool ends_on_sacrum);

}  // namespace acus::segmentation
