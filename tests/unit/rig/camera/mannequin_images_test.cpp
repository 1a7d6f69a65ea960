#include "acus/rig/camera/mannequin_images.h"

#include <gtest/gtest.h>

#include "acus/base/core/error.h"
#include "acus/rig/camera/marker_detector.h"

namespace acus::simulators {
namespace {

MannequinView View() {
  MannequinView view;
  view.camera = ACUS_SOURCE_DIR "/configs/cameras/webcam_720p.json";
  view.facets = ACUS_SOURCE_DIR "/configs/facets/training.json";
  return view;
}

std::set<int> MarkersIn(const tracking::Image& sent) {
  camera::Image image{.width_px = sent.width,
                      .height_px = sent.height,
                      .channels = sent.channels,
                      .pixels = sent.pixels};
  std::set<int> ids;
  for (const auto& marker : camera::MarkerDetector("apriltag_36h11").Detect(image)) {
    ids.insert(marker.id);
  }
  return ids;
}

TEST(MannequinImages, TheCameraLooksAtItsTargetAndIsMoved) {
  const MannequinView view = View();
  const Eigen::Isometry3d still = CameraFromReference(view, 0);
  const Eigen::Vector3d seen_mm = still * view.looks_at_mm;
  EXPECT_LT(seen_mm.head<2>().norm(), 1e-9) << "in the middle of the image";
  EXPECT_GT(seen_mm.z(), 0.0);
  EXPECT_LT((still.linear() * Eigen::Vector3d::UnitZ()).y(), 0.0) << "up is up";
  const Eigen::Isometry3d later = CameraFromReference(view, 2'500'000'000);
  EXPECT_NEAR((later.inverse() * still).translation().norm(), std::hypot(15.0, 14.03), 0.5);
  // Along x it comes back after 5 s, along both after 65 s.
  const auto eye_mm = [&](std::int64_t time_s) -> Eigen::Vector3d {
    return CameraFromReference(view, time_s * 1'000'000'000).inverse().translation();
  };
  EXPECT_NEAR(eye_mm(5).x(), view.eye_mm.x(), 1e-9);
  EXPECT_NEAR((eye_mm(65) - view.eye_mm).norm(), 0.0, 1e-9);
}

TEST(MannequinImages, ShowsTheMarkersOfWhatIsSeen) {
  const auto images = MannequinImages(View());
  // A probe upright beside the mannequin's facets, its beam down.
  const Eigen::Isometry3d pose = Eigen::Translation3d(0.0, 0.0, 20.0) *
                                 Eigen::AngleAxisd(-M_PI / 2.0, Eigen::Vector3d::UnitX());
  std::vector<tracking::NamedPose> poses = {
      {.name = "ProbeToReference", .reference_from_tool = pose},
      {.name = "StylusToReference", .reference_from_tool = pose}};  // No facets: not drawn.
  const std::set<int> with_probe = MarkersIn(images->Draw(poses, 0)[0]);
  poses[0].valid = false;
  const std::set<int> without = MarkersIn(images->Draw(poses, 0)[0]);
  for (int id = 0; id < 8; ++id) {
    EXPECT_TRUE(with_probe.contains(id)) << id;
    EXPECT_TRUE(without.contains(id)) << id;
  }
  EXPECT_TRUE(with_probe.contains(10) || with_probe.contains(11));
  EXPECT_EQ(without.size(), 8u) << "only the mannequin's";
}

TEST(MannequinImages, APairSeesTheSameFromBesideEachOther) {
  MannequinView view = View();
  view.stereo = ACUS_SOURCE_DIR "/configs/cameras/micron_pair_2010.json";
  const auto images = MannequinImages(view);
  EXPECT_EQ(images->streams(), (std::vector<std::string>{"Video", "VideoRight"}));
  const auto drawn = images->Draw({}, 0);
  ASSERT_EQ(drawn.size(), 2u);
  EXPECT_EQ(MarkersIn(drawn[0]), MarkersIn(drawn[1]));
  EXPECT_NE(drawn[0].pixels, drawn[1].pixels);
}

TEST(MannequinImages, RefusesWhatIsNoView) {
  MannequinView view = View();
  view.eye_mm = view.looks_at_mm;
  EXPECT_THROW(MannequinImages(view), InputError);
  view = View();
  view.facets = view.camera;
  EXPECT_THROW(MannequinImages(view), InputError);
}

}  // namespace
}  // namespace acus::simulators
