// How far a patient's motion may be from the truth, place by place: bound.raw (32-bit floats, mm,
// i fastest) of a motion folder, and bound.nhdr, by which other programs read it as a NRRD.
#pragma once

#include <filesystem>
#include <vector>

#include "acus/data/volume/geometry.h"

namespace acus::breathing {

/// At 95 of 100 places the displacement is no farther from the truth than this, in mm, at the end
/// of a normal inspiration. A value; const access from any number of threads.
class MotionBound {
 public:
  /// The file's name in its folder.
  static constexpr const char* kFile = "bound.raw";

  /// @param at_nodes_mm  i fastest; 0 where there is no tissue.
  /// @throws InputError for another number of values than nodes, or one that is negative or not
  ///     finite.
  MotionBound(const volume::Geometry& nodes, std::vector<float> at_nodes_mm);

  /// mm. Between the nodes trilinear over those with tissue; 0 beyond the grid and where there is
  /// none.
  /// @param normal_level  Of a breath whose levels run from 0 to 1: the bound grows with it, as the
  ///     displacement does. Below a fifth as at a fifth: hysteresis and noise are left.
  double Mm(const Eigen::Vector3d& rest_in_ct_mm, double normal_level) const noexcept;

  const volume::Geometry& nodes() const { return nodes_; }
  const std::vector<float>& at_nodes_mm() const { return at_nodes_mm_; }

 private:
  volume::Geometry nodes_;
  Eigen::Affine3d index_from_ct_;
  std::vector<float> at_nodes_mm_;
};

/// Writes bound.raw and bound.nhdr into a folder that is there; not atomically.
/// @throws InputError if writing fails.
void WriteMotionBound(const std::filesystem::path& folder, const MotionBound& bound);

/// @throws InputError if the file is missing, or has another size than the nodes require, or holds
///     a value that is not one.
MotionBound ReadMotionBound(const std::filesystem::path& file, const volume::Geometry& nodes);

}  // namespace acus::breathing
