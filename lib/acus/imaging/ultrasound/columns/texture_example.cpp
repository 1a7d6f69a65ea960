#include "acus/imaging/ultrasound/columns/texture_example.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "acus/base/core/error.h"
#include "acus/base/math/distributions.h"
#include "acus/data/image/png_reader.h"

namespace acus::ultrasound {
namespace {

constexpr int kLeastPixels = 32;
constexpr int kLengthsInExample = 16;
constexpr double kReach = 4.0;  // Standard deviations; beyond it the darkest and brightest grey.

/// Lag, in pixels, at which the correlation along columns (`along`) or rows falls to 1/e; the
/// longest that counts if it does not.
double CorrelationPixels(const image::GrayImage& image, double mean, double variance, bool along) {
  const int size = along ? image.width : image.height;
  const int longest = size / kLengthsInExample + 1;
  double before = 1.0;
  for (int lag = 1; lag <= longest; ++lag) {
    double sum = 0.0;
    int count = 0;
    for (int row = 0; row < image.height - (along ? 0 : lag); ++row) {
      for (int column = 0; column < image.width - (along ? lag : 0); ++column, ++count) {
        const int other = along ? image.At(column + lag, row) : image.At(column, row + lag);
        sum += (image.At(column, row) - mean) * (other - mean);
      }
    }
    const double now = sum / count / variance;
    if (now < 1.0 / std::numbers::e) {
      return lag - 1 + (before - 1.0 / std::numbers::e) / (before - now);
    }
    before = now;
  }
  return longest;
}

/// Within 0 to `size`: a place of the line that is laid back and forth over it.
float Mirrored(float place, float size) {
  const float turn = place - 2.0F * size * std::floor(place / (2.0F * size));
  return std::clamp(turn > size ? 2.0F * size - turn : turn, 0.0F, size);
}

}  // namespace

TextureExample TextureExample::Read(const std::filesystem::path& path, double mm_per_px) {
  return {image::ReadGreyPng(path), mm_per_px, path.string()};
}

TextureExample::TextureExample(const image::GrayImage& image, double mm_per_px,
                               const std::string& label)
    : width_(image.width),
      height_(image.height),
      mm_per_px_(mm_per_px),
      px_per_mm_(static_cast<float>(1.0 / mm_per_px)) {
  ACUS_REQUIRE(mm_per_px > 0.0 && std::isfinite(mm_per_px), label, ": a pixel of ", mm_per_px,
               " mm; it must be above 0");
  ACUS_REQUIRE(width_ >= kLeastPixels && height_ >= kLeastPixels, label, ": is ", width_, " x ",
               height_, " pixels; an example has at least ", kLeastPixels, " along and across");
  SetGreys(image, label);
  const double mean = 255.0 * mean_;
  const double variance = 255.0 * 255.0 * deviation_ * deviation_;
  const double along = CorrelationPixels(image, mean, variance, true);
  const double across = CorrelationPixels(image, mean, variance, false);
  KeepVariance();
  ACUS_REQUIRE(along * kLengthsInExample <= width_ && across * kLengthsInExample <= height_, label,
               ": its pattern hangs together over ", along, " x ", across, " of ", width_, " x ",
               height_, " pixels; an example must be ", kLengthsInExample,
               " times as large: take a larger one, without gradients of depth or gain");
  along_mm_ = along * mm_per_px;
  across_mm_ = across * mm_per_px;
}

/// The histogram and its two transforms. A grey that many pixels have is spread evenly over its
/// step of 1/255.
void TextureExample::SetGreys(const image::GrayImage& image, const std::string& label) {
  std::array<double, 256> count{};
  for (const std::uint8_t pixel : image.pixels) count[pixel] += 1.0;
  const double all = static_cast<double>(image.pixels.size());
  double squares = 0.0;
  std::array<double, 257> below{};
  for (std::size_t g = 0; g < 256; ++g) {
    const double grey = static_cast<double>(g) / 255.0;
    below[g + 1] = below[g] + count[g] / all;
    mean_ += grey * count[g] / all;
    squares += grey * grey * count[g] / all;
  }
  deviation_ = std::sqrt(std::max(0.0, squares - mean_ * mean_));
  ACUS_REQUIRE(deviation_ > 0.5 / 255.0, label, ": has hardly more than one grey, ",
               std::lround(255.0 * mean_), " of 255; a texture needs several");

  std::array<float, 256> gaussian{};
  double mean = 0.0;
  double variance = 0.0;
  for (std::size_t g = 0; g < 256; ++g) {
    if (count[g] == 0.0) continue;
    const double z = math::NormalQuantile(0.5 * (below[g] + below[g + 1]));
    gaussian[g] = static_cast<float>(z);
    mean += z * count[g] / all;
    variance += z * z * count[g] / all;
  }
  const double scale = 1.0 / std::sqrt(variance - mean * mean);
  gaussian_.reserve(image.pixels.size());
  for (const std::uint8_t pixel : image.pixels) {
    gaussian_.push_back(static_cast<float>((gaussian[pixel] - mean) * scale));
  }
  std::size_t g = 0;
  for (int i = 0; i <= kSteps; ++i) {
    const double z = kReach * (2.0 * i / kSteps - 1.0);
    const double share = 0.5 * std::erfc(-z / std::numbers::sqrt2);
    while (g < 255 && below[g + 1] <= share) ++g;
    const double part =
        count[g] > 0.0 ? std::clamp((share - below[g]) * all / count[g], 0.0, 1.0) : 0.5;
    grey_of_[static_cast<std::size_t>(i)] =
        static_cast<float>(std::clamp((static_cast<double>(g) + part - 0.5) / 255.0, 0.0, 1.0));
  }
  grey_of_[kSteps + 1] = grey_of_[kSteps];
}

/// Interpolation between pixels takes variance: on average (2 + c) / 3 along each axis remains, c
/// the correlation of adjacent pixels. The field is made larger by as much.
void TextureExample::KeepVariance() {
  double along = 0.0;
  double across = 0.0;
  for (std::size_t i = 0; i < gaussian_.size(); ++i) {
    const std::size_t column = i % static_cast<std::size_t>(width_);
    const std::size_t below = i + static_cast<std::size_t>(width_);
    const double here = gaussian_[i];
    if (column + 1 < static_cast<std::size_t>(width_)) along += here * gaussian_[i + 1];
    if (below < gaussian_.size()) across += here * gaussian_[below];
  }
  along /= (width_ - 1.0) * height_;
  across /= (height_ - 1.0) * width_;
  const auto scale = static_cast<float>(3.0 / std::sqrt((2.0 + along) * (2.0 + across)));
  for (float& value : gaussian_) value *= scale;
}

float TextureExample::GaussianAt(float along_mm, float across_mm) const noexcept {
  const float x = Mirrored(along_mm * px_per_mm_, static_cast<float>(width_ - 1));
  const float y = Mirrored(across_mm * px_per_mm_, static_cast<float>(height_ - 1));
  const int column = std::min(static_cast<int>(x), width_ - 2);
  const int row = std::min(static_cast<int>(y), height_ - 2);
  const float u = x - static_cast<float>(column);
  const float v = y - static_cast<float>(row);
  const float* upper = gaussian_.data() + static_cast<std::ptrdiff_t>(row) * width_ + column;
  const float* lower = upper + width_;
  return (1.0F - v) * ((1.0F - u) * upper[0] + u * upper[1]) +
         v * ((1.0F - u) * lower[0] + u * lower[1]);
}

float TextureExample::GreyOf(float gaussian) const noexcept {
  constexpr float kReachF = static_cast<float>(kReach);
  const float place =
      (std::clamp(gaussian, -kReachF, kReachF) + kReachF) * (kSteps / (2 * kReachF));
  const int step = static_cast<int>(place);
  const float part = place - static_cast<float>(step);
  return (1.0F - part) * grey_of_[static_cast<std::size_t>(step)] +
         part * grey_of_[static_cast<std::size_t>(step) + 1];
}

}  // namespace acus::ultrasound
