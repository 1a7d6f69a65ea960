#include "acus/imaging/ultrasound/display/annotate.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <string>

#include "acus/base/core/error.h"
#include "acus/imaging/acoustics/field_of_view.h"

namespace acus::ultrasound {
namespace {

constexpr int kFont = cv::FONT_HERSHEY_SIMPLEX;
constexpr double kFontScale = 0.42;
constexpr int kLetterHeight = 10;
constexpr int kEdge = 6;  ///< Pixels between text and the border of a panel.

cv::Mat MatOf(image::GrayImage& image) {
  return {image.height, image.width, CV_8UC1, image.pixels.data()};
}

/// Hatching of what lies beyond the CT.
constexpr int kHatchPx = 8;
constexpr std::uint8_t kHatchGrey = 70;

}  // namespace

void DrawText(image::GrayImage& image, int column, int row, std::string_view text,
              std::uint8_t grey, double scale) {
  const cv::Point baseline(column, row + static_cast<int>(std::lround(kLetterHeight * scale)));
  cv::putText(MatOf(image), std::string(text), baseline, kFont, kFontScale * scale,
              cv::Scalar(grey), 1, cv::LINE_AA);
}

Screen::Screen(const acoustics::Probe& probe, Shows shows)
    : image_(acoustics::ImageOf(probe)), shows_(shows) {
  FindSector(probe);
  DrawMarks(probe);
}

void Screen::FindSector(const acoustics::Probe& probe) {
  const double last = (probe.depth_mm - image_.depth_of_top_row_mm) / image_.axial_mm_per_px;
  rows_ = std::clamp(static_cast<int>(std::ceil(last)) + 2, 1, image_.height_px);
  // Videos have an even height.
  if (rows_ < image_.height_px) rows_ += rows_ % 2;
  for (int r = 0; r < rows_; ++r) {
    Span span{.first = image_.width_px, .last = 0};
    for (int c = 0; c < image_.width_px; ++c) {
      const Eigen::Vector3d place = image_.probe_from_image() * Eigen::Vector3d(c, r, 0.0);
      if (!acoustics::IsInFieldOfView(probe, place.head<2>())) continue;
      span.first = std::min(span.first, c);
      span.last = c + 1;
    }
    sector_.push_back(span);
  }
}

void Screen::DrawScale(const acoustics::Probe& probe, int left, bool focus,
                       image::GrayImage& marks) const {
  const cv::Mat view = MatOf(marks);
  const auto row_of = [&](double depth_mm) {
    return kTextPx + static_cast<int>(std::lround((depth_mm - image_.depth_of_top_row_mm) /
                                                  image_.axial_mm_per_px));
  };
  const double tick_mm = probe.depth_mm > 100.0 ? 10.0 : 5.0;
  for (int n = 0; n * tick_mm <= probe.depth_mm + 1e-9; ++n) {
    const int row = row_of(n * tick_mm);
    const bool labelled = n % 2 == 0;
    cv::line(view, {left - (labelled ? 9 : 5), row}, {left - 2, row}, cv::Scalar(200), 1);
    if (!labelled) continue;
    const std::string label = Message(std::lround(0.1 * n * tick_mm));
    const int width = cv::getTextSize(label, kFont, 0.85 * kFontScale, 1, nullptr).width;
    DrawText(marks, left - 14 - width, row - kLetterHeight / 2, label, 200, 0.85);
  }
  DrawText(marks, left - 26, kTextPx + rows_ + kEdge, "cm", 160, 0.85);
  if (!focus || probe.focus_mm <= 0.0 || probe.focus_mm > probe.depth_mm) return;
  const int row = row_of(probe.focus_mm);
  const cv::Point triangle[] = {{left - 10, row - 5}, {left - 10, row + 5}, {left - 2, row}};
  cv::fillConvexPoly(view, triangle, 3, cv::Scalar(230));
}

void Screen::DrawMarks(const acoustics::Probe& probe) {
  image::GrayImage marks;
  marks.Resize(width_px(), height_px());
  const cv::Mat view = MatOf(marks);
  for (int panel = 0; panel < panels(); ++panel) {
    const int left = LeftOf(panel);
    DrawScale(probe, left, IsBMode(panel), marks);
    const int right = left + image_.width_px - 1;
    cv::circle(view, {right - 2 * kEdge, kTextPx / 2}, 5, cv::Scalar(230), 1, cv::LINE_AA);
    const char* name = IsBMode(panel) ? "B-mode" : "CT";
    const int width = cv::getTextSize(name, kFont, kFontScale, 1, nullptr).width;
    DrawText(marks, right - 4 * kEdge - width, kEdge, name, 200);
  }
  std::string about = Message(probe.name, "  ", 0.1 * probe.depth_mm, " cm");
  if (IsBMode(0)) {
    about += Message("  ", probe.frequency_mhz, " MHz  gain ", probe.gain_db, "  DR ",
                     probe.dynamic_range_db, " dB", probe.second_harmonic ? "  harmonic" : "");
  }
  DrawText(marks, kScalePx, kTextPx + rows_ + kEdge, about, 160, 0.85);
  for (std::size_t n = 0; n < marks.pixels.size(); ++n) {
    if (marks.pixels[n] != 0) marks_.emplace_back(n, marks.pixels[n]);
  }
}

void Screen::CopyPanel(const image::GrayImage& from, int panel, image::GrayImage& to) const {
  for (int r = 0; r < rows_; ++r) {
    const auto* row = from.pixels.data() + static_cast<std::ptrdiff_t>(r) * from.width;
    std::copy_n(
        row, from.width,
        to.pixels.data() + static_cast<std::ptrdiff_t>(kTextPx + r) * to.width + LeftOf(panel));
  }
}

Screen::Span Screen::InScan(const ScanExtent& scan, int row) const {
  const Eigen::Affine3d from_image = scan.index_from_probe * image_.probe_from_image();
  const Eigen::Array3d start = (from_image * Eigen::Vector3d(0.0, row, 0.0)).array();
  const Eigen::Array3d step = from_image.linear().col(0).array();
  double first = 0.0;
  double last = image_.width_px - 1.0;
  for (int a = 0; a < 3; ++a) {
    const double edge = scan.size[a] - 0.5;
    if (std::abs(step[a]) < 1e-9) {
      if (start[a] < -0.5 || start[a] > edge) return {};
      continue;
    }
    const double one = (-0.5 - start[a]) / step[a];
    const double other = (edge - start[a]) / step[a];
    first = std::max(first, std::min(one, other));
    last = std::min(last, std::max(one, other));
  }
  if (!(first <= last)) return {};
  return {static_cast<int>(std::ceil(first)), static_cast<int>(std::floor(last)) + 1};
}

void Screen::Hatch(const ScanExtent& scan, int panel, image::GrayImage& out) const {
  for (int r = 0; r < rows_; ++r) {
    const Span shown =
        IsBMode(panel) ? sector_[static_cast<std::size_t>(r)] : Span{0, image_.width_px};
    const Span inside = InScan(scan, r);
    std::uint8_t* row =
        out.pixels.data() + static_cast<std::ptrdiff_t>(kTextPx + r) * out.width + LeftOf(panel);
    for (int c = shown.first; c < shown.last; ++c) {
      if (c >= inside.first && c < inside.last) {
        c = inside.last - 1;
        continue;
      }
      if ((c + r) % kHatchPx == 0) row[c] = kHatchGrey;
    }
  }
}

void Screen::Compose(const image::GrayImage& left, const image::GrayImage* ct_slice,
                     std::string_view text, image::GrayImage& out, const ScanExtent* scan) const {
  const auto require_size = [&](const image::GrayImage& image, const char* what) {
    ACUS_REQUIRE(image.width == image_.width_px && image.height == image_.height_px, "screen: the ",
                 what, " is ", image.width, " x ", image.height,
                 " pixels, but the probe's image is ", image_.width_px, " x ", image_.height_px);
  };
  ACUS_REQUIRE((ct_slice != nullptr) == (shows_ == Shows::kBoth), "screen: ",
               ct_slice != nullptr ? "has no panel for a CT slice" : "needs a CT slice");
  require_size(left, "image");
  if (ct_slice != nullptr) require_size(*ct_slice, "CT slice");
  out.Resize(width_px(), height_px());
  std::fill(out.pixels.begin(), out.pixels.end(), std::uint8_t{0});
  CopyPanel(left, 0, out);
  if (ct_slice != nullptr) CopyPanel(*ct_slice, 1, out);
  for (int panel = 0; scan != nullptr && panel < panels(); ++panel) Hatch(*scan, panel, out);
  for (const auto& [pixel, grey] : marks_) out.pixels[pixel] = grey;
  if (!text.empty()) DrawText(out, kScalePx, kEdge, text);
}

}  // namespace acus::ultrasound
