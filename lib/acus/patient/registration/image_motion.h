// The motion of a bright line through the images of a recording, such as the bottom of a water
// tank.
#pragma once

#include <filesystem>

#include "acus/base/core/run_context.h"
#include "acus/patient/registration/temporal.h"

namespace acus::registration {

/// The row (px) of the brightest thing that moves, in each image of a PLUS sequence with time
/// stamps: mean grey value of each row over the middle half of the columns, less its median over
/// all images, and the centre of its largest peak.
/// @throws InputError if the file has no 8 bit images or no time stamps.
MotionSignal LineMotion(const std::filesystem::path& sequence, const RunContext& context);

}  // namespace acus::registration
