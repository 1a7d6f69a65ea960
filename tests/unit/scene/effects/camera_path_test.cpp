#include "acus/scene/effects/view_3d/camera_path.h"

#include <cmath>
#include <gmock/gmock.h>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "support/temporary_folder.h"

namespace acus::effects {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;
using volume_rendering::Viewpoint;

constexpr volume_rendering::ImageSize kWide{.width_px = 640, .height_px = 400};
const Eigen::AlignedBox3d kPatient(Eigen::Vector3d(-150, -100, 200),
                                   Eigen::Vector3d(170, 120, 600));

class CameraPathTest : public ::testing::Test {
 protected:
  CameraPathTest() {
    setenv("ACUS_CONFIGS", (std::filesystem::path(ACUS_SOURCE_DIR) / "configs").c_str(), 1);
  }
  std::filesystem::path File(const std::string& keys, const std::string& more = "") {
    const auto file = folder_.path() / "path.json";
    WriteTextFile(file, R"({"format": "acus-camera-path/1", "name": "test", )" + more +
                            R"("keys": [)" + keys + "]}");
    return file;
  }
  CameraPath Path(const std::string& keys, const std::string& more = "") {
    return CameraPath::Read(File(keys, more));
  }
  testing_support::TemporaryFolder folder_;
};

TEST_F(CameraPathTest, PassesThroughItsKeysAndStaysAtTheEnds) {
  const CameraPath path = Path(R"({"time_s": 1, "eye_mm": [0, -400, 0], "focus_mm": [0, 0, 0]},
    {"time_s": 3, "eye_mm": [100, -300, 50], "focus_mm": [10, 0, 5], "view_angle_deg": 20},
    {"time_s": 4, "eye_mm": [200, -350, 0], "focus_mm": [0, 20, 0], "up": [0, 1, 1]})");
  const auto at = [&](double time_s) { return path.At(time_s, kPatient, kWide); };
  EXPECT_LT((at(3.0).eye_in_ct_mm - Eigen::Vector3d(100, -300, 50)).norm(), 1e-9);
  EXPECT_LT((at(3.0).focus_in_ct_mm - Eigen::Vector3d(10, 0, 5)).norm(), 1e-9);
  EXPECT_NEAR(at(3.0).view_angle_deg, 20.0, 1e-9);
  EXPECT_EQ(at(0.0).eye_in_ct_mm, at(1.0).eye_in_ct_mm);
  EXPECT_EQ(at(99.0).up_in_ct, Eigen::Vector3d(0, 1, 1));
  // Smooth: velocities on both sides of a key agree.
  const double h = 1e-4;
  const Eigen::Vector3d before = (at(3.0).eye_in_ct_mm - at(3.0 - h).eye_in_ct_mm) / h;
  const Eigen::Vector3d after = (at(3.0 + h).eye_in_ct_mm - at(3.0).eye_in_ct_mm) / h;
  EXPECT_LT((before - after).norm(), 0.1);
  EXPECT_LT((before - Eigen::Vector3d(200, 50, 0) / 3.0).norm(), 0.1);
}

TEST_F(CameraPathTest, ATurntableTurnsUniformlyAndAgain) {
  const CameraPath path = CameraPath::Read(std::filesystem::path(ACUS_SOURCE_DIR) /
                                           "configs/camera_paths/turntable.json");
  const Eigen::Vector3d middle = kPatient.center();
  const Viewpoint first = path.At(0.0, kPatient, kWide);
  const double radius_mm = (first.eye_in_ct_mm - middle).norm();
  for (double time_s = 0.0; time_s < 60.0; time_s += 1.7) {
    const Viewpoint seen = path.At(time_s, kPatient, kWide);
    const Eigen::Vector3d to_eye = seen.eye_in_ct_mm - middle;
    EXPECT_NEAR(to_eye.norm(), radius_mm, 1e-6);
    const double azimuth = std::atan2(to_eye[0], -to_eye[1]);
    EXPECT_NEAR(std::remainder(azimuth - 2.0 * M_PI * time_s / 20.0, 2.0 * M_PI), 0.0, 1e-9);
    // All of the patient is in the image.
    const auto camera = volume_rendering::LookAt(seen, kWide);
    for (int n = 0; n < 8; ++n) {
      const Eigen::Vector2d pixel =
          camera.ProjectPx(kPatient.corner(static_cast<Eigen::AlignedBox3d::CornerType>(n)));
      EXPECT_TRUE(pixel[0] > 0 && pixel[0] < 640 && pixel[1] > 0 && pixel[1] < 400) << time_s;
    }
  }
}

TEST_F(CameraPathTest, ATurntableShowsAllOfThePatientInImagesOfAnyShape) {
  const CameraPath path = CameraPath::Read(std::filesystem::path(ACUS_SOURCE_DIR) /
                                           "configs/camera_paths/turntable.json");
  for (const volume_rendering::ImageSize size :
       {volume_rendering::ImageSize{800, 200}, {400, 400}, {200, 800}}) {
    for (double time_s = 0.0; time_s < 20.0; time_s += 2.3) {
      const auto camera = volume_rendering::LookAt(path.At(time_s, kPatient, size), size);
      double most = 0.0;  // Of the half width or height: 1 at the border.
      for (int n = 0; n < 8; ++n) {
        const Eigen::Vector2d pixel =
            camera.ProjectPx(kPatient.corner(static_cast<Eigen::AlignedBox3d::CornerType>(n)));
        const Eigen::Vector2d half(0.5 * size.width_px, 0.5 * size.height_px);
        most = std::max(most, (pixel - half).cwiseQuotient(half).cwiseAbs().maxCoeff());
      }
      EXPECT_LT(most, 1.0) << size.width_px << " x " << size.height_px;
      EXPECT_GT(most, 0.3) << "and it is no small spot";
    }
  }
}

// Straight from above there would be no upright direction, and a curve goes beyond its keys.
TEST_F(CameraPathTest, ViewsFromAboveStayUpright) {
  const CameraPath path = Path(R"({"time_s": 0, "azimuth_deg": 30, "elevation_deg": -20},
    {"time_s": 1, "azimuth_deg": 30, "elevation_deg": 88}, {"time_s": 2, "azimuth_deg": 30, "elevation_deg": 89})");
  double highest_deg = 0.0;
  for (double time_s = 0.0; time_s <= 2.0; time_s += 0.05) {
    const Viewpoint seen = path.At(time_s, kPatient, kWide);
    const Eigen::Vector3d towards = (seen.eye_in_ct_mm - seen.focus_in_ct_mm).normalized();
    highest_deg = std::max(highest_deg, std::asin(towards.z()) * 180.0 / M_PI);
    EXPECT_NEAR(std::atan2(towards.x(), -towards.y()) * 180.0 / M_PI, 30.0, 1e-6) << time_s;
  }
  EXPECT_NEAR(highest_deg, 89.0, 1e-6);
}

TEST_F(CameraPathTest, SaysWhatIsWrongWithAFile) {
  const auto expect = [&](const std::string& keys, const char* said) {
    EXPECT_THAT([&] { Path(keys); }, ThrowsMessage<InputError>(HasSubstr(said))) << keys;
  };
  expect("", "keys");
  expect(R"({"time_s": 0})", "/keys/0: give eye_mm and focus_mm, or azimuth_deg");
  expect(R"({"time_s": 0, "eye_mm": [0, 0, 0]})", "/keys/0: give eye_mm and focus_mm");
  expect(R"({"time_s": 0, "azimuth_deg": 0, "eye_mm": [0, 0, 0], "focus_mm": [1, 0, 0]})",
         "not both");
  expect(R"({"time_s": 0, "azimuth_deg": 0}, {"time_s": 0, "azimuth_deg": 5})", "times must rise");
  expect(R"({"time_s": 0, "azimuth_deg": 0},
             {"time_s": 1, "eye_mm": [0, 0, 0], "focus_mm": [1, 0, 0]})",
         "all keys of a path have the same");
  expect(R"({"time_s": 0, "azimuth_deg": 0, "elevation_deg": 95})", "95");
  EXPECT_THROW(CameraPath::Read(folder_.path() / "none.json"), InputError);
}

}  // namespace
}  // namespace acus::effects
