// What a phase shows of tissue that the reference does not hold: it came in over the border.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "acus/patient/breathing_registration/sliding_grid.h"

namespace acus::breathing_registration {

/// Places of a phase where no tissue of the reference can be: within as much of a face of the
/// volume as the tissue at that face has moved inwards. What is seen there has no match, however
/// similar it looks. A value; const access from any number of threads.
class EnteredTissue {
 public:
  /// As the field says.
  EnteredTissue(const SlidingGrid& grid, const SlidingGrid::Field& displacement_voxels);
  /// As if everything within `depth_voxels` of a face had come in: before any motion is known.
  EnteredTissue(const SlidingGrid& grid, float depth_voxels);

  /// @param at  Place in the phase, in voxels of the grid.
  bool Holds(const Eigen::Vector3f& at) const noexcept;

 private:
  struct Face {
    std::vector<float> depth;  ///< In voxels from the face, of each column of nodes.
    bool any = false;
  };

  /// Calls `depth_of(node)` for the outermost node of each column that begins at a face.
  template <class DepthOf>
  void FillFaces(const SlidingGrid& grid, const DepthOf& depth_of);

  Eigen::Array3i size_;
  std::array<Face, 6> faces_;  ///< Low and high of each axis.
};

}  // namespace acus::breathing_registration
