// What is measured in frames over a leg, recorded and simulated: how bone and soft tissue look.
#pragma once

#include <map>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "support/leg_sweep.h"

namespace acus::testing_support {

/// Where beams meet the bone in the plane of one frame.
struct LegSurface {
  std::vector<double> depth_mm = std::vector<double>(kLegWidthPx, -1.0);  ///< By column; -1: none.
  std::vector<double> cosine = std::vector<double>(kLegWidthPx, 0.0);
};

/// By name, one value per frame.
using LegMeasures = std::map<std::string, std::vector<double>>;

/// Adds one frame's medians: the ridge's level by angle of incidence, its thickness, what follows
/// behind it. Grey levels.
void MeasureBone(const cv::Mat& image, const LegSurface& bone, LegMeasures& measures);

/// Adds the widths of the shadow's edges, from 25 to 75 % of the step of grey, at depths behind the
/// bone's outermost points.
void MeasureShadowEdges(const cv::Mat& image, const LegSurface& bone, LegMeasures& measures);

/// Adds what windows of 6 mm between 10 mm and the bone show: mean and standard deviation of grey,
/// and standard deviation and size (lag at which the correlation is one half) of the grain, which
/// is what a mean over 0.5 mm takes away.
void MeasureSoftTissue(const cv::Mat& image, const LegSurface& bone, LegMeasures& measures);

double QuantileOf(std::vector<double> values, double quantile);
inline double MedianOf(const std::vector<double>& values) {
  return QuantileOf(values, 0.5);
}

}  // namespace acus::testing_support
