// Markers in real photographs, against the corners that the makers of AprilTag's detector list for
// them. The photographs come without a camera's calibration or a scale: only pixels can be judged.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <gtest/gtest.h>
#include <iostream>

#include "acus/base/math/statistics.h"
#include "acus/rig/camera/calibration.h"
#include "acus/rig/camera/marker_detector.h"
#include "support/shared_data.h"

namespace acus::camera {
namespace {

using Corners = std::array<Eigen::Vector2d, 4>;

/// Rows "id, (x y), (x y), (x y), (x y)": counter-clockwise as seen, in pixels whose top left
/// corner, not centre, is at 0.
std::vector<Corners> ReadListed(const std::filesystem::path& path) {
  std::vector<Corners> listed;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    int id = 0;
    Corners c;
    const int count =
        std::sscanf(line.c_str(), "%d, (%lf %lf), (%lf %lf), (%lf %lf), (%lf %lf)", &id, &c[0][0],
                    &c[0][1], &c[1][0], &c[1][1], &c[2][0], &c[2][1], &c[3][0], &c[3][1]);
    if (count != 9) continue;
    for (Eigen::Vector2d& corner : c) corner.array() -= 0.5;
    listed.push_back(c);
  }
  return listed;
}

/// Distances of the corners, the marker turned as fits best.
std::array<double, 4> Distances(const Corners& listed, const DetectedMarker& marker) {
  std::array<double, 4> best;
  best.fill(1e9);
  for (std::size_t turn = 0; turn < 4; ++turn) {
    std::array<double, 4> off;
    for (std::size_t k = 0; k < 4; ++k) {
      off[k] = (listed[k] - marker.corners_px[(turn + 4 - k) % 4]).norm();
    }
    if (*std::max_element(off.begin(), off.end()) < *std::max_element(best.begin(), best.end())) {
      best = off;
    }
  }
  return best;
}

struct Photograph {
  const char* name;
  std::size_t least_found;
};

TEST(CameraData, CornersOfRealPhotographs) {
  const auto folder = testing_support::SharedData("registration/apriltag");
  if (!folder) GTEST_SKIP() << "test data registration/apriltag is not here";
  MarkerDetector detector("apriltag_36h11", {.smallest_side_px = 8.0, .magnification = 2});
  // The second one's cubes are 10 to 19 px wide: about one pixel a module.
  for (const Photograph& photo :
       {Photograph{"33369213973_9d9bb4cc96_c", 12}, Photograph{"34085369442_304b6bafd9_c", 14},
        Photograph{"34139872896_defdb2f8d9_c", 10}}) {
    const auto found = detector.Detect(ReadImage(*folder / (std::string(photo.name) + ".jpg")));
    const auto listed = ReadListed(*folder / (std::string(photo.name) + ".txt"));
    ASSERT_FALSE(listed.empty());
    std::vector<double> off;
    std::size_t matched = 0;
    for (const Corners& corners : listed) {
      std::array<double, 4> nearest;
      nearest.fill(1e9);
      for (const DetectedMarker& marker : found) {
        const auto here = Distances(corners, marker);
        if (*std::max_element(here.begin(), here.end()) <
            *std::max_element(nearest.begin(), nearest.end())) {
          nearest = here;
        }
      }
      if (*std::max_element(nearest.begin(), nearest.end()) > 5.0) continue;
      ++matched;
      off.insert(off.end(), nearest.begin(), nearest.end());
    }
    std::cout << photo.name << ": " << matched << " of " << listed.size() << " markers, "
              << found.size() << " found in all; corners: median " << math::Median(off) << ", RMS "
              << math::RootMeanSquare(off) << ", largest "
              << *std::max_element(off.begin(), off.end()) << " px\n";
    EXPECT_GE(matched, photo.least_found);
    EXPECT_LT(math::Median(off), 0.6);
    EXPECT_LT(math::RootMeanSquare(off), 1.0);
    for (const DetectedMarker& marker : found) EXPECT_EQ(marker.id, 0);
  }
}

// Some markers are misread, and the lens moves corners by a third of a marker's side.
TEST(CameraData, AnEndoscopeIsCalibratedInSpiteOfMisreadMarkers) {
  const auto folder = testing_support::SharedData("registration/charuco_endoscope");
  if (!folder) GTEST_SKIP() << "test data registration/charuco_endoscope is not here";
  const CalibrationBoard board{.name = "endoscope",
                               .dictionary = "aruco_4x4_250",
                               .columns = 19,
                               .rows = 26,
                               .square_mm = 5.0,
                               .first_square = FirstSquare::kMarker,
                               .marker_mm = 4.0};
  const Calibration found = CalibrateCamera(ImageFiles(*folder), board, {}, RunContext{});
  int used = 0, misread = 0;
  for (const CalibrationView& view : found.views) {
    used += view.rejected.empty() ? 1 : 0;
    misread += view.misread;
  }
  const Eigen::Vector2d focal_px = found.camera.parameters().focal_px;
  std::cout << "endoscope: " << used << " of " << found.views.size() << " images, " << misread
            << " markers misread, " << found.rms_px << " px RMS, focal " << focal_px.transpose()
            << " px\n";
  EXPECT_GE(used, 25);
  EXPECT_GT(misread, 0);
  EXPECT_LT(found.rms_px, 1.1);
  EXPECT_NEAR(focal_px[0], 833.0, 0.02 * 833.0);
}

}  // namespace
}  // namespace acus::camera
