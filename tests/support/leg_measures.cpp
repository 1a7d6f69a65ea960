#include "support/leg_measures.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <opencv2/imgproc.hpp>

namespace acus::testing_support {
namespace {

/// Mean over some rows and 13 columns; beyond the image: its edge.
double MeanGrey(const cv::Mat& image, double first_row, double last_row, int column) {
  double sum = 0.0;
  int count = 0;
  for (int r = static_cast<int>(first_row); r <= static_cast<int>(last_row); ++r) {
    for (int c = column - 6; c <= column + 6; c += 2, ++count) {
      sum += image.at<std::uint8_t>(std::clamp(r, 0, image.rows - 1),
                                    std::clamp(c, 0, image.cols - 1));
    }
  }
  return sum / std::max(1, count);
}

/// Lag at which an autocorrelation falls to one half.
double HalfWidth(const std::vector<double>& correlation) {
  for (std::size_t n = 1; n < correlation.size(); ++n) {
    if (correlation[n] >= 0.5 * correlation[0]) continue;
    const double above = correlation[n - 1] - 0.5 * correlation[0];
    return static_cast<double>(n - 1) + above / (correlation[n - 1] - correlation[n]);
  }
  return static_cast<double>(correlation.size());
}

/// Autocorrelation along the image's rows (by column) or down its columns.
std::vector<double> CorrelationOf(const cv::Mat& grain, bool by_column) {
  std::vector<double> all;
  for (int lag = 0; lag < 20; ++lag) {
    const int dx = by_column ? lag : 0;
    const int dy = by_column ? 0 : lag;
    const cv::Size size(grain.cols - dx, grain.rows - dy);
    all.push_back(cv::mean(grain(cv::Rect({0, 0}, size)).mul(grain(cv::Rect({dx, dy}, size))))[0]);
  }
  return all;
}

/// Grey of one row from inside a shadow outwards, smoothed over 2 mm of depth.
std::vector<double> AcrossEdge(const cv::Mat& image, int row, int edge, int outwards, int reach) {
  std::vector<double> profile;
  for (int t = -reach; t <= reach; ++t) {
    double sum = 0.0;
    int count = 0;
    for (int r = row - 18; r <= row + 18; ++r) {
      for (int w = -4; w <= 4; w += 2, ++count) {
        sum += image.at<std::uint8_t>(std::min(r, kLegHeightPx - 1),
                                      std::clamp(edge + outwards * t + w, 0, kLegWidthPx - 1));
      }
    }
    profile.push_back(sum / count);
  }
  return profile;
}

/// From 25 to 75 % of the step between the profile's ends, mm; negative: there is no step.
double WidthOfStep(const std::vector<double>& profile) {
  const auto ends = static_cast<std::ptrdiff_t>(1.5 / kLegMmPerPx);
  const double inside = std::accumulate(profile.begin(), profile.begin() + ends, 0.0) / ends;
  const double outside = std::accumulate(profile.end() - ends, profile.end(), 0.0) / ends;
  if (outside - inside < 30.0) return -1.0;
  const auto first_at = [&](double share) {
    const double level = inside + share * (outside - inside);
    return std::find_if(profile.begin(), profile.end(), [&](double grey) { return grey >= level; });
  };
  return static_cast<double>(first_at(0.75) - first_at(0.25)) * kLegMmPerPx;
}

}  // namespace

double QuantileOf(std::vector<double> values, double quantile) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(quantile * static_cast<double>(values.size()))];
}

void MeasureBone(const cv::Mat& image, const LegSurface& bone, LegMeasures& measures) {
  LegMeasures columns;
  for (int c = 20; c < kLegWidthPx - 40; c += 8) {
    const double depth_mm = bone.depth_mm[static_cast<std::size_t>(c)];
    if (depth_mm < 6.0 || depth_mm + 10.0 > kLegHeightPx * kLegMmPerPx) continue;
    // The registration is good to a millimetre or two: the ridge itself is searched.
    double level = -1.0;
    int ridge = 0;
    for (int r = static_cast<int>((depth_mm - 2.5) / kLegMmPerPx);
         r <= (depth_mm + 2.5) / kLegMmPerPx; ++r) {
      const double mean = MeanGrey(image, r - 2, r + 2, c);
      if (mean > level) {
        level = mean;
        ridge = r;
      }
    }
    const double degrees = std::acos(std::min(1.0, bone.cosine[static_cast<std::size_t>(c)])) *
                           180.0 / std::numbers::pi;
    columns[degrees < 20.0   ? "level, 0 to 20 degrees"
            : degrees < 40.0 ? "level, 20 to 40 degrees"
                             : "level, over 40 degrees"]
        .push_back(level);
    const double above = MeanGrey(image, ridge - 3.5 / kLegMmPerPx, ridge - 2.0 / kLegMmPerPx, c);
    if (degrees >= 40.0 || level - above < 30.0) continue;
    const double half = 0.5 * (above + level);
    int low = ridge;
    int high = ridge;
    while (ridge - low < 80 && MeanGrey(image, low - 1, low + 1, c) > half) --low;
    while (high - ridge < 80 && MeanGrey(image, high - 1, high + 1, c) > half) ++high;
    columns["thickness, mm"].push_back((high - low) * kLegMmPerPx);
    columns["fall, 3 mm below"].push_back(
        MeanGrey(image, ridge + 2.2 / kLegMmPerPx, ridge + 4.2 / kLegMmPerPx, c) - level);
    columns["fall, 8 mm below"].push_back(
        MeanGrey(image, ridge + 7.0 / kLegMmPerPx, ridge + 9.0 / kLegMmPerPx, c) - level);
  }
  for (const auto& [name, values] : columns) measures[name].push_back(MedianOf(values));
}

