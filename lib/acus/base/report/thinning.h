// Fewer points that draw the same image.
#pragma once

#include <vector>

namespace acus::report {

struct PixelPoint {
  double x;
  double y;
};

/// The points of a polyline that matter at pixel size: of each run of consecutive points within one
/// pixel column the first, lowest, highest and last, in order. If that leaves more than
/// `max_points`, runs of equal length are thinned to the ends of their bounding box instead.
/// Never more than `max_points` (at least 8 are allowed).
std::vector<PixelPoint> ThinnedLine(const std::vector<PixelPoint>& points, int max_points);

/// Points that do not lie in the same square of `cell_px` as an earlier one; squares grow until at
/// most `max_points` are left.
std::vector<PixelPoint> ThinnedPoints(const std::vector<PixelPoint>& points, double cell_px,
                                      int max_points);

}  // namespace acus::report
