// Scales, marks and numbers over the views.
#pragma once

#include <optional>

#include "acus/window/frame.h"
#include "acus/window/layout.h"
#include "acus/window/sketch.h"
#include "acus/window/steering.h"

namespace acus::window {

/// Text sizes for the height of a window.
struct TextSizes {
  int small_px = 12;
  int normal_px = 14;
  int large_px = 22;
};
TextSizes SizesFor(int window_height_px);
/// Size of marks relative to those in a window 800 pixels high: they grow as its text does.
double MarkScale(const TextSizes& sizes);
/// A length of that window, in pixels of this one.
int Scaled(int px, const TextSizes& sizes);

/// The rectangle of a view's image: below its title, and beside its scale if it has one.
Rectangle ImageRoom(ViewKind view, const Rectangle& place, const TextSizes& sizes);

/// An image of the probe's plane on the screen, and the map from CT space to it.
struct PlaneOnScreen {
  image::ImageGeometry geometry;
  Rectangle place;
  Eigen::Isometry3d ct_from_probe = Eigen::Isometry3d::Identity();

  double PxPerMm() const;
  /// Column and row in the window, and the signed distance from the plane, mm.
  Eigen::Vector3d At(const Eigen::Vector3d& place_in_ct_mm) const;
};

void DrawTitle(std::string_view title, std::string_view detail, const Rectangle& place,
               const TextSizes& sizes, Sketch& sketch, Colour detail_colour = palette::kFaint);

/// Depth scale, focus, marked side, guide, target, freeze, gain: as on a scanner.
void DrawUltrasoundMarks(const DisplayFrame& frame, const Rectangle& place,
                         const PlaneOnScreen& plane, const ViewChoice& choice, Sketch& sketch,
                         const TextSizes& sizes);

/// Tip and target.
void DrawSliceMarks(const DisplayFrame& frame, const PlaneOnScreen& plane, const TextSizes& sizes,
                    Sketch& sketch);

/// Needle, target and the probe's plane over the video.
void DrawVideoMarks(const DisplayFrame& frame, const Rectangle& place, const TextSizes& sizes,
                    Sketch& sketch);

/// Distance from the tip in the images to the target, mm. Nothing if one of them does not exist.
std::optional<double> ImagedTipToTargetMm(const DisplayFrame& frame);

/// "12.3": a fixed number of digits after the point.
std::string Digits(double value, int after_point);

}  // namespace acus::window
