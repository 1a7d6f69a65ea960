// What every task writes: JSON with provenance, and numbers as JSON.
#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "acus/base/core/run_context.h"
#include "acus/data/transforms/landmarks.h"

namespace acus::registration {

std::string VectorText(const Eigen::Vector3d& v, int decimals);

/// registration.json and provenance.json.
void WriteResult(const std::filesystem::path& folder, nlohmann::json document,
                 const RunContext& context);

transforms::Landmarks ReadPoints(const std::filesystem::path& path, RunContext& context);

/// Three numbers, as a tip. @throws InputError if there are not three finite ones.
Eigen::Vector3d TipFrom(const std::vector<double>& numbers);

/// The tip in a pivot calibration's registration.json. @throws InputError
Eigen::Vector3d ReadTip(const std::filesystem::path& path, RunContext& context);

}  // namespace acus::registration
