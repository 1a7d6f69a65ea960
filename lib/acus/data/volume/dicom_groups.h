// Which images of a DICOM folder make one volume.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "acus/data/volume/dicom_header.h"
#include "acus/data/volume/volume_io.h"

namespace acus::volume {

/// Images of one volume.
struct SliceGroup {
  DicomSeries series;
  std::vector<DicomHeader> headers;  ///< In order along the slice normal.
  std::vector<std::string> notes;    ///< What was repaired or omitted.
};

Eigen::Vector3d NormalOf(const DicomHeader& header);

/// The images of a folder (searched recursively), largest group first: those of one series, moment
/// and size whose orientations differ by less than 5 mrad and whose pixel spacings by less than
/// 0.1 %. Frames of a multi-frame object are images. Identical copies are omitted. A group with
/// several images at one place is split by what distinguishes them: acquisition number, percentage
/// of the cycle, comment, description, trigger, acquisition or content time, image type, or the
/// order of the instances. In place of a folder, a multi-frame object may be given.
/// @throws InputError if there is no readable DICOM image in it.
std::vector<SliceGroup> SliceGroupsIn(const std::filesystem::path& folder, int num_threads);

}  // namespace acus::volume
