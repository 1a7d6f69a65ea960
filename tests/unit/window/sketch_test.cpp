// What is drawn, as the pieces that a graphics card gets: needs no display.
#include "acus/window/sketch.h"

#include <algorithm>
#include <gtest/gtest.h>
#include <memory>
#include <vector>

#include "acus/window/marks.h"
#include "acus/window/status_bar.h"

namespace acus::window {
namespace {

const FontAtlas& Atlas() {
  static const FontAtlas atlas;
  return atlas;
}

class SketchTest : public testing::Test {
 protected:
  Sketch sketch_{Atlas()};

  SketchTest() { sketch_.Clear(); }

  /// Of all that was drawn: least and greatest x and y.
  Eigen::Array4d Extent(std::size_t from_vertex = 0) const {
    Eigen::Array4d out(1e9, -1e9, 1e9, -1e9);
    for (std::size_t i = from_vertex; i < sketch_.vertices().size(); ++i) {
      const Sketch::Vertex& v = sketch_.vertices()[i];
      out = {std::min<double>(out[0], v.x), std::max<double>(out[1], v.x),
             std::min<double>(out[2], v.y), std::max<double>(out[3], v.y)};
    }
    return out;
  }
  void ExpectWithin(const Rectangle& place, std::size_t from_vertex = 0) const {
    const Eigen::Array4d extent = Extent(from_vertex);
    EXPECT_GE(extent[0], place.left);
    EXPECT_LE(extent[1], place.left + place.width);
    EXPECT_GE(extent[2], place.top);
    EXPECT_LE(extent[3], place.top + place.height);
  }
};

TEST_F(SketchTest, ALineIsFullInItsMiddleAndFadesToBothSides) {
  const FontAtlas::Strip& line = Atlas().line();
  for (int row = line.row; row < line.row + 4; ++row) {
    const auto* opacity = Atlas().opacity().data() + row * Atlas().width() + line.column;
    EXPECT_EQ(opacity[0], 0);
    for (int i = 1; i < line.width - 1; ++i) EXPECT_EQ(opacity[i], 255) << row << " " << i;
    EXPECT_EQ(opacity[line.width - 1], 0);
  }
}

TEST_F(SketchTest, NothingIsCutOffAtTheEdgeOfTheWindow) {
  sketch_.Line({0, 10}, {40, 10}, 1.0, palette::kText);
  sketch_.Line({10, 0}, {10, 40}, 1.0, palette::kText);
  const Eigen::Array4d extent = Extent();
  EXPECT_EQ(extent[0], 0.0);
  EXPECT_EQ(extent[2], 0.0);
}

TEST_F(SketchTest, DashesCoverAShareOfTheirWayFromEndToEnd) {
  // Along (3, 4) / 5, for 200 px.
  sketch_.Dashes({50, 60}, {170, 220}, 2.0, palette::kText);
  double drawn_px = 0.0;
  const std::vector<Sketch::Vertex>& at = sketch_.vertices();
  for (std::size_t i = 0; i + 3 < at.size(); i += 4) {
    drawn_px += std::hypot(at[i + 2].x - at[i + 1].x, at[i + 2].y - at[i + 1].y);
  }
  EXPECT_NEAR(drawn_px, 200.0 * 6.0 / 11.0, 6.0);
  const Eigen::Array4d extent = Extent();
  EXPECT_NEAR(extent[0], 50.0, 2.0);
  EXPECT_NEAR(extent[1], 170.0, 11.0);
  EXPECT_NEAR(extent[2], 60.0, 2.0);
  EXPECT_NEAR(extent[3], 220.0, 11.0);
}

TEST_F(SketchTest, HelpStaysWithinASmallWindow) {
  const Rectangle window{.left = 0, .top = 0, .width = 400, .height = 220};
  DrawHelp(window, SizesFor(window.height), sketch_);
  ASSERT_FALSE(sketch_.vertices().empty());
  ExpectWithin(window);
}

/// An image of 100 x 100 px and 50 x 50 mm, in a place of 300 px.
class MarksTest : public SketchTest {
 protected:
  PlaneOnScreen plane_;
  DisplayFrame frame_;

  MarksTest() {
    plane_.geometry.width_px = plane_.geometry.height_px = 100;
    plane_.geometry.lateral_mm_per_px = plane_.geometry.axial_mm_per_px = 0.5;
    plane_.place = {.left = 20, .top = 30, .width = 300, .height = 300};
    frame_.ct_from_probe = plane_.ct_from_probe;
    frame_.ultrasound.probe = std::make_shared<acoustics::Probe>();
  }
  std::vector<Sketch::Vertex> Drawn() {
    const Rectangle view{.left = 0, .top = 0, .width = 340, .height = 360};
    sketch_.Clear();
    DrawUltrasoundMarks(frame_, view, plane_, {}, sketch_, SizesFor(800));
    return sketch_.vertices();
  }
};

TEST_F(MarksTest, ATargetOffThePlaneIsNamedWithinTheImage) {
  for (const double lateral_mm : {-22.0, -10.0, 10.0, 22.0}) {
    frame_.target_in_ct_mm.reset();
    const std::size_t others = Drawn().size();
    frame_.target_in_ct_mm = Eigen::Vector3d(lateral_mm, 20.0, 12.0);
    Drawn();
    // Ring and letters of the target have its colour.
    int letters = 0;
    for (const Sketch::Vertex& v : sketch_.vertices()) {
      if (v.colour.red != palette::kTarget.red || v.colour.blue != palette::kTarget.blue) continue;
      ++letters;
      EXPECT_GE(v.x, plane_.place.left) << lateral_mm;
      EXPECT_LE(v.x, plane_.place.left + plane_.place.width) << lateral_mm;
    }
    EXPECT_GT(letters, 4 * 10);
    EXPECT_GT(sketch_.vertices().size(), others);
  }
}

TEST_F(MarksTest, TheTipOfABentNeedleIsTheFirstPointOfItsShape) {
  frame_.needle.emplace();
  frame_.needle->tip_in_ct_mm = {0.0, 10.0, 0.0};
  frame_.needle->shape.Add({5.0, 30.0, 0.0});
  frame_.needle->shape.Add({5.0, -20.0, 0.0});
  DrawSliceMarks(frame_, plane_, SizesFor(800), sketch_);
  const Eigen::Vector3d tip = plane_.At({5.0, 30.0, 0.0});
  const Eigen::Array4d extent = Extent();
  EXPECT_NEAR(0.5 * (extent[0] + extent[1]), tip[0], 0.5);
  EXPECT_NEAR(0.5 * (extent[2] + extent[3]), tip[1], 0.5);
}

TEST_F(MarksTest, MarksGrowWithTheWindowAsItsTextDoes) {
  frame_.needle.reset();
  frame_.target_in_ct_mm = Eigen::Vector3d(0.0, 20.0, 0.0);
  const auto width = [&](int window_height_px) {
    sketch_.Clear();
    DrawSliceMarks(frame_, plane_, SizesFor(window_height_px), sketch_);
    const Eigen::Array4d extent = Extent();
    return extent[1] - extent[0];
  };
  constexpr double kRimPx = 2.0;  // Of a line's smooth edges, in windows of every size.
  EXPECT_NEAR(width(2160) - kRimPx, 2.7 * (width(800) - kRimPx), 1.0);
  EXPECT_EQ(Scaled(14, SizesFor(800)), 14);
  EXPECT_EQ(Scaled(14, SizesFor(2160)), 38);
}

}  // namespace
}  // namespace acus::window
