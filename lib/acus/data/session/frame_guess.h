// Which frames of a recording may be needle, probe and reference, if none has a usual name.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "acus/data/transforms/transform_graph.h"

namespace acus::session {

struct FrameGuess {
  std::string reference;
  std::vector<std::string> needle;  ///< Likeliest first.
  std::vector<std::string> probe;
};

/// The reference is the first of Reference, Tracker, RAS, World that there is, else the frame that
/// most transforms lead to. Frames with "needle", "stylus" or "pointer" in their names may be the
/// needle, those with "transducer", "probe" or "image" the probe. If there are none, the first
/// frame that is given in the reference is taken as the needle.
/// @returns nothing if there are no transforms.
std::optional<FrameGuess> GuessFrames(const std::vector<transforms::TransformName>& names);

}  // namespace acus::session
