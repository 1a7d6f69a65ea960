// What is measured on envelopes: widths of points, statistics of speckle.
#pragma once

#include <span>

#include "acus/imaging/rf/beamform.h"

namespace acus::rf {

/// Widths at half of the maximum of the envelope (-6 dB), mm, by linear interpolation.
struct PointWidths {
  double lateral_mm = 0.0;
  double axial_mm = 0.0;
  Eigen::Vector2d peak_mm = Eigen::Vector2d::Zero();
};

/// Of the brightest pixel of the image, along its row and its column.
/// @throws NoAnswerError if the envelope does not fall to half within the image.
PointWidths WidthsOfBrightest(const IqImage& image);

/// Mean over standard deviation; 1.91 for fully developed speckle (Rayleigh).
/// @throws InputError if there are fewer than two values, or all are equal.
double SpeckleSnr(std::span<const float> envelope);

}  // namespace acus::rf
