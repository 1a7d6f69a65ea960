// States differ in colour for everybody, and in shape without any colour.
#include "acus/window/severity_mark.h"

#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <set>

#include "acus/window/marks.h"

namespace acus::window {
namespace {

using Eigen::Array3d;
using Eigen::Matrix3d;

constexpr std::array kSeverities = {Severity::kGood, Severity::kNote, Severity::kWarning,
                                    Severity::kFault};

Array3d Linear(const Colour& colour) {
  const auto linear = [](double level) {
    const double c = level / 255.0;
    return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
  };
  return {linear(colour.red), linear(colour.green), linear(colour.blue)};
}

/// CIE 1976 L*a*b* of a linear sRGB colour, white point D65.
Array3d LabOf(const Array3d& rgb) {
  Matrix3d xyz_from_rgb;
  xyz_from_rgb << 0.4124, 0.3576, 0.1805, 0.2126, 0.7152, 0.0722, 0.0193, 0.1192, 0.9505;
  const Array3d xyz = (xyz_from_rgb * rgb.matrix()).array() / Array3d(0.95047, 1.0, 1.08883);
  const Array3d f = xyz.unaryExpr(
      [](double t) { return t > 0.008856 ? std::cbrt(t) : 7.787 * t + 16.0 / 116.0; });
  return {116.0 * f[1] - 16.0, 500.0 * (f[0] - f[1]), 200.0 * (f[1] - f[2])};
}

/// Sight without colour blindness, with protanopia, deuteranopia and tritanopia (Machado, Oliveira
/// and Fernandes 2009, severity 1).
std::array<Matrix3d, 4> Sights() {
  std::array<Matrix3d, 4> sights;
  sights[0].setIdentity();
  sights[1] << 0.152286, 1.052583, -0.204868, 0.114503, 0.786281, 0.099216, -0.003882, -0.048116,
      1.051998;
  sights[2] << 0.367322, 0.860646, -0.227968, 0.280085, 0.672501, 0.047413, -0.011820, 0.042940,
      0.968881;
  sights[3] << 1.255528, -0.076749, -0.178779, -0.078411, 0.930809, 0.147602, 0.004733, 0.691367,
      0.303900;
  return sights;
}

double ContrastWithBackground(const Colour& colour) {
  const Array3d weights(0.2126, 0.7152, 0.0722);
  return ((weights * Linear(colour)).sum() + 0.05) /
         ((weights * Linear(palette::kBackground)).sum() + 0.05);
}

TEST(SeverityMark, ColoursDifferForEverybody) {
  constexpr double kLeastDistance = 30.0;  // A just noticeable difference is about 2.3.
  for (const Matrix3d& sight : Sights()) {
    const auto seen = [&](Severity severity) {
      return LabOf((sight * Linear(ColourOf(severity)).matrix()).array().max(0.0).min(1.0));
    };
    for (const Severity one : kSeverities) {
      for (const Severity other : kSeverities) {
        if (one == other) continue;
        EXPECT_GE((seen(one) - seen(other)).matrix().norm(), kLeastDistance)
            << static_cast<int>(one) << " and " << static_cast<int>(other);
      }
    }
  }
}

TEST(SeverityMark, TextsAreLegibleOnTheBackground) {
  for (const Colour& colour : {palette::kText, palette::kFaint, palette::kGood, palette::kWarning,
                               palette::kFault, palette::kNeedle, palette::kTarget}) {
    EXPECT_GE(ContrastWithBackground(colour), 4.5) << "WCAG 2.1, AA";
  }
}

TEST(SeverityMark, EachStateHasItsOwnShape) {
  const FontAtlas atlas;
  std::set<std::vector<float>> shapes;
  int count = 0;
  const auto add = [&](auto... state) {
    Sketch sketch(atlas);
    DrawMark(state..., {50.0, 50.0}, 6.0, sketch);
    std::vector<float> places;
    for (const Sketch::Vertex& vertex : sketch.vertices()) {
      places.push_back(vertex.x);
      places.push_back(vertex.y);
    }
    EXPECT_FALSE(places.empty());
    shapes.insert(places);
    ++count;
  };
  for (const Severity severity : kSeverities) add(severity);
  EXPECT_EQ(shapes.size(), 4U);
  shapes.clear();
  for (const bool next : {false, true}) add(training::StepState::kOpen, next);
  add(training::StepState::kDone, false);
  add(training::StepState::kFailed, false);
  EXPECT_EQ(shapes.size(), 4U);
}

TEST(TextSizes, AreLegibleOnLaptopsAndOn4k) {
  const FontAtlas atlas;
  for (const int height_px : {800, 1080, 2160}) {
    const TextSizes sizes = SizesFor(height_px);
    const Sketch sketch(atlas);
    // 1.3 % of the height: on a screen of 30 cm at 60 cm, letters of 22 minutes of arc.
    EXPECT_GE(sketch.TextHeight(sizes.small_px), 0.013 * height_px) << height_px;
    EXPECT_LE(sketch.TextHeight(sizes.large_px), 0.04 * height_px) << height_px;
  }
}

}  // namespace
}  // namespace acus::window
