// Connective tissue that no CT resolves: fascicles of muscle, how their echo depends on the angle
// of the beam, and septa between lobules of fat.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "acus/imaging/slicing/kernels.h"
#include "acus/imaging/ultrasound/beams/beam_options.h"
#include "acus/imaging/ultrasound/columns/fibre_kernels.h"

namespace acus::ultrasound {

/// Backscattered intensity under an angle between beam and fibres, relative to a beam across them:
/// 10^(-2 cos^2). At 45 degrees it is 10 dB lower, as in soleus of rats (Topp and O'Brien,
/// Anisotropy of ultrasonic propagation and scattering properties in fresh rat skeletal muscle in
/// vitro, J. Acoust. Soc. Am. 107:1027, 2000); its end along the fibres, -20 dB, is an estimate.
double FibreIntensity(double cosine);

/// Changes the scatterers of labelled tissues by sheets of connective tissue, fixed in the tissue
/// at rest.
///
/// Tissues with fibres: by FibreIntensity, and by sheets of perimysium along the fibres. Each
/// fascicle is about 2 mm wide and some centimetres long; a sheet that faces the beam sends back
/// 30 dB more than what it encloses, one that is turned by 30 degrees 22 dB (chosen on recorded
/// frames of a leg). The mean of tissue across the beam, in dB, does not change.
///
/// The label "fat": septa around lobules of about 6 mm, without a direction of their own; one that
/// faces the beam sends back 20 dB more than the lobules (estimate). The label "soft_tissue" of a
/// CT whose muscles are not labelled: fasciae 3 mm apart from head to foot, as strong (estimate).
/// The mean of both in dB does not change.
class FibreStreaks {
 public:
  /// Reads the labels once; keeps one byte per voxel. @pre tissue has labels.
  /// @param tissue  Its fibres_in_ct name the tissues and their directions.
  FibreStreaks(const BeamTissue& tissue, std::uint64_t seed);

  bool any() const { return !sheets_.empty(); }

  /// Multiplies intensity of scatterers at sample `s` of each lane, in the tissue at rest.
  /// @pre at most kMostLanes; rows are as long as the next multiple of kBlock lanes.
  static constexpr int kMostLanes = 64;
  void ApplyRow(const slicing::kernels::Lines& lines, float s, int lanes, float* intensity) const;

 private:
  /// How the sheets of one tissue lie and answer.
  struct Law {
    double across_mm;
    double along_mm;
    double fibre_nepers;
    double half_thickness;  ///< In units of the noise.
    double between;
    double sheet;
    double lobe_deg;
    double diffuse_share;
  };
  static const Law kMuscle;
  static const Law kFat;
  static const Law kSoft;
  void Add(const Law& law, const Eigen::Vector3d& along_in_voxels);

  std::uint32_t seed_;
  std::vector<kernels::SheetRow> sheets_;  ///< Without the row.
  std::vector<std::uint32_t> codes_;       ///< By voxel a byte. 0: none; else number of sheets + 1.
  Eigen::Array3i size_;
  Eigen::Array3d spacing_mm_;
};

}  // namespace acus::ultrasound
