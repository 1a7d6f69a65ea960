// Single vertebrae: bone between the planes of two discs, with its arch and processes, and a name.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "acus/patient/segmentation/disc_planes.h"

namespace acus::segmentation {

/// A vertebra whose name is known, by any point of its body.
struct NamedVertebra {
  std::string name;          ///< C2 to C7, T1 to T12, L1 to L5, S1.
  Eigen::Vector3d point_mm;  ///< CT.
};

/// Reads "L3=X,Y,Z", mm. @throws InputError saying what is allowed.
NamedVertebra ParseVertebra(const std::string& text);

struct Vertebra {
  std::string name;       ///< With a start "L3", else "vertebra_1" from the head.
  bool is_whole = false;  ///< Between two discs; otherwise one lies beyond what the CT shows.
  Eigen::Vector3d centre_mm = Eigen::Vector3d::Zero();  ///< Of its body, CT.
  double volume_ml = 0.0;
};

struct Vertebrae {
  std::vector<Vertebra> list;    ///< From the head to the feet.
  std::vector<DiscPlane> discs;  ///< From the head to the feet; list[i] lies above discs[i].
  volume::LabelMap labels;       ///< 1 + place in the list; 0 elsewhere.

  bool named_from_sacrum = false;

  bool empty() const { return list.empty(); }
};

/// Vertebrae of the bone in `tissues`, which must have a spinal_canal; empty without one, or
/// without two discs. From the bodies between the discs they grow along bone, dense bone first, so
/// that joints part them; ribs and pelvis beyond 62 mm of way or 50 mm off the midline are left.
/// @param start  Names all. Without it they are named if the lowest disc leans forward by 27
/// degrees
///     or more, as between L5 and the sacrum; otherwise they are numbered.
/// @throws InputError if the start lies in no vertebra, or its name does not leave room for as many
///     vertebrae as are there above and below.
Vertebrae FindVertebrae(const volume::CtVolume& ct, const volume::LabelMap& tissues,
                        const std::optional<NamedVertebra>& start);

/// Labels as bone what bone surrounds within the bodies of vertebrae: marrow that the cortex, where
/// it is thin, does not close off in a slice. Of fat, muscle and soft tissue, voxels that are not
/// at a disc and that bone hides in at least 7 of 8 directions across the spine, within 30 mm.
void FillBodies(const volume::CtVolume& ct, volume::LabelMap& tissues);

/// For people: how many there are, and their names.
std::string VertebraeSentence(const Vertebrae& vertebrae);

}  // namespace acus::segmentation
