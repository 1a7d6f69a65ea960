#include "acus/data/image/png_reader.h"

#include <png.h>
#include <string>
#include <vector>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"

namespace acus::image {
namespace {

constexpr std::size_t kMostPixels = 64'000'000;
constexpr std::size_t kSignatureBytes = 8;

/// libpng's image, freed whatever happens.
struct PngImage {
  PngImage() { image.version = PNG_IMAGE_VERSION; }
  ~PngImage() { png_image_free(&image); }
  PngImage(const PngImage&) = delete;
  PngImage& operator=(const PngImage&) = delete;
  png_image image{};
};

bool IsPng(const std::string& bytes) {
  const auto* data = reinterpret_cast<png_const_bytep>(bytes.data());
  return bytes.size() >= kSignatureBytes && png_sig_cmp(data, 0, kSignatureBytes) == 0;
}

void RequireNoWarning(const png_image& image, const std::string& file) {
  ACUS_REQUIRE(image.warning_or_error == 0, file, ": is a damaged PNG: ", image.message,
               "; copy or save it again");
}

}  // namespace

GrayImage ReadGreyPng(const std::filesystem::path& path) {
  const std::string file = path.string();
  const std::string bytes = ReadTextFile(path);
  ACUS_REQUIRE(IsPng(bytes), file,
               ": is not a PNG: it does not begin as one; save the image as an 8-bit grey PNG");
  PngImage png;
  png_image_begin_read_from_memory(&png.image, bytes.data(), bytes.size());
  RequireNoWarning(png.image, file);
  ACUS_REQUIRE((png.image.format & PNG_FORMAT_FLAG_LINEAR) == 0, file,
               ": is a PNG of 16 bits; allowed: 8 bits, grey: save it so");
  ACUS_REQUIRE(png.image.height <= kMostPixels / png.image.width, file, ": is an image of ",
               png.image.width, " x ", png.image.height,
               " pixels; allowed are 1 to 64 million in all");
  png.image.format = PNG_FORMAT_RGB;
  std::vector<std::uint8_t> rgb(PNG_IMAGE_SIZE(png.image));
  const png_color black{0, 0, 0};
  png_image_finish_read(&png.image, &black, rgb.data(), 0, nullptr);
  RequireNoWarning(png.image, file);
  GrayImage image;
  image.Resize(static_cast<int>(png.image.width), static_cast<int>(png.image.height));
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    const std::uint8_t* pixel = &rgb[3 * i];
    ACUS_REQUIRE(pixel[0] == pixel[1] && pixel[1] == pixel[2], file, ": pixel (",
                 i % png.image.width, ", ", i / png.image.width, ") has a colour, ", int{pixel[0]},
                 " ", int{pixel[1]}, " ", int{pixel[2]},
                 "; save the image in grey, without overlays");
    image.pixels[i] = pixel[0];
  }
  return image;
}

}  // namespace acus::image
