// Rigid transforms on disk, as ITK and 3D Slicer have them.
#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <string_view>

namespace acus::transforms {

/// Writes an ITK transform file ("#Insight Transform File V1.0", AffineTransform_double_3_3).
///
/// The file holds `target_from_source` as it is: ITK's TransformPoint() takes a source point to the
/// target; both in LPS, mm. 3D Slicer reads a file the other way round, as the resampling transform
/// from parent to child: to move source things onto the target there, invert the node after
/// loading.
/// @param comment  One line; says what the transform is.
void WriteTransform(const std::filesystem::path& path, const Eigen::Isometry3d& target_from_source,
                    std::string_view comment);

/// Reads what WriteTransform wrote (same bits), and other rigid ITK text transforms: Affine and
/// MatrixOffset, Euler3D, VersorRigid3D, QuaternionRigid, Translation, Identity; with their centre,
/// and composites of them. The same kinds are read from ITK's HDF5 files (.h5).
/// A file of 16 plain numbers (4 x 4, row by row) is read too.
/// @throws InputError with file and line if it is broken, not rigid to within 1e-3, or holds
///     several transforms.
Eigen::Isometry3d ReadTransform(const std::filesystem::path& path);

/// Parses 16 numbers, row by row, separated by white space or commas, as a rigid transform.
/// @throws InputError beginning with `label`.
Eigen::Isometry3d ParseRigidMatrix(std::string_view text, const std::string& label);

}  // namespace acus::transforms
