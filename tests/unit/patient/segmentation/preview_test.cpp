#include "acus/patient/segmentation/preview.h"

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include "acus/data/volume/labels.h"
#include "support/temporary_folder.h"

namespace acus::segmentation {
namespace {

/// Pixels of the scale bar: the run of white from column 14 on, in the rows just above the bottom.
int BarPx(const std::filesystem::path& path, int height_px) {
  const cv::Mat image = cv::imread(path.string(), cv::IMREAD_COLOR);
  int length = 0;
  while (image.at<cv::Vec3b>(height_px - 12, 14 + length) == cv::Vec3b(255, 255, 255)) ++length;
  return length;
}

TEST(Preview, TheScaleBarIsARoundLengthThatFits) {
  const testing_support::TemporaryFolder folder;
  const auto path = folder.path() / "preview.png";
  for (const int width_mm : {40, 70, 104, 116, 200, 240, 260, 400}) {
    volume::Geometry g;
    g.size = {width_mm / 4, width_mm / 4, 1};
    g.spacing_mm = {4.0, 4.0, 4.0};
    WritePreview(path, volume::CtVolume(g, std::int16_t{-1000}), volume::LabelMap(g), Plane::kAxial,
                 {0, 0, 0});
    const double px_per_mm = 900.0 / width_mm;
    const double bar_mm = BarPx(path, 900) / px_per_mm;
    const bool round = std::abs(bar_mm - 10.0) < 0.5 || std::abs(bar_mm - 50.0) < 0.5 ||
                       std::abs(bar_mm - 100.0) < 0.5;
    EXPECT_TRUE(round) << bar_mm << " of " << width_mm;
    EXPECT_GT(bar_mm, 0.1 * width_mm) << width_mm;
    EXPECT_LT(bar_mm, 0.5 * width_mm) << width_mm;
  }
}

}  // namespace
}  // namespace acus::segmentation
