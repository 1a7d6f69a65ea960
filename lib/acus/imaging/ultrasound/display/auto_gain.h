// The gain that shows tissue at a medium grey: the key of a scanner for automatic gain.
#pragma once

#include "acus/data/image/image.h"

namespace acus::ultrasound {

/// Median grey of tissue that automatic gain leads to: that of 56 frames of a leg from a scanner
/// (82; their quartiles are 70 and 91).
inline constexpr int kTissueGrey = 82;
/// Greys up to this are shadow, noise, or outside the sector.
inline constexpr int kDarkGrey = 10;
/// Largest change at once, dB: greys beyond white or black do not show how far they are.
inline constexpr double kMostGainChangeDb = 20.0;

/// By how much to change the gain of a B-mode image, in whole dB, so that the median of its greys
/// above kDarkGrey becomes kTissueGrey. One dB is taken as 255 / dynamic range in grey; a display
/// with a curve of its own needs the change a second time, for the new image.
/// @return kMostGainChangeDb if less than 2 % of the image are brighter than kDarkGrey: it shows
///     nothing yet. Between -kMostGainChangeDb and kMostGainChangeDb.
/// @pre dynamic_range_db > 0.
double AutoGainChangeDb(const image::GrayImage& image, double dynamic_range_db);

}  // namespace acus::ultrasound