void MeasureShadowEdges(const cv::Mat& image, const LegSurface& bone, LegMeasures& measures) {
  constexpr auto kReach = static_cast<int>(6.0 / kLegMmPerPx);
  const auto is_bone = [](double depth_mm) { return depth_mm > 0.0; };
  const std::vector<double>& depth_mm = bone.depth_mm;
  const auto first = std::find_if(depth_mm.begin(), depth_mm.end(), is_bone) - depth_mm.begin();
  const auto last = depth_mm.rend() - std::find_if(depth_mm.rbegin(), depth_mm.rend(), is_bone) - 1;
  for (const auto& [below_mm, name] :
       {std::pair(4.0, "edge, 4 mm below, mm"), std::pair(8.0, "edge, 8 mm below, mm"),
        std::pair(12.0, "edge, 12 mm below, mm")}) {
    for (const auto& [edge, outwards] : {std::pair(first, -1), std::pair(last, 1)}) {
      const auto column = static_cast<int>(edge);
      const int row =
          static_cast<int>((depth_mm[static_cast<std::size_t>(edge)] + below_mm) / kLegMmPerPx);
      // The scale at the right is burnt in.
      if (row + 20 >= kLegHeightPx || std::min(column, column + outwards * kReach) < 20 ||
          std::max(column, column + outwards * kReach) >= kLegWidthPx - 60 ||
          std::min(column, column - outwards * kReach) < 0 ||
          std::max(column, column - outwards * kReach) >= kLegWidthPx)
        continue;
      const double width_mm = WidthOfStep(AcrossEdge(image, row, column, outwards, kReach));
      if (width_mm >= 0.0) measures[name].push_back(width_mm);
    }
  }
}

void MeasureSoftTissue(const cv::Mat& image, const LegSurface& bone, LegMeasures& measures) {
  constexpr auto kSide = static_cast<int>(6.0 / kLegMmPerPx);
  double sum = 0.0;
  double squares = 0.0;
  LegMeasures windows;
  for (int c = 20; c + kSide < kLegWidthPx - 40; c += kSide / 2) {
    double bone_mm = 1e9;
    for (int x = c; x < c + kSide; ++x) {
      const double depth_mm = bone.depth_mm[static_cast<std::size_t>(x)];
      if (depth_mm > 0.0) bone_mm = std::min(bone_mm, depth_mm);
    }
    if (bone_mm > 1e8) continue;
    for (int r = static_cast<int>(10.0 / kLegMmPerPx); (r + kSide) * kLegMmPerPx < bone_mm - 3.5;
         r += kSide / 2) {
      cv::Mat window;
      image(cv::Rect(c, r, kSide, kSide)).convertTo(window, CV_64F);
      cv::Scalar mean;
      cv::Scalar deviation;
      cv::meanStdDev(window, mean, deviation);
      sum += mean[0];
      squares += mean[0] * mean[0] + deviation[0] * deviation[0];
      cv::Mat smooth;
      cv::blur(window, smooth, cv::Size(9, 9), cv::Point(-1, -1), cv::BORDER_REFLECT);
      const cv::Mat grain = window - smooth;
      cv::meanStdDev(grain, mean, deviation);
      windows["grain, standard deviation"].push_back(deviation[0]);
      windows["grain across, mm"].push_back(HalfWidth(CorrelationOf(grain, true)) * kLegMmPerPx);
      windows["grain along, mm"].push_back(HalfWidth(CorrelationOf(grain, false)) * kLegMmPerPx);
    }
  }
  if (windows.empty()) return;
  const auto count = static_cast<double>(windows.begin()->second.size());
  const double mean = sum / count;
  measures["soft tissue, mean"].push_back(mean);
  measures["soft tissue, standard deviation"].push_back(std::sqrt(squares / count - mean * mean));
  for (const auto& [name, values] : windows) measures[name].push_back(MedianOf(values));
}

}  // namespace acus::testing_support
