#include "acus/imaging/volume_rendering/tools.h"

#include <filesystem>
#include <gmock/gmock.h>

#include "acus/base/core/error.h"

namespace acus::volume_rendering {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

const std::filesystem::path kProbes = std::filesystem::path(ACUS_SOURCE_DIR) / "configs/probes";

TEST(Tools, ATubeHoldsItsVolume) {
  Eigen::Matrix3Xd points(3, 3);
  points << 0, 0, 0, 0, 0, 0, 0, 40, 100;
  const mesh::Surface tube = Tube(points, Eigen::Vector3d(2.0, 2.0, 2.0));
  // A prism of 16 sides; positive: triangles face outwards.
  const double area_mm2 = 0.5 * 16 * 4.0 * std::sin(2.0 * M_PI / 16);
  EXPECT_NEAR(mesh::SignedVolumeMm3(tube), 100.0 * area_mm2, 1e-6);
}

TEST(Tools, TheNeedleReachesFromTipToHubStraightOrBent) {
  image::NeedleInImage needle{{10, 20, 30}, {0, 0, 1}, 90.0, 0.4};
  const mesh::Surface straight = NeedleShaft(needle, 0.0);
  EXPECT_NEAR(straight.nodes_mm.row(2).maxCoeff(), 30.0, 1e-9);
  EXPECT_NEAR(straight.nodes_mm.row(2).minCoeff(), -60.0, 1e-9);
  EXPECT_NEAR(straight.nodes_mm.row(0).maxCoeff(), 10.4, 1e-3);
  EXPECT_NEAR(NeedleShaft(needle, 1.5).nodes_mm.row(0).maxCoeff(), 11.5, 1e-3);
  needle.shape.Add({0, 0, 0});
  needle.shape.Add({3, 0, -50});
  needle.shape.Add({12, 0, -100});
  const mesh::Surface bent = NeedleShaft(needle, 0.0);
  EXPECT_NEAR(bent.nodes_mm.row(0).maxCoeff(), 12.4, 0.05);
  EXPECT_GT(mesh::SignedVolumeMm3(bent), 0.0);
  EXPECT_NEAR(NeedleHub(needle).nodes_mm.row(0).minCoeff(), 12.0, 4.0);
}

TEST(Tools, TheNeedleHasAMarkEachCentimetreAlongItsLine) {
  image::NeedleInImage needle{{10, 20, 30}, {0, 0, 1}, 90.0, 0.4};
  const mesh::Surface marks = NeedleMarks(needle, 0.0, 10.0);
  const mesh::Surface one = NeedleMarks(needle, 0.0, 90.0);
  EXPECT_EQ(marks.nodes_mm.cols(), 9 * one.nodes_mm.cols());
  EXPECT_LT(marks.triangles.maxCoeff(), marks.nodes_mm.cols());
  EXPECT_GT(mesh::SignedVolumeMm3(marks), 0.0) << "each is closed, and faces outwards";
  // From the tip at 30 mm: the first at 20, the last at -60; the fifth, at -20, is wider.
  const auto nodes_near = [&](double z_mm, double within_mm) {
    return ((marks.nodes_mm.row(2).array() - z_mm).abs() <= within_mm).count();
  };
  for (int n = 1; n <= 9; ++n) {
    EXPECT_EQ(nodes_near(30.0 - 10.0 * n, n == 5 ? 1.2001 : 0.4001), one.nodes_mm.cols()) << n;
  }
  EXPECT_EQ(nodes_near(-20.0, 0.5), 0) << "its ends are farther apart";
  // On a bent needle the distance is that along the shaft: 30 mm, then 40 mm to the side.
  needle.shape.Add({0, 0, 0});
  needle.shape.Add({0, 0, -30});
  needle.shape.Add({40, 0, -30});
  const mesh::Surface bent = NeedleMarks(needle, 0.0, 50.0);
  EXPECT_NEAR(bent.nodes_mm.row(0).mean(), 20.0, 0.1);
  EXPECT_NEAR(bent.nodes_mm.row(2).mean(), -30.0, 0.1);
  EXPECT_EQ(NeedleMarks(needle, 0.0, 100.0).triangles.cols(), 0);
}

TEST(Tools, EveryProbeHasABodyAboveItsFaceAndAPaneBelowIt) {
  for (const auto& entry : std::filesystem::directory_iterator(kProbes)) {
    const acoustics::Probe probe = acoustics::ReadProbe(entry.path());
    const mesh::Surface body = ProbeBody(probe);
    EXPECT_GT(mesh::SignedVolumeMm3(body), 1e4) << entry.path();
    EXPECT_LE(body.nodes_mm.row(1).maxCoeff(), 1e-9) << entry.path();
    const ImagePlane plane = PlaneOf(probe);
    EXPECT_NEAR(plane.surface.nodes_mm.row(1).maxCoeff(), probe.depth_mm, 1.5) << entry.path();
    EXPECT_TRUE(plane.surface.nodes_mm.row(2).isZero());
    // Each node shows the pixel that is there.
    const Eigen::Affine3d probe_from_image = acoustics::ImageOf(probe).probe_from_image();
    for (Eigen::Index n = 0; n < plane.surface.nodes_mm.cols(); ++n) {
      const Eigen::Vector2d pixel = plane.pixel_of_node.col(n).cast<double>();
      const Eigen::Vector3d there = probe_from_image * Eigen::Vector3d(pixel[0], pixel[1], 0.0);
      EXPECT_LT((there - plane.surface.nodes_mm.col(n)).norm(), 1e-3);
    }
    const Eigen::VectorXd radius = Eigen::VectorXd::Constant(plane.outline_mm.cols(), 0.3);
    EXPECT_TRUE(Tube(plane.outline_mm, radius).nodes_mm.allFinite()) << entry.path();
    EXPECT_GT(mesh::SignedVolumeMm3(ProbeMark(probe)), 10.0);
  }
}

TEST(Tools, RefuseWhatHasNoShape) {
  EXPECT_THAT([] { Tube(Eigen::Matrix3Xd::Zero(3, 1), Eigen::VectorXd::Ones(1)); },
              ThrowsMessage<InputError>(HasSubstr("at least two")));
  EXPECT_THAT([] { Tube(Eigen::Matrix3Xd::Zero(3, 2), Eigen::VectorXd::Ones(3)); },
              ThrowsMessage<InputError>(HasSubstr("equally many")));
  const image::NeedleInImage none{{0, 0, 0}, {0, 0, 1}, 0.0, 0.4};
  EXPECT_THAT([&] { NeedleShaft(none, 1.0); }, ThrowsMessage<InputError>(HasSubstr("no length")));
}

}  // namespace
}  // namespace acus::volume_rendering
