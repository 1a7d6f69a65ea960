// Makes what 3D Slicer saves: ITK transforms as HDF5, bundles as zip.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <map>
#include <string>

namespace acus::testing_support {

/// The bytes of an ITK .h5 file with an affine transform: 3 x 3, row by row, then the translation;
/// and the centre. As ITK stores it: LPS, from the parent frame.
std::string ItkTransformFile(const Eigen::Matrix4d& lps_from_parent, const Eigen::Vector3d& centre,
                             const std::filesystem::path& scratch);

/// The bytes of a zip archive with these files.
std::string ZipFile(const std::map<std::string, std::string>& files,
                    const std::filesystem::path& scratch);

}  // namespace acus::testing_support
