// Makes what 3D Slicer saves: ITK transforms as HDF5, bundles as zip.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace acus::testing_support {

/// The bytes of an ITK .h5 file with an affine transform: 3 x 3, row by row, then the translation;
/// and the centre. As ITK stores it: LPS, from the parent frame.
std::string ItkTransformFile(const Eigen::Matrix4d& lps_from_parent, const Eigen::Vector3d& centre,
                             const std::filesystem::path& scratch);

struct ItkTransformPart {
  std::string type;  ///< AffineTransform_double_3_3, ...
  std::vector<double> parameters;
  std::vector<double> fixed;
};

/// The bytes of an ITK .h5 file of these transforms. A composite has no numbers.
std::string ItkTransformsFile(const std::vector<ItkTransformPart>& parts,
                              const std::filesystem::path& scratch);

/// The bytes of a zip archive with these files.
std::string ZipFile(const std::map<std::string, std::string>& files,
                    const std::filesystem::path& scratch);

}  // namespace acus::testing_support
