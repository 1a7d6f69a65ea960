#include "acus/imaging/slicing/ct_slice.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "acus/base/core/error.h"
#include "acus/base/core/parallel.h"
#include "acus/imaging/slicing/kernels.h"
#include "acus/imaging/slicing/needle_paint.h"

namespace acus::slicing {
namespace {

/// Rows per piece of parallel work.
constexpr int kRowsOfPiece = 128;

}  // namespace

CtSliceRenderer::CtSliceRenderer(const volume::CtVolume& ct, const image::ImageGeometry& image,
                                 double slice_thickness_mm, const HuWindow& window)
    : sampler_(ct), image_(image), slice_thickness_mm_(slice_thickness_mm), window_(window) {
  ACUS_REQUIRE(window.width_hu > 0.0 && std::isfinite(window.width_hu + window.centre_hu),
               "CT slice: the window is ", window.width_hu, " HU wide; it must be above 0");
  grid_ = acoustics::ScanGridOf(image);
}

void CtSliceRenderer::Render(const Eigen::Isometry3d& ct_from_probe,
                             const std::optional<image::NeedleInImage>& needle,
                             image::GrayImage& out, int num_threads, const RestMap* rest) {
  sampler_.PlaceLines(grid_, ct_from_probe, lines_);
  bend_.Set(grid_, ct_from_probe, sampler_.index_from_ct(), rest);
  hu_.Resize(grid_.lines(), grid_.samples);
  sampler_.Sample(lines_, bend_, hu_, num_threads);
  if (needle) PaintNeedle(*needle, ct_from_probe, slice_thickness_mm_, grid_, hu_);

  out.Resize(image_.width_px, image_.height_px);
  const auto piece = [&](int p) {
    const int end = std::min(image_.height_px, (p + 1) * kRowsOfPiece);
    for (int r = p * kRowsOfPiece; r < end; ++r) ShowRow(r, out);
  };
  ParallelFor((image_.height_px + kRowsOfPiece - 1) / kRowsOfPiece, num_threads, std::ref(piece));
}

void CtSliceRenderer::ShowRow(int r, image::GrayImage& out) const {
  const auto scale = static_cast<float>(255.0 / window_.width_hu);
  const auto offset = static_cast<float>(127.5 - window_.centre_hu * 255.0 / window_.width_hu);
  // In blocks, since the kernel writes whole blocks and images have any width.
  std::uint8_t* pixels = out.pixels.data() + static_cast<std::ptrdiff_t>(r) * out.width;
  const int whole = out.width / kernels::kBlock * kernels::kBlock;
  kernels::WindowRow(hu_.row(r), offset, scale, whole, pixels);
  if (whole == out.width) return;
  std::array<std::uint8_t, kernels::kBlock> last;
  kernels::WindowRow(hu_.row(r) + whole, offset, scale, kernels::kBlock, last.data());
  std::copy_n(last.data(), out.width - whole, pixels + whole);
}

}  // namespace acus::slicing
