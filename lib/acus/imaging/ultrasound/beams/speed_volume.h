// The patient's speed of sound on the CT grid.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "acus/data/volume/geometry.h"
#include "acus/imaging/slicing/kernels.h"
#include "acus/imaging/ultrasound/beams/beam_materials.h"
#include "acus/imaging/ultrasound/beams/beam_options.h"

namespace acus::ultrasound {

/// Refractive index n = c0 / c of each voxel, c0 = 1540 m/s, smoothed by a binomial window of one
/// voxel along each axis, so that stairs of labels bend no rays. In one byte: within 0.0008 for
/// soft tissue, 0.005 for bone. Gas, and what lies around the patient, count as gel of c0: sound
/// that meets gas does not continue.
class SpeedVolume {
 public:
  /// Reads labels and CT once; keeps nothing of them.
  SpeedVolume(const BeamTissue& tissue, const BeamMaterials& materials);

  /// index[l] = n at sample `s` of each lane, trilinear; beyond the grid that of its edge.
  void SampleRow(const slicing::kernels::Lines& lines, float s, int lanes, float* index) const;

 private:
  template <typename CodeAt>
  void Smooth(const CodeAt& code_at);

  std::array<float, 256> index_of_code_{};
  std::vector<std::uint8_t> code_;
  Eigen::Array3i size_;
};

}  // namespace acus::ultrasound
