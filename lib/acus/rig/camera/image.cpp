#include "acus/rig/camera/image.h"

#include <algorithm>
#include <cctype>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <set>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "acus/rig/camera/opencv_image.h"

namespace acus::camera {
namespace {

constexpr int kLargestPx = 8192;

}  // namespace

void HoldOpenCvToOneThread() {
  cv::setNumThreads(1);
}

cv::Mat MatOf(const Image& image) {
  return {image.height_px, image.width_px, CV_8UC(image.channels),
          const_cast<std::uint8_t*>(image.pixels.data())};
}

void Image::Resize(int new_width_px, int new_height_px, int new_channels) {
  width_px = new_width_px;
  height_px = new_height_px;
  channels = new_channels;
  pixels.resize(static_cast<std::size_t>(channels) * static_cast<std::size_t>(width_px) *
                static_cast<std::size_t>(height_px));
}

void ToGrey(const Image& image, Image& grey) {
  if (image.channels == 1) {
    grey = image;
    return;
  }
  grey.Resize(image.width_px, image.height_px, 1);
  grey.time_ns = image.time_ns;
  if (image.empty()) return;
  cv::Mat out = MatOf(grey);
  cv::cvtColor(MatOf(image), out, cv::COLOR_RGB2GRAY);
}

Image ReadImage(const std::filesystem::path& path) {
  // Read by ourselves: OpenCV would say the same of a file that is not there and one that is
  // broken.
  const std::string bytes = ReadTextFile(path);
  cv::Mat decoded;
  try {
    const cv::Mat raw(1, static_cast<int>(std::min<std::size_t>(bytes.size(), 1U << 30)), CV_8UC1,
                      const_cast<char*>(bytes.data()));
    if (!bytes.empty()) {
      decoded = cv::imdecode(raw, cv::IMREAD_ANYCOLOR | cv::IMREAD_IGNORE_ORIENTATION);
    }
  } catch (const cv::Exception&) {
    decoded.release();
  }
  ACUS_REQUIRE(!decoded.empty() && decoded.depth() == CV_8U &&
                   (decoded.channels() == 1 || decoded.channels() == 3),
               path.string(), ": is not an image that can be read (PNG, JPEG, TIFF, BMP, PNM)");
  ACUS_REQUIRE(decoded.cols <= kLargestPx && decoded.rows <= kLargestPx, path.string(), ": ",
               decoded.cols, " x ", decoded.rows, " pixels; at most ", kLargestPx, " each way");
  Image image;
  image.Resize(decoded.cols, decoded.rows, decoded.channels());
  cv::Mat out = MatOf(image);
  if (decoded.channels() == 3) {
    cv::cvtColor(decoded, out, cv::COLOR_BGR2RGB);
  } else {
    decoded.copyTo(out);
  }
  return image;
}

std::vector<std::filesystem::path> ImageFiles(const std::filesystem::path& folder) {
  static const std::set<std::string> kExtensions = {".png",  ".jpg", ".jpeg", ".tif",
                                                    ".tiff", ".bmp", ".pgm",  ".ppm"};
  ACUS_REQUIRE(std::filesystem::is_directory(folder), folder.string(), ": there is no such folder");
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    std::string extension = entry.path().extension().string();
    for (char& letter : extension) letter = static_cast<char>(std::tolower(letter));
    if (entry.is_regular_file() && kExtensions.contains(extension)) files.push_back(entry.path());
  }
  ACUS_REQUIRE(!files.empty(), folder.string(),
               ": there is no image in it (.png, .jpg, .tif, "
               ".bmp, .pgm, .ppm)");
  std::sort(files.begin(), files.end());
  return files;
}

void WriteImage(const std::filesystem::path& path, const Image& image) {
  ACUS_REQUIRE(!image.empty(), path.string(), ": the image has no pixels");
  cv::Mat bgr = MatOf(image);
  if (image.channels == 3) cv::cvtColor(MatOf(image), bgr = cv::Mat(), cv::COLOR_RGB2BGR);
  AtomicFile file(path);
  bool written = false;
  try {
    written = cv::imwrite(file.path().string(), bgr);
  } catch (const cv::Exception&) {
    written = false;
  }
  ACUS_REQUIRE(written, path.string(),
               ": the image cannot be written; name it .png, .jpg, .ppm or .pgm, and check the "
               "space on the disk");
  file.Commit();
}

}  // namespace acus::camera
