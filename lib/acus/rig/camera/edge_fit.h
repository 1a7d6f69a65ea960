// The edge between the black of a marker and the white around it, to a hundredth of a pixel.
#pragma once

#include <Eigen/Dense>
#include <optional>
#include <span>

namespace acus::camera {

/// A pixel near an edge, in a frame where the edge is straight and about along x at y = 0; dark is
/// at y < 0.
struct EdgePixel {
  double along_px;
  double across_px;
  double level;
};

struct EdgeFit {
  double offset_px = 0.0;  ///< The edge is at across = offset + slope * along.
  double slope = 0.0;
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  ///< Of offset and slope.
  double blur_sigma_px = 0.0;
  double contrast = 0.0;  ///< White less black, grey levels.
};

/// Fits level = m + g along + (c / 2) erf((across - offset - slope along) / (sqrt(2) sigma)) by
/// least squares with Tukey's weights, so that what hides a tenth of the edge is omitted.
/// @param reach_px  Pixels are given for |across| up to here; the edge must lie within.
/// Nothing if it does not converge, the contrast is below 8 grey levels, or fewer than 12 pixels
/// count.
std::optional<EdgeFit> FitEdge(std::span<const EdgePixel> pixels, double reach_px);

}  // namespace acus::camera
