// The header fields by which 3D Slicer, and MITK, recognise a segmentation in an NRRD file.
#pragma once

#include <map>
#include <string>

#include "acus/data/volume/value_names.h"
#include "acus/data/volume/volume.h"

namespace acus::volume {

/// Fields "Segment0_Name", "Segment0_LabelValue", ... for each label in `names`, with its colour,
/// the extent of its voxels and its terminology, plus the fields of the segmentation as a whole.
std::map<std::string, std::string> SegmentKeys(const Grid<Label>& labels,
                                               const std::map<Label, std::string>& names);

/// The names by label in such fields; fields that are not understood are omitted.
std::map<Label, std::string> NamesFromKeys(const std::map<std::string, std::string>& keys);

/// One segment: in one layer of the file, the voxels with one value.
struct LayeredSegment {
  int layer = 0;
  std::int32_t value = 0;
  ValueName name;  ///< Its name, and the SNOMED CT codes of its terminology (type, then region).
};

/// All segments that such fields name, or the label groups of MITK, each of which is a layer;
/// fields that are not understood are omitted.
/// @throws InputError naming `label` if the label groups of MITK are broken.
std::vector<LayeredSegment> SegmentsFromKeys(const std::map<std::string, std::string>& keys,
                                             const std::string& label);

}  // namespace acus::volume
