// The coordinates of a DICOM object: its frame of reference (PS3.3, C.7.4.1), and the series that
// it belongs to or was drawn on.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "acus/base/core/run_context.h"

namespace acus::volume {

struct DicomFrame {
  std::vector<std::string> uids;    ///< Frame of Reference UID; of a structure set, of each ROI.
  std::vector<std::string> series;  ///< Series Instance UID: its own, or those it was drawn on.
};

/// The frame of the series that ReadCt takes; empty for a CT that is no DICOM.
DicomFrame FrameOfCt(const std::filesystem::path& ct, const std::string& series, int num_threads);

/// The frame that a segmentation or structure set (RTSTRUCT) refers to.
DicomFrame FrameOfLabels(const std::filesystem::path& object);

/// Warns if the labels were drawn on another series of the frame of the CT, or name the CT's series
/// beside another frame.
/// @throws InputError with the UIDs if they have another frame of reference and name another
///     series, or none; a warning instead if that is accepted.
void RequireSameFrame(const DicomFrame& labels, const DicomFrame& ct, bool accept_other,
                      const std::filesystem::path& object, const RunContext& context);

}  // namespace acus::volume
