// Files for 3D Slicer beside a recording: a scene that shows the session while it runs.
#pragma once

#include <filesystem>
#include <string>

#include "acus/data/transforms/landmarks.h"

namespace acus::live {

/// Writes `slicer.mrml`, a scene that connects to the session by SlicerOpenIGTLink (module
/// OpenIGTLinkIF) and has a node for all that Broadcast sends: tools below ReferenceToRas, the
/// ultrasound in the red view, over the CT; and `needle.mrk.json`, the line of its needle.
/// @param host  Address of the session's server; empty: all addresses of this computer.
/// @param targets  Are in the folder as replay::kTargetMarkups, unless there are none.
/// @throws InputError if it cannot be written.
void WriteSlicerScene(const std::filesystem::path& folder, const std::string& host, int port,
                      const transforms::Landmarks& targets);

}  // namespace acus::live
