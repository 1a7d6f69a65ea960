#include "acus/base/config/pose_json.h"

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "acus/base/core/error.h"

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

nlohmann::json Row(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

nlohmann::json MatrixRows(const Eigen::Isometry3d& pose) {
  nlohmann::json rows = nlohmann::json::array();
  for (int i = 0; i < 4; ++i) {
    const Eigen::RowVector4d row = pose.matrix().row(i);
    rows.push_back({row[0], row[1], row[2], row[3]});
  }
  return rows;
}

Eigen::Isometry3d PoseFromRows(const nlohmann::json& rows) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 4; ++c) pose(r, c) = rows.at(r).at(c).get<double>();
  }
  return pose;
}

}  // namespace acus::config
