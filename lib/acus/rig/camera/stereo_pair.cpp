#include "acus/rig/camera/stereo_pair.h"

#include <array>
#include <cmath>
#include <string>

#include "acus/base/config/json_file.h"
#include "acus/base/config/pose_json.h"
#include "acus/base/core/error.h"
#include "acus/base/math/rigid.h"

namespace acus::camera {
namespace {

using nlohmann::json;

constexpr double kLeastBaselineMm = 1.0;
constexpr double kLeastSine = 1.7e-4;  ///< Of 0.01 degrees.

Eigen::Isometry3d RigidOf(const json& rows, const std::string& file) {
  const Eigen::Isometry3d read = config::PoseFromRows(rows);
  ACUS_REQUIRE(math::IsRigid(read.matrix()), file,
               ": /right_from_left: is not a rotation and a translation; write 4 rows of 4 numbers "
               "as acus-camera stereo does");
  return math::RigidFromMatrix(read.matrix());
}

}  // namespace

StereoPair ReadStereo(const std::filesystem::path& path) {
  const json document = config::ReadConfig(path, "acus-stereo");
  const std::string file = path.string();
  StereoPair pair{.left = CameraOf(document.at("left"), file + ": /left"),
                  .right = CameraOf(document.at("right"), file + ": /right"),
                  .right_from_left = RigidOf(document.at("right_from_left"), file),
                  .reprojection_rms_px = document.at("reprojection_rms_px")};
  ACUS_REQUIRE(pair.BaselineMm() >= kLeastBaselineMm, file, ": /right_from_left: the cameras are ",
               pair.BaselineMm(),
               " mm apart; allowed are 1 mm and more: calibrate the pair with acus-camera stereo");
  return pair;
}

json ToJson(const StereoPair& pair) {
  return {{"format", "acus-stereo/1"},
          {"left", ToJson(pair.left)},
          {"right", ToJson(pair.right)},
          {"right_from_left", config::MatrixRows(pair.right_from_left)},
          {"reprojection_rms_px", pair.reprojection_rms_px},
          {"baseline_mm", pair.BaselineMm()}};
}

void RequireSameCamera(const CameraModel& in_pair, const CameraModel& own, const char* side) {
  const CameraParameters& a = in_pair.parameters();
  const CameraParameters& b = own.parameters();
  ACUS_REQUIRE(
      a.width_px == b.width_px && a.height_px == b.height_px, "the pair's ", side, " camera has ",
      a.width_px, " x ", a.height_px, " pixels, '", b.name, "' has ", b.width_px, " x ",
      b.height_px,
      ": the stereo file is of other cameras; calibrate this pair with acus-camera stereo");
  const double right = a.width_px - 1.0, bottom = a.height_px - 1.0;
  const std::array<Eigen::Vector2d, 5> pixels = {
      Eigen::Vector2d(0, 0), {right, 0}, {0, bottom}, {right, bottom}, {0.5 * right, 0.5 * bottom}};
  for (const Eigen::Vector2d& pixel : pixels) {
    const auto ray = in_pair.Ray(pixel);
    const auto seen = ray ? own.Project(*ray * 1000.0) : std::nullopt;
    ACUS_REQUIRE(seen && (*seen - pixel).norm() <= 1.0, "the pair's ", side, " camera '", a.name,
                 "' is not '", b.name, "': their lines of sight at pixel ", pixel[0], ", ",
                 pixel[1], " differ by ", seen ? (*seen - pixel).norm() : INFINITY,
                 " px, allowed is 1 px; name the stereo file of this pair, or calibrate it with "
                 "acus-camera stereo --left-camera and --right-camera");
  }
}

std::optional<Eigen::Vector3d> Triangulate(const StereoPair& pair, const Eigen::Vector2d& left_px,
                                           const Eigen::Vector2d& right_px) {
  const auto left_ray = pair.left.Ray(left_px);
  const auto right_ray = pair.right.Ray(right_px);
  if (!left_ray || !right_ray) return std::nullopt;
  const Eigen::Isometry3d left_from_right = pair.right_from_left.inverse();
  const Eigen::Vector3d a = left_ray->normalized();
  const Eigen::Vector3d b = (left_from_right.linear() * *right_ray).normalized();
  const Eigen::Vector3d across = a.cross(b);
  if (across.norm() < kLeastSine) return std::nullopt;
  const Eigen::Vector3d to_right = left_from_right.translation();
  const double along_a = to_right.cross(b).dot(across) / across.squaredNorm();
  const double along_b = to_right.cross(a).dot(across) / across.squaredNorm();
  if (along_a <= 0.0 || along_b <= 0.0) return std::nullopt;
  return 0.5 * (along_a * a + to_right + along_b * b);
}

}  // namespace acus::camera
