#include "acus/imaging/ultrasound/display/compound_image.h"

#include <algorithm>
#include <array>

#include "acus/base/core/parallel.h"

namespace acus::ultrasound {
namespace {

constexpr int kRowsPerPieceOfCompound = 32;
constexpr int kMostLooks = 16;

/// 2^16 over the number of images, rounded up: exact for sums of up to 255 * 15.
constexpr std::array<std::uint32_t, kMostLooks> Reciprocals() {
  std::array<std::uint32_t, kMostLooks> out{};
  for (std::uint32_t n = 1; n < kMostLooks; ++n) out[n] = (65536 + n - 1) / n;
  return out;
}
constexpr auto kReciprocals = Reciprocals();

}  // namespace

CompoundImage::CompoundImage(std::vector<BeamDisplay*> looks) : looks_(std::move(looks)) {
  const image::ImageGeometry& image = looks_.front()->image();
  look_.Resize(image.width_px, image.height_px);
  sum_.resize(look_.pixels.size());
  for (int r = 0; r < image.height_px; ++r) {
    for (int c = 0; c < image.width_px; ++c) {
      int count = 0;
      for (const BeamDisplay* look : looks_) count += look->Covers(r, c) ? 1 : 0;
      count_.push_back(static_cast<std::uint8_t>(looks_.front()->Covers(r, c) ? count : 0));
    }
  }
}

void CompoundImage::ShowRow(int r, image::GrayImage& out) {
  const auto width = static_cast<std::size_t>(out.width);
  const std::size_t first = static_cast<std::size_t>(r) * width;
  std::uint16_t* sum = sum_.data() + first;
  std::fill_n(sum, width, std::uint16_t{0});
  for (const BeamDisplay* look : looks_) {
    look->Convert(r, r + 1, look_);
    const std::uint8_t* grey = look_.pixels.data() + first;
    for (std::size_t c = 0; c < width; ++c) sum[c] = static_cast<std::uint16_t>(sum[c] + grey[c]);
  }
  std::uint8_t* pixels = out.pixels.data() + first;
  for (std::size_t c = 0; c < width; ++c) {
    const std::uint32_t count = count_[first + c];
    pixels[c] = static_cast<std::uint8_t>((sum[c] + count / 2) * kReciprocals[count] >> 16);
  }
  looks_.front()->Blend(r, pixels);
}

void CompoundImage::Show(image::GrayImage& out, int num_threads) {
  for (BeamDisplay* look : looks_) look->Enhance(num_threads);
  out.Resize(look_.width, look_.height);
  ParallelFor((out.height + kRowsPerPieceOfCompound - 1) / kRowsPerPieceOfCompound, num_threads,
              [this, &out](int piece) {
                const int first = piece * kRowsPerPieceOfCompound;
                const int last = std::min(out.height, first + kRowsPerPieceOfCompound);
                for (int r = first; r < last; ++r) ShowRow(r, out);
              });
}

}  // namespace acus::ultrasound
