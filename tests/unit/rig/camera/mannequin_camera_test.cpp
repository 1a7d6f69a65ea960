#include "acus/rig/camera/mannequin_camera.h"

#include <gtest/gtest.h>

#include "acus/base/core/error.h"
#include "acus/data/mesh/surface.h"
#include "support/facet_views.h"

namespace acus::camera {
namespace {

using namespace testing_support;

class Mannequin : public testing::Test {
 protected:
  CameraModel camera_ = ReadCamera(ConfigPath("cameras/micron_tracker_2010.json"));
  FacetSet set_ = ReadFacets(ConfigPath("facets/training.json"));
  Eigen::Isometry3d pose_ = FacingPose({0, 0, 1000}, 20, 30, 0);

  Image Take(const ImageMaking& making, std::uint64_t index = 1,
             std::vector<BodyInView> bodies = {}) {
    MannequinCamera maker(camera_, set_, std::move(bodies), making);
    Image image;
    const ObjectInView shown[] = {{"Reference", pose_}};
    maker.Render(shown, index, image);
    return image;
  }
};

TEST_F(Mannequin, SameInputSameBits) {
  EXPECT_EQ(Take({}).pixels, Take({}).pixels);
  EXPECT_NE(Take({}, 1).pixels, Take({}, 2).pixels);
  EXPECT_EQ(Take({.noise_sigma = 0}, 1).pixels, Take({.noise_sigma = 0}, 2).pixels);
}

TEST_F(Mannequin, NoiseIsAsLargeAsRequested) {
  const Image still = Take({.noise_sigma = 0, .colour = false});
  const Image noisy = Take({.noise_sigma = 5, .colour = false});
  double sum = 0.0;
  for (std::size_t i = 0; i < still.pixels.size(); ++i) {
    const double off = double{static_cast<double>(noisy.pixels[i])} - still.pixels[i];
    sum += off * off;
  }
  EXPECT_NEAR(std::sqrt(sum / static_cast<double>(still.pixels.size())), 5.0, 0.2);
}

TEST_F(Mannequin, ABodyHidesWhatIsBehindIt) {
  MarkerDetector detector(set_.dictionary);
  EXPECT_EQ(detector.Detect(Take({.colour = false}), &camera_).size(), 8U);
  // A board of 400 x 200 mm, 60 mm above the facets, over the right half.
  mesh::Surface board;
  board.nodes_mm.resize(3, 4);
  board.nodes_mm << 0, 400, 400, 0, -400, -400, 200, 200, 150, 150, 150, 150;
  board.triangles.resize(3, 2);
  board.triangles << 0, 0, 1, 2, 2, 3;
  const auto seen = detector.Detect(
      Take({.colour = false}, 1, {{.object = "Reference", .surface = board}}), &camera_);
  for (const DetectedMarker& marker : seen) EXPECT_LT(marker.id, 4) << "right facet";
  EXPECT_GE(seen.size(), 3U);
}

TEST_F(Mannequin, SheetsAreBlankFromBehind) {
  pose_ = pose_ * Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitY());
  EXPECT_TRUE(MarkerDetector(set_.dictionary).Detect(Take({.colour = false}), &camera_).empty());
}

TEST_F(Mannequin, TheTorsoIsClosedAndAsLargeAsItSays) {
  const mesh::Surface torso = PlainTorso();
  const Eigen::Vector3d size =
      torso.nodes_mm.rowwise().maxCoeff() - torso.nodes_mm.rowwise().minCoeff();
  EXPECT_TRUE(size.isApprox(Eigen::Vector3d(340, 500, 220), 1e-9)) << size.transpose();
  // Between the ellipsoid and the box.
  const double volume = mesh::SignedVolumeMm3(torso);
  EXPECT_GT(volume, std::numbers::pi / 6 * size.prod());
  EXPECT_LT(volume, size.prod());
}

TEST_F(Mannequin, RefusesWhatCannotBeRendered) {
  EXPECT_THROW(Take({.samples = 0}), InputError);
  EXPECT_THROW(Take({.samples = 17}), InputError);
  EXPECT_THROW(Take({.blur_sigma_px = -1}), InputError);
  EXPECT_THROW(Take({.noise_sigma = 101}), InputError);
  EXPECT_THROW(Take({.black = 200, .white = 100}), InputError);
  EXPECT_THROW(Take({.light_gradient = 1.5}), InputError);
  EXPECT_THROW(Take({}, 1, {{.object = "Nobody", .surface = PlainTorso()}}), InputError);
  mesh::Surface broken = PlainTorso();
  broken.triangles(0, 0) = 1 << 20;
  EXPECT_THROW(Take({}, 1, {{.object = "Reference", .surface = broken}}), InputError);
  pose_.translation()[1] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(Take({}), InputError);
}

TEST_F(Mannequin, PosesBehindTheCameraOrInItGiveAnImage) {
  for (const double z : {-500.0, 0.0, 1.0, 30.0, 1e7}) {
    pose_.translation() = Eigen::Vector3d(0, 0, z);
    EXPECT_FALSE(Take({}, 1, {{.object = "Reference", .surface = PlainTorso()}}).empty()) << z;
  }
}

}  // namespace
}  // namespace acus::camera
