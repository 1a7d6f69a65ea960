// An image as a video camera gives it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

namespace acus::camera {

/// pixels[channels * (row * width_px + column) + channel]; row 0 is at the top. Centres of pixels
/// are at whole numbers.
struct Image {
  int width_px = 0;
  int height_px = 0;
  int channels = 1;  ///< 1: grey; 3: red, green, blue (sRGB).
  std::vector<std::uint8_t> pixels;
  std::int64_t time_ns = 0;  ///< When it arrived, CLOCK_MONOTONIC; 0: not known.

  bool empty() const { return pixels.empty(); }
  /// Allocates only if the image grows. The content is undefined afterwards.
  void Resize(int new_width_px, int new_height_px, int new_channels);
};

/// Grey of a colour image (luma of ITU-R BT.601), or a copy. Keeps the time.
void ToGrey(const Image& image, Image& grey);

/// PNG, JPEG, TIFF, BMP or PNM, by content; 8 bits of each colour.
/// @throws InputError if the file cannot be read or is no image, or has more than 8192 pixels in
///     a direction.
Image ReadImage(const std::filesystem::path& path);
/// The images of a folder by name, in order: .png, .jpg, .jpeg, .tif, .tiff, .bmp, .pgm, .ppm.
/// @throws InputError if there is no such folder, or no image in it.
std::vector<std::filesystem::path> ImageFiles(const std::filesystem::path& folder);
/// By the extension of the name (.png, .jpg, .tif; .pgm if grey, .ppm if not), whole or not at all.
/// @throws InputError for another extension, no pixels, or a file that cannot be written.
void WriteImage(const std::filesystem::path& path, const Image& image);

}  // namespace acus::camera
