// Fascicles of muscle: how their echo depends on the angle of the beam, and the streaks between
// them.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "acus/imaging/slicing/kernels.h"
#include "acus/imaging/ultrasound/beams/beam_options.h"

namespace acus::ultrasound {

/// Backscattered intensity under an angle between beam and fibres, relative to a beam across them:
/// 10^(-2 cos^2). At 45 degrees it is 10 dB lower, as in soleus of rats (Topp and O'Brien,
/// Anisotropy of ultrasonic propagation and scattering properties in fresh rat skeletal muscle in
/// vitro, J. Acoust. Soc. Am. 107:1027, 2000); its end along the fibres, -20 dB, is an estimate.
double FibreIntensity(double cosine);

/// Changes the scatterers of labelled tissues with fibres: by FibreIntensity, and by sheets of
/// perimysium along the fibres. Each fascicle is about 2 mm wide and some centimetres long; a sheet
/// that faces the beam sends back 30 dB more than what it encloses, one that is turned by 30
/// degrees 22 dB (chosen on recorded frames of a leg). The mean of tissue across the beam, in dB,
/// does not change.
class FibreStreaks {
 public:
  /// Reads the labels once; keeps one byte per voxel. @pre tissue has labels.
  /// @param tissue  Its fibres_in_ct name the tissues and their directions.
  FibreStreaks(const BeamTissue& tissue, std::uint64_t seed);

  bool any() const { return !fibres_.empty(); }

  /// Multiplies intensity of scatterers at sample `s` of each lane, in the tissue at rest.
  void ApplyRow(const slicing::kernels::Lines& lines, float s, int lanes, float* intensity) const;

 private:
  struct Fibre {
    Eigen::Matrix3f cells_from_index;  ///< Fascicles: across, across, along.
    Eigen::Vector3f along;             ///< Unit, mm along the voxel axes.
  };
  /// Noise whose middle level is a sheet, and its slope from cell to cell.
  struct Sheet {
    float noise;
    Eigen::Vector3f slope;
  };
  Sheet SheetAt(const Eigen::Vector3f& cell) const;

  std::uint32_t seed_;
  std::vector<Fibre> fibres_;
  std::vector<std::uint8_t> code_;  ///< 0: no fibres; else number of the fibre + 1.
  Eigen::Array3i size_;
  Eigen::Array3f spacing_mm_;
};

}  // namespace acus::ultrasound
