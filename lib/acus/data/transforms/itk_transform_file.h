// Affine transforms in ITK's HDF5 files, as 3D Slicer saves them.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <string>

namespace acus::transforms {

/// The affine transform of an ITK transform file (.h5) that was read into memory. ITK works in LPS
/// and its transforms resample: this maps points of the parent frame to the node's own frame, mm.
/// @throws InputError naming `label` if the bytes are not such a file, or it holds another kind of
///     transform than one affine 3D transform of 12 parameters.
Eigen::Matrix4d ReadItkAffine(std::span<const std::uint8_t> bytes, const std::string& label);

/// What Slicer shows as "transform to parent" (RAS), from an ITK transform (LPS, from parent).
/// @throws InputError naming `label` if it has no inverse.
Eigen::Matrix4d RasToParentFromItk(const Eigen::Matrix4d& lps_from_parent,
                                   const std::string& label);

}  // namespace acus::transforms
