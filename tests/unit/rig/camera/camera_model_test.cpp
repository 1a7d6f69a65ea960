#include "acus/rig/camera/camera_model.h"

#include <gmock/gmock.h>
#include <limits>

#include "acus/base/config/json_file.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "acus/base/core/random.h"
#include "support/fuzz.h"
#include "support/temporary_folder.h"

namespace acus::camera {
namespace {

CameraParameters Webcam() {
  return ReadCamera(std::string(ACUS_SOURCE_DIR) + "/configs/cameras/webcam_720p.json")
      .parameters();
}

TEST(CameraModel, ProjectsAsThePinholeFormulaSays) {
  CameraParameters p = Webcam();
  p.radial = {};
  p.tangential = {};
  const CameraModel camera(p);
  const auto pixel = camera.Project({100.0, -50.0, 1000.0});
  ASSERT_TRUE(pixel);
  EXPECT_NEAR((*pixel)[0], 645.2 + 1108.5 * 0.1, 1e-9);
  EXPECT_NEAR((*pixel)[1], 352.8 - 1106.0 * 0.05, 1e-9);
}

TEST(CameraModel, DistortsAsTheFormulaSays) {
  CameraParameters p = Webcam();
  p.radial = {-0.2, 0.05, 0.01};
  p.tangential = {0.002, -0.003};
  const auto pixel = CameraModel(p).Project({300.0, 200.0, 1000.0});
  ASSERT_TRUE(pixel);
  // By hand: x 0.3, y 0.2, r2 0.13, s 1 - 0.026 + 0.000845 + 0.00002197.
  const double s = 1.0 - 0.026 + 0.000845 + 0.00002197;
  const double x = 0.3 * s + 2 * 0.002 * 0.06 - 0.003 * (0.13 + 0.18);
  const double y = 0.2 * s + 0.002 * (0.13 + 0.08) - 2 * 0.003 * 0.06;
  EXPECT_NEAR((*pixel)[0], 1108.5 * x + 645.2, 1e-9);
  EXPECT_NEAR((*pixel)[1], 1106.0 * y + 352.8, 1e-9);
}

TEST(CameraModel, RayIsTheInverseOfProject) {
  const CameraModel camera(Webcam());
  for (int row = 0; row < 720; row += 37) {
    for (int column = 0; column < 1280; column += 41) {
      const Eigen::Vector2d pixel(column, row);
      const auto ray = camera.Ray(pixel);
      ASSERT_TRUE(ray) << pixel.transpose();
      EXPECT_LT((*camera.Project(700.0 * *ray) - pixel).norm(), 1e-9);
    }
  }
}

TEST(CameraModel, DerivativeIsThatOfDifferences) {
  const CameraModel camera(Webcam());
  RandomStream random(1, "points");
  for (int i = 0; i < 50; ++i) {
    const Eigen::Vector3d point(random.Uniform(-500, 500), random.Uniform(-300, 300),
                                random.Uniform(800, 1500));
    Eigen::Matrix<double, 2, 3> derivative;
    ASSERT_TRUE(camera.Project(point, derivative));
    for (int a = 0; a < 3; ++a) {
      const Eigen::Vector3d step = 1e-3 * Eigen::Vector3d::Unit(a);
      const Eigen::Vector2d difference =
          (*camera.Project(point + step) - *camera.Project(point - step)) / 2e-3;
      EXPECT_LT((difference - derivative.col(a)).norm(), 1e-7);
    }
  }
}

TEST(CameraModel, SeesNothingBehindItOrWhereTheLensWouldFold) {
  const CameraModel camera(Webcam());
  EXPECT_FALSE(camera.Project({0, 0, 0}));
  EXPECT_FALSE(camera.Project({0, 0, -100}));
  EXPECT_FALSE(camera.Project({0, 0, std::numeric_limits<double>::quiet_NaN()}));
  EXPECT_FALSE(camera.Ray({std::numeric_limits<double>::infinity(), 0}));
  // Barrel distortion alone turns back at r = sqrt(1 / (3 * 0.2)) = 1.29.
  CameraParameters p = Webcam();
  p.radial = {-0.2, 0, 0};
  const CameraModel barrel(p);
  EXPECT_TRUE(barrel.Project({1280, 0, 1000}));
  EXPECT_FALSE(barrel.Project({1300, 0, 1000}));
}

TEST(CameraModel, RefusesWhatIsNoCamera) {
  const auto refused = [](auto change) {
    CameraParameters p = Webcam();
    change(p);
    EXPECT_THROW(CameraModel{p}, InputError);
  };
  refused([](CameraParameters& p) { p.width_px = 15; });
  refused([](CameraParameters& p) { p.height_px = 8193; });
  refused([](CameraParameters& p) { p.focal_px[0] = 0.0; });
  refused([](CameraParameters& p) { p.centre_px[1] = -1.0; });
  refused([](CameraParameters& p) { p.centre_px[0] = 1280.0; });
  refused([](CameraParameters& p) { p.radial[2] = std::numeric_limits<double>::quiet_NaN(); });
  // Folds within the image.
  refused([](CameraParameters& p) { p.radial = {-1.5, 0, 0}; });
}

TEST(CameraModel, AngleOfThe2010SystemIsAsMeasuredThere) {
  const CameraModel camera =
      ReadCamera(std::string(ACUS_SOURCE_DIR) + "/configs/cameras/micron_tracker_2010.json");
  EXPECT_NEAR(camera.HorizontalAngleDeg(), 45.0, 0.01);
}

TEST(CameraFile, ComesBackAsItWasWritten) {
  const testing_support::TemporaryFolder folder;
  CameraParameters p = Webcam();
  p.reprojection_rms_px = 0.21;
  WriteCamera(folder / "camera.json", CameraModel(p));
  const CameraParameters q = ReadCamera(folder / "camera.json").parameters();
  EXPECT_EQ(q.focal_px, p.focal_px);
  EXPECT_EQ(q.centre_px, p.centre_px);
  EXPECT_EQ(q.radial, p.radial);
  EXPECT_EQ(q.tangential, p.tangential);
  EXPECT_EQ(q.reprojection_rms_px, p.reprojection_rms_px);
}

constexpr const char* kOpenCvXml = R"(<?xml version="1.0"?>
<opencv_storage>
<image_width>1280</image_width>
<image_height>720</image_height>
<camera_matrix type_id="opencv-matrix"><rows>3</rows><cols>3</cols><dt>d</dt>
  <data>1108.5 0. 645.2 0. 1106. 352.8 0. 0. 1.</data></camera_matrix>
<distortion_coefficients type_id="opencv-matrix"><rows>5</rows><cols>1</cols><dt>d</dt>
  <data>-0.12 0.06 0.0008 -0.0006 0.</data></distortion_coefficients>
</opencv_storage>
)";

TEST(CameraFile, IsReadFromXmlOfOpenCv) {
  const testing_support::TemporaryFolder folder;
  WriteTextFile(folder / "camera.xml", kOpenCvXml);
  const CameraParameters p = Webcam();
  const CameraParameters q = ReadCamera(folder / "camera.xml").parameters();
  EXPECT_EQ(q.width_px, p.width_px);
  EXPECT_EQ(q.height_px, p.height_px);
  EXPECT_EQ(q.focal_px, p.focal_px);
  EXPECT_EQ(q.centre_px, p.centre_px);
  EXPECT_EQ(q.radial, p.radial);
  EXPECT_EQ(q.tangential, p.tangential);
  const int refused = testing_support::ReadDamagedCopies(
      kOpenCvXml, folder / "damaged.xml", 300, [&] { ReadCamera(folder / "damaged.xml"); });
  EXPECT_GT(refused, 100);
}

TEST(CameraFile, OfAnotherLensOrInOtherUnitsIsRefused) {
  const testing_support::TemporaryFolder folder;
  const auto refused = [&](const std::string& text, const std::string& by, const char* why) {
    std::string changed = kOpenCvXml;
    changed.replace(changed.find(text), text.size(), by);
    WriteTextFile(folder / "camera.xml", changed);
    EXPECT_THAT([&] { ReadCamera(folder / "camera.xml"); },
                testing::ThrowsMessage<InputError>(testing::HasSubstr(why)));
  };
  refused("</opencv_storage>", "<fisheye_model>1</fisheye_model></opencv_storage>", "fisheye");
  refused("1108.5 0. 645.2 0. 1106. 352.8 0. 0. 1.", "1108.5 0. 0. 0. 1106. 0. 645.2 352.8 1.",
          "[fx 0 cx; 0 fy cy; 0 0 1]");
  refused("1108.5 0. 645.2 0. 1106. 352.8", "0.866 0. 0.504 0. 1.536 0.49", "in pixels");
}

TEST(CameraFile, DamagedCopiesAreReadOrRefused) {
  const testing_support::TemporaryFolder folder;
  WriteCamera(folder / "camera.json", CameraModel(Webcam()));
  const std::string valid = ReadTextFile(folder / "camera.json");
  const int refused = testing_support::ReadDamagedCopies(
      valid, folder / "damaged.json", 300, [&] { ReadCamera(folder / "damaged.json"); });
  EXPECT_GT(refused, 100);
}

}  // namespace
}  // namespace acus::camera
