#include "config/pose_json.h"

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/error.h"

namespace acus::config {

Eigen::Isometry3d PoseFrom(const nlohmann::json& node, const std::string& where) {
  const auto t = node.at("translation_mm").get<std::array<double, 3>>();
  const auto q = node.at("quaternion_wxyz").get<std::array<double, 4>>();
  const Eigen::Quaterniond rotation(q[0], q[1], q[2], q[3]);
  ACUS_REQUIRE(std::abs(rotation.norm() - 1.0) <= 1e-3, where, "/quaternion_wxyz: has length ",
               rotation.norm(), "; it must be 1");
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = rotation.normalized().toRotationMatrix();
  pose.translation() = Eigen::Vector3d(t[0], t[1], t[2]);
  return pose;
}

}  // namespace acus::config
