// The overlay: markers known in CT, through the registration and the pose that the camera found,
// against where they are in the image.
#include <gtest/gtest.h>
#include <iostream>

#include "acus/patient/registration/rigid_registration.h"
#include "support/facet_views.h"

namespace acus::camera {
namespace {

using namespace testing_support;

constexpr double kFleMm = 0.25;  ///< Of each landmark in each space, RMS length.

Eigen::Vector3d Jittered(const Eigen::Vector3d& at, RandomStream& random) {
  return at + kFleMm / std::sqrt(3.0) *
                  Eigen::Vector3d(random.Normal(), random.Normal(), random.Normal());
}

/// The mannequin's facets, and six fiducials on its top that CT shows too.
FacetSet WithFiducials() {
  FacetSet set = ReadFacets(ConfigPath("facets/training.json"));
  FacetObject fiducials{.name = "Fiducials", .markers = {}};
  int id = 30;
  for (const Eigen::Vector2d& at :
       {Eigen::Vector2d(-90, -70), Eigen::Vector2d(0, -80), Eigen::Vector2d(90, -70),
        Eigen::Vector2d(-90, 70), Eigen::Vector2d(0, 90), Eigen::Vector2d(90, 60)}) {
    Marker marker;
    marker.id = id++;
    marker.side_mm = 30.0;
    marker.object_from_marker = Eigen::Translation3d(at[0], at[1], 5.0 + 0.05 * at[0]);
    marker.facet = "fiducial";
    fiducials.markers.push_back(marker);
  }
  set.objects.push_back(fiducials);
  return set;
}

/// Where the diagonals of a square meet: its middle, whatever the view.
Eigen::Vector2d MiddlePx(const DetectedMarker& marker) {
  const Eigen::Vector2d a = marker.corners_px[2] - marker.corners_px[0];
  const Eigen::Vector2d b = marker.corners_px[3] - marker.corners_px[1];
  const Eigen::Vector2d between = marker.corners_px[1] - marker.corners_px[0];
  const double t = (between[0] * b[1] - between[1] * b[0]) / (a[0] * b[1] - a[1] * b[0]);
  return marker.corners_px[0] + t * a;
}

TEST(CameraOverlay, CtMarkersFallOnThoseOfTheImage) {
  const CameraModel camera = ReadCamera(ConfigPath("cameras/webcam_720p.json"));
  const FacetSet set = WithFiducials();
  const FacetObject& mannequin = *set.Find("Reference");
  const FacetObject& fiducials = *set.Find("Fiducials");
  MannequinCamera maker(camera, set, {{.object = "Reference", .surface = PlainTorso()}},
                        {.colour = false});
  MarkerDetector detector(set.dictionary);
  const Eigen::Isometry3d ct_from_reference =
      Eigen::Translation3d(12.0, -210.0, 640.0) *
      Eigen::AngleAxisd(1.2, Eigen::Vector3d(1, 2, -1).normalized());
  double largest_px = 0.0;
  double sum_px2 = 0.0;
  int count = 0;
  for (std::uint64_t i = 0; i < 20; ++i) {
    RandomStream random(3, "overlay", i);
    // CT to mannequin from landmarks that both sides know with an error.
    transforms::Markers in_ct(3, 6), in_reference(3, 6);
    for (Eigen::Index m = 0; m < 6; ++m) {
      const Eigen::Vector3d at =
          fiducials.markers[static_cast<std::size_t>(m)].object_from_marker.translation();
      in_reference.col(m) = Jittered(at, random);
      in_ct.col(m) = Jittered(ct_from_reference * at, random);
    }
    const auto fit = registration::FitMarkers(in_reference, in_ct);
    // The camera finds the mannequin by its facets alone.
    const Eigen::Isometry3d truth =
        FacingPose({random.Uniform(-80, 80), random.Uniform(-40, 40), random.Uniform(900, 1200)},
                   random.Uniform(5, 30), random.Uniform(0, 360), random.Uniform(-30, 30));
    Image image;
    const ObjectInView shown[] = {{"Reference", truth}, {"Fiducials", truth}};
    maker.Render(shown, i, image);
    const auto seen = detector.Detect(image, &camera);
    const auto pose = LocateObject(mannequin, seen, camera, {}, std::nullopt);
    ASSERT_TRUE(pose) << i;
    for (const DetectedMarker& marker : seen) {
      if (marker.id < 30) continue;
      const Eigen::Vector3d marker_in_ct =
          ct_from_reference * fiducials.markers[static_cast<std::size_t>(marker.id - 30)]
                                  .object_from_marker.translation();
      const Eigen::Vector3d in_camera =
          pose->camera_from_object * (fit.ct_from_reference.inverse() * marker_in_ct);
      const double off_px = (*camera.Project(in_camera) - MiddlePx(marker)).norm();
      largest_px = std::max(largest_px, off_px);
      sum_px2 += off_px * off_px;
      ++count;
    }
  }
  std::cout << "overlay: " << count << " markers in 20 images, RMS " << std::sqrt(sum_px2 / count)
            << " px, largest " << largest_px << " px\n";
  EXPECT_GT(count, 100);
  EXPECT_LT(largest_px, 2.0);
}

}  // namespace
}  // namespace acus::camera
