// The motion of a bright line through the images of a recording, such as the bottom of a water
// tank.
#pragma once

#include <filesystem>

#include "acus/base/core/run_context.h"
#include "acus/patient/registration/temporal.h"

namespace acus::registration {

/// The row (px) of the brightest thing that moves, in each image of a PLUS sequence with time
/// stamps, by four detectors with the same times. Each takes the mean grey value of each row over
/// the middle half of the columns. In this order: the centre of the largest peak of what differs
/// from the median over all images; where that peak rises and where it has fallen to half its
/// height (its upper and lower edge); and the centre of the largest peak of the mean itself.
/// @throws InputError if the file has no 8 bit images or no time stamps.
std::vector<MotionSignal> LineMotion(const std::filesystem::path& sequence,
                                     const RunContext& context);

}  // namespace acus::registration
