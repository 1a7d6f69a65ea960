// Places and poses in JSON files.
#pragma once

#include <Eigen/Geometry>
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace acus::config {

/// The pose that the keys translation_mm (x, y, z) and quaternion_wxyz of `node` say; checked
/// against a schema already. The quaternion is normalised.
/// @param where  Names the place in messages: "devices.json: /devices/0".
/// @throws InputError if the quaternion's length is off 1 by more than 1e-3.
Eigen::Isometry3d PoseFrom(const nlohmann::json& node, const std::string& where);

/// [x, y, z].
nlohmann::json Row(const Eigen::Vector3d& v);

/// 4 x 4, row by row.
nlohmann::json MatrixRows(const Eigen::Isometry3d& pose);

/// What MatrixRows wrote, in a file of our own. @throws nlohmann::json::exception
Eigen::Isometry3d PoseFromRows(const nlohmann::json& rows);

}  // namespace acus::config
