// Transforms in ITK's HDF5 files, as ITK, ANTs and 3D Slicer save them. They are read in a separate
// process: libhdf5 crashes on some damaged files.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace acus::transforms {

/// One transform of a file: a kind of ITK such as AffineTransform_double_3_3, and its numbers.
struct ItkTransform {
  std::string type;
  std::vector<double> parameters;
  std::vector<double> fixed;
};

/// All transforms of an ITK transform file (.h5) that was read into memory, in its order. A
/// composite transform is the first, without numbers, before its parts.
/// @throws InputError naming `label` if the bytes are not such a file, or a transform has more than
///     64 numbers, as B-splines and displacement fields have.
std::vector<ItkTransform> ReadItkTransforms(std::span<const std::uint8_t> bytes,
                                            const std::string& label);

/// A file in memory, once it is read, and what messages name it.
struct ItkTransformSource {
  std::string label;
  std::function<std::vector<std::uint8_t>()> read;  ///< Called in a separate process.
};

/// The affine transform of each of several ITK transform files (.h5), LPS, mm. ITK's transforms
/// resample: each maps points of the parent frame to the node's own frame.
/// @throws InputError naming its label if one is not such a file, or holds another kind of
/// transform
///     than one affine 3D transform of 12 parameters; and what `read` throws, as InputError.
std::vector<Eigen::Matrix4d> ReadItkAffines(const std::vector<ItkTransformSource>& files);

/// What Slicer shows as "transform to parent" (RAS), from an ITK transform (LPS, from parent).
/// @throws InputError naming `label` if it has no inverse.
Eigen::Matrix4d RasToParentFromItk(const Eigen::Matrix4d& lps_from_parent,
                                   const std::string& label);

}  // namespace acus::transforms
