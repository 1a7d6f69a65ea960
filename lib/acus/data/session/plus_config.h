// Calibrations from PLUS device-set files.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>

namespace acus::session {

/// The coordinate definitions of a PLUS configuration (PlusDeviceSet_*.xml), such as ImageToProbe
/// (pixels to mm), by name: what ImportOptions::calibrations takes.
/// @throws InputError if the file is not such a configuration, or a matrix is not 16 finite
/// numbers.
std::map<std::string, Eigen::Matrix4d> ReadPlusCalibrations(const std::filesystem::path& path);

/// Writes one calibration as the coordinate definitions of a PLUS configuration, atomically:
/// ReadPlusCalibrations gives the same bits back under the name `from` + "To" + `to`.
/// @param error_mm  PLUS's attribute Error, RMS.
void WritePlusCalibration(const std::filesystem::path& path, std::string_view from,
                          std::string_view to, const Eigen::Matrix4d& to_from_from,
                          double error_mm);

}  // namespace acus::session
