#include "acus/assess/regression/comparison/compare_images.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "acus/assess/regression/comparison/image_difference.h"
#include "acus/base/core/error.h"
#include "acus/base/core/parallel.h"
#include "acus/data/session/sequence_file.h"

namespace acus::comparison {
namespace {

constexpr std::size_t kBatch = 16;  ///< Frames in memory at a time, of each run.
constexpr int kGapPx = 8;

void RequireGray(const session::SequenceFile& file, const std::filesystem::path& path) {
  const session::SequenceHeader& header = file.header();
  ACUS_REQUIRE(!file.has_images() ||
                   (header.pixel_type == session::PixelType::kUint8 && header.channels == 1),
               path.string(), ": its images are not grey with 8 bits; only those are compared");
}

GrayView View(const session::SequenceHeader& header, const std::vector<std::uint8_t>& pixels) {
  return {static_cast<int>(header.width), static_cast<int>(header.height), pixels};
}

std::string SizeText(const session::SequenceHeader& header) {
  return Message(header.width, " x ", header.height);
}

FrameDifference DifferenceOf(const GrayView& a, const GrayView& b) {
  FrameDifference difference;
  difference.psnr_db = PsnrDb(MeanSquaredError(a, b));
  difference.ssim = Ssim(a, b);
  return difference;
}

/// Times of a frame in both runs, if both have one.
std::optional<std::pair<double, double>> TimesS(const session::SequenceFile& a,
                                                const session::SequenceFile& b, std::size_t frame) {
  const auto a_ns = a.TimeNs(frame);
  const auto b_ns = b.TimeNs(frame);
  if (!a_ns || !b_ns) return std::nullopt;
  return std::pair(1e-9 * static_cast<double>(*a_ns), 1e-9 * static_cast<double>(*b_ns));
}

void CompareFrames(session::SequenceFile& a, session::SequenceFile& b, std::size_t count,
                   const RunContext& context, std::vector<FrameDifference>& frames) {
  frames.resize(count);
  std::vector<std::vector<std::uint8_t>> in_a(kBatch);
  std::vector<std::vector<std::uint8_t>> in_b(kBatch);
  for (std::size_t first = 0; first < count; first += kBatch) {
    context.Checkpoint("images", static_cast<double>(first) / static_cast<double>(count));
    const std::size_t batch = std::min(kBatch, count - first);
    for (std::size_t k = 0; k < batch; ++k) {
      in_a[k] = a.ReadImage(first + k);
      in_b[k] = b.ReadImage(first + k);
    }
    ParallelFor(static_cast<int>(batch), context.num_threads, [&](int k) {
      const auto i = static_cast<std::size_t>(k);
      frames[first + i] = DifferenceOf(View(a.header(), in_a[i]), View(b.header(), in_b[i]));
    });
  }
}

void AddVerdicts(const ImageTolerances& tolerances, ImageComparison& result) {
  std::optional<std::size_t> lowest_psnr;
  for (std::size_t i = 0; i < result.frames.size(); ++i) {
    const FrameDifference& frame = result.frames[i];
    if (!result.worst || frame.ssim < result.frames[*result.worst].ssim) result.worst = i;
    if (!frame.psnr_db) {
      ++result.num_identical;
    } else if (!lowest_psnr || *frame.psnr_db < *result.frames[*lowest_psnr].psnr_db) {
      lowest_psnr = i;
    }
  }
  const auto where = [&](std::size_t i) {
    return Message("frame ", i, " at ", result.frames[i].time_s, " s");
  };
  Check psnr{"images: smallest PSNR", "dB", {}, tolerances.psnr_min_db, true, true,
             "all identical"};
  if (lowest_psnr) {
    psnr.value = *result.frames[*lowest_psnr].psnr_db;
    psnr.passed = *psnr.value >= tolerances.psnr_min_db;
    psnr.remark = where(*lowest_psnr);
  }
  result.checks.push_back(psnr);
  const double ssim = result.frames[*result.worst].ssim;
  result.checks.push_back({"images: smallest SSIM", "", ssim, tolerances.ssim_min, true,
                           ssim >= tolerances.ssim_min, lowest_psnr ? where(*result.worst) : ""});
}

}  // namespace

ImageComparison CompareImages(const std::filesystem::path& a, const std::filesystem::path& b,
                              const ImageTolerances& tolerances, const RunContext& context) {
  session::SequenceFile file_a(a);
  session::SequenceFile file_b(b);
  RequireGray(file_a, a);
  RequireGray(file_b, b);
  ImageComparison result;
  result.checks.push_back(Verdict("images: number", file_a.num_frames() == file_b.num_frames(),
                                  Message(file_a.num_frames(), " | ", file_b.num_frames())));
  const bool same_size = file_a.header().width == file_b.header().width &&
                         file_a.header().height == file_b.header().height;
  result.checks.push_back(Verdict("images: size", same_size,
                                  SizeText(file_a.header()) + " | " + SizeText(file_b.header())));
  const std::size_t count = std::min(file_a.num_frames(), file_b.num_frames());
  if (!same_size || count == 0 || !file_a.has_images()) return result;
  CompareFrames(file_a, file_b, count, context, result.frames);
  double latest_s = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    const auto times_s = TimesS(file_a, file_b, i);
    result.frames[i].time_s = times_s ? times_s->first : static_cast<double>(i);
    if (times_s) latest_s = std::max(latest_s, std::abs(times_s->first - times_s->second));
  }
  result.checks.push_back(AtMost("images: time", "s", latest_s, tolerances.time_max_s));
  AddVerdicts(tolerances, result);
  return result;
}

SideBySide ShowFrame(const std::filesystem::path& a, const std::filesystem::path& b,
                     std::size_t frame) {
  session::SequenceFile file_a(a);
  session::SequenceFile file_b(b);
  const auto in_a = file_a.ReadImage(frame);
  const auto in_b = file_b.ReadImage(frame);
  ACUS_ASSERT(in_a.size() == in_b.size());
  const std::size_t width = file_a.header().width;
  const std::size_t height = file_a.header().height;
  SideBySide image;
  for (std::size_t i = 0; i < in_a.size(); ++i) {
    image.largest_difference =
        std::max(image.largest_difference, std::abs(int{in_a[i]} - int{in_b[i]}));
  }
  const std::size_t stride = width + kGapPx;
  image.width = static_cast<int>(3 * width + 2 * kGapPx);
  image.height = static_cast<int>(height);
  image.pixels.assign(static_cast<std::size_t>(image.width) * height, 255);
  const int stretch = std::max(image.largest_difference, 1);
  for (std::size_t i = 0; i < in_a.size(); ++i) {
    const std::size_t at = i / width * static_cast<std::size_t>(image.width) + i % width;
    image.pixels[at] = in_a[i];
    image.pixels[at + stride] = in_b[i];
    const int difference = std::abs(int{in_a[i]} - int{in_b[i]});
    image.pixels[at + 2 * stride] = static_cast<std::uint8_t>(difference * 255 / stretch);
  }
  return image;
}

}  // namespace acus::comparison
