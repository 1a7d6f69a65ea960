// Calibrations from PLUS device-set files.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <map>
#include <string>

namespace acus::session {

/// The coordinate definitions of a PLUS configuration (PlusDeviceSet_*.xml), such as ImageToProbe
/// (pixels to mm), by name: what ImportOptions::calibrations takes.
/// @throws InputError if the file is not such a configuration, or a matrix is not 16 finite
/// numbers.
std::map<std::string, Eigen::Matrix4d> ReadPlusCalibrations(const std::filesystem::path& path);

}  // namespace acus::session
