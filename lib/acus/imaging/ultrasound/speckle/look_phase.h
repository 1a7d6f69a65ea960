// The phase of scatterers under steered lines: why images of several angles have other speckle.
#pragma once

#include <vector>

#include "acus/data/image/image.h"
#include "acus/imaging/acoustics/probe.h"
#include "acus/imaging/ultrasound/beams/beam_kernels.h"

namespace acus::ultrasound {

/// Scatterers are random complex numbers, fixed to the tissue, without a carrier. What matters
/// between two images is the difference of the carrier's phase, 2 k (S - S0), k the wave number at
/// the received frequency. S is the range along lines that leave the face under the angle a, S0
/// that along its normals (both the eikonal of their family of lines):
///   S - S0 = s sin(a) + r - r0(r),
/// s the place of a line along the face, r the range along it, and r0 the depth below the face at
/// that place, r cos(a) for a flat face. Two images are then correlated by
/// |integral h^2 exp(2 i k sin(a) x) dx|^2 / (integral h^2)^2, h the point spread across.
class LookPhase {
 public:
  /// @param grain_sigma_mm  Of the noise: a grain through which the phase turns gives less, and is
  ///     made up for by gain().
  LookPhase(const acoustics::Probe& probe, const acoustics::ScanGrid& grid, double grain_sigma_mm);

  bool on() const { return !rows_.empty(); }
  float gain() const { return gain_; }
  /// Sets the turn of row `k`, for lanes from `first`; nothing if the lines are not steered.
  void Set(int k, int first, kernels::SpeckleRow& row) const;

 private:
  struct Turn {
    float re = 1.0F;
    float im = 0.0F;
  };
  float gain_ = 1.0F;
  image::AlignedFloats lanes_[2];  ///< Real and imaginary parts.
  std::vector<Turn> rows_;         ///< By sample; empty: not steered.
};

}  // namespace acus::ultrasound
