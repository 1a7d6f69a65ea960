// Grey images from PNG.
#pragma once

#include <filesystem>

#include "acus/data/image/image.h"

namespace acus::image {

/// Reads an 8-bit PNG, grey or of three equal colours; what is transparent lies on black.
/// @throws InputError if the file cannot be read, is not such a PNG, is damaged, has more than 64
///     million pixels, or a pixel has a colour.
GrayImage ReadGreyPng(const std::filesystem::path& path);

}  // namespace acus::image
