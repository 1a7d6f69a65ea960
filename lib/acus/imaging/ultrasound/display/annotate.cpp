#include "acus/imaging/ultrasound/display/annotate.h"

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <string>

#include "acus/base/core/error.h"

namespace acus::ultrasound {
namespace {

constexpr int kFont = cv::FONT_HERSHEY_SIMPLEX;
constexpr double kFontScale = 0.42;
constexpr int kLetterHeight = 10;
constexpr int kEdge = 6;  ///< Pixels between text and the border of a panel.

cv::Mat MatOf(image::GrayImage& image) {
  return {image.height, image.width, CV_8UC1, image.pixels.data()};
}

void CopyPanel(const image::GrayImage& from, int panel, image::GrayImage& to) {
  for (int r = 0; r < from.height; ++r) {
    const auto* row = from.pixels.data() + static_cast<std::ptrdiff_t>(r) * from.width;
    std::copy_n(row, from.width,
                to.pixels.data() + static_cast<std::ptrdiff_t>(r) * to.width +
                    static_cast<std::ptrdiff_t>(panel) * from.width);
  }
}

}  // namespace

void DrawText(image::GrayImage& image, int column, int row, std::string_view text,
              std::uint8_t grey, double scale) {
  const cv::Point baseline(column, row + static_cast<int>(std::lround(kLetterHeight * scale)));
  cv::putText(MatOf(image), std::string(text), baseline, kFont, kFontScale * scale,
              cv::Scalar(grey), 1, cv::LINE_AA);
}

Screen::Screen(const acoustics::Probe& probe, Shows shows)
    : image_(acoustics::ImageOf(probe)), shows_(shows) {
  DrawMarks(probe);
}

void Screen::DrawMarks(const acoustics::Probe& probe) {
  image::GrayImage marks;
  marks.Resize(width_px(), height_px());
  const cv::Mat view = MatOf(marks);
  const auto row_of = [&](double depth_mm) {
    return static_cast<int>(
        std::lround((depth_mm - image_.depth_of_top_row_mm) / image_.axial_mm_per_px));
  };
  const double tick_mm = probe.depth_mm > 100.0 ? 10.0 : 5.0;
  // The last tick whose label fits in, which also says the unit.
  int last = static_cast<int>(probe.depth_mm / tick_mm + 1e-9) / 2 * 2;
  while (last > 0 && row_of(last * tick_mm) + kLetterHeight > image_.height_px) last -= 2;
  for (int panel = 0; panel < panels(); ++panel) {
    const int left = panel * image_.width_px;
    for (int n = 0; n * tick_mm <= probe.depth_mm + 1e-9; ++n) {
      const int row = row_of(n * tick_mm);
      const bool labelled = n % 2 == 0;
      cv::line(view, {left, row}, {left + (labelled ? 8 : 4), row}, cv::Scalar(200), 1);
      if (!labelled || n == 0 || n > last) continue;
      DrawText(marks, left + 11, row - kLetterHeight / 2,
               Message(std::lround(0.1 * n * tick_mm), n == last ? " cm" : ""), 200, 0.85);
    }
    const int right = left + image_.width_px - 1;
    cv::circle(view, {right - 2 * kEdge, 2 * kEdge}, 5, cv::Scalar(230), 1, cv::LINE_AA);
    const char* name = panel == 0 && shows_ != Shows::kCtSlice ? "B-mode" : "CT";
    const int width = cv::getTextSize(name, kFont, kFontScale, 1, nullptr).width;
    DrawText(marks, right - 4 * kEdge - width, kEdge, name, 200);
  }
  const bool has_b_mode = shows_ != Shows::kCtSlice;
  if (has_b_mode && probe.focus_mm > 0.0 && probe.focus_mm <= probe.depth_mm) {
    const int row = row_of(probe.focus_mm);
    // Beside the scale, which it points to.
    const cv::Point triangle[] = {{38, row - 5}, {38, row + 5}, {30, row}};
    cv::fillConvexPoly(view, triangle, 3, cv::Scalar(200));
  }
  std::string about = Message(probe.name, "  ", 0.1 * probe.depth_mm, " cm");
  if (has_b_mode) {
    about += Message("  ", probe.frequency_mhz, " MHz  gain ", probe.gain_db, "  DR ",
                     probe.dynamic_range_db, " dB", probe.second_harmonic ? "  harmonic" : "");
  }
  DrawText(marks, 52, image_.height_px - kLetterHeight - kEdge, about, 160, 0.85);
  for (std::size_t n = 0; n < marks.pixels.size(); ++n) {
    if (marks.pixels[n] != 0) marks_.emplace_back(n, marks.pixels[n]);
  }
}

void Screen::Compose(const image::GrayImage& left, const image::GrayImage* ct_slice,
                     std::string_view text, image::GrayImage& out) const {
  const auto require_size = [&](const image::GrayImage& image, const char* what) {
    ACUS_REQUIRE(image.width == image_.width_px && image.height == image_.height_px, "screen: the ",
                 what, " is ", image.width, " x ", image.height,
                 " pixels, but the probe's image is ", image_.width_px, " x ", image_.height_px);
  };
  ACUS_REQUIRE((ct_slice != nullptr) == (shows_ == Shows::kBoth), "screen: ",
               ct_slice != nullptr ? "has no panel for a CT slice" : "needs a CT slice");
  require_size(left, "image");
  out.Resize(width_px(), height_px());
  CopyPanel(left, 0, out);
  if (ct_slice != nullptr) {
    require_size(*ct_slice, "CT slice");
    CopyPanel(*ct_slice, 1, out);
  }
  // The brighter of mark and image: marks stay readable and soft-edged on any ground.
  for (const auto& [pixel, grey] : marks_) out.pixels[pixel] = std::max(out.pixels[pixel], grey);
  if (!text.empty()) DrawText(out, 44, kEdge, text);
}

}  // namespace acus::ultrasound
