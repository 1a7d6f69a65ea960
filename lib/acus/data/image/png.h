// Images as PNG.
#pragma once

#include <filesystem>
#include <string_view>

#include "acus/data/image/image.h"

namespace acus::image {

/// Writes an 8-bit PNG, grey or RGB, whole or not at all. The same image gives the same bytes.
/// @param comment  Goes into the file as text, such as Provenance::OneLine(); may be empty.
/// @throws InputError if the image has no pixel or the file cannot be written.
void WritePng(const std::filesystem::path& path, const GrayImage& image,
              std::string_view comment = {});
void WritePng(const std::filesystem::path& path, const ColourImage& image,
              std::string_view comment = {});

}  // namespace acus::image
