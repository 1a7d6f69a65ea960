// Transform buffers that Perk Tutor's transform recorder saved as XML.
#pragma once

#include <filesystem>

#include "acus/data/session/slicer_scene.h"

namespace acus::session {

/// Reads a <TransformRecorderLog>: one line for each transform that arrived, in RAS, to the parent.
///
/// Sampled as Perk Tutor and Slicer do, so that metrics agree with theirs: stamps have six
/// significant digits; all transforms are taken at the times of the device that is named first,
/// each from its entry within 1 ms of that time, else from its last entry before.
/// @throws InputError at file:line if it is not such a file or an entry is damaged.
SlicerScene ReadPerkBuffer(const std::filesystem::path& path);

}  // namespace acus::session
