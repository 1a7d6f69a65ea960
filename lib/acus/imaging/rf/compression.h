// Envelope to grey values.
#pragma once

#include "acus/data/image/image.h"
#include "acus/imaging/rf/beamform.h"

namespace acus::rf {

/// Grey = 255 (1 + 20 log10(envelope / brightest) / range), clamped. An image of zeros is black.
/// @throws InputError if the range is not above 0.
image::GrayImage Compressed(const IqImage& image, double dynamic_range_db);

}  // namespace acus::rf
