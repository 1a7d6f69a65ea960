// Single vertebrae: bone between the planes of two discs, with its arch and processes, and a name.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "acus/patient/segmentation/spine/disc_planes.h"
#include "acus/patient/segmentation/vertebra_names.h"

namespace acus::segmentation {

struct Vertebra {
  std::string name;       ///< "L3" if that is sure, else "vertebra_1" from the head.
  bool is_whole = false;  ///< Between two discs; otherwise one lies beyond what the CT shows.
  Eigen::Vector3d centre_mm = Eigen::Vector3d::Zero();  ///< Of its body, CT.
  double volume_ml = 0.0;
};

struct Vertebrae {
  std::vector<Vertebra> list;    ///< From the head to the feet.
  std::vector<DiscPlane> discs;  ///< From the head to the feet; list[i] lies above discs[i].
  volume::LabelMap labels;       ///< 1 + place in the list; 0 elsewhere.

  NamedFrom named_from = NamedFrom::kNothing;
  std::string doubt;      ///< For people: why there are numbers; empty if all are named.
  int dropped_discs = 0;  ///< Found within a vertebra, which has no disc there.

  bool empty() const { return list.empty(); }
};

/// Vertebrae of the bone in `tissues`, which must have a spinal_canal; empty without one, or
/// without two discs. From the bodies between the discs they grow along bone, dense bone first, so
/// that joints part them; ribs and pelvis beyond 62 mm of way or 50 mm off the midline are left.
/// What lies below the disc on the sacrum is one.
/// @param start  Names all; see NameVertebrae for what does without it.
/// @param imported  If given: vertebrae of a label map, 1 + NumberOfVertebra; they stay as they
///     are, and their names go before those from the CT. Without a canal they are all.
/// @throws InputError if the start lies in no vertebra, or its name does not leave room for as many
///     vertebrae as are there above and below.
Vertebrae FindVertebrae(const volume::CtVolume& ct, const volume::LabelMap& tissues,
                        const std::optional<NamedVertebra>& start,
                        const volume::LabelMap* imported = nullptr);

/// Labels as bone what bone surrounds within the bodies of vertebrae: marrow that the cortex, where
/// it is thin, does not close off in a slice. Of fat, muscle and soft tissue, voxels that are not
/// at a disc and that bone hides in at least 7 of 8 directions across the spine, within 30 mm.
void FillBodies(const volume::CtVolume& ct, volume::LabelMap& tissues);

/// For people: how many there are, their names, what these follow from or why there are none.
std::string VertebraeSentence(const Vertebrae& vertebrae);

}  // namespace acus::segmentation
