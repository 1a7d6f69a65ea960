// The planned path of the needle, from the patient's corridor.
#pragma once

#include <Eigen/Core>
#include <filesystem>

namespace acus::simulation {

struct NeedleLine {
  Eigen::Vector3d entry_in_ct_mm;
  Eigen::Vector3d way_mm;  ///< From the entry to the target.
};

/// @param corridor  CSV of points in CT space.
/// @throws InputError if entry or target is missing, or they are less than 1 mm apart.
NeedleLine ReadNeedleLine(const std::filesystem::path& corridor);

}  // namespace acus::simulation
