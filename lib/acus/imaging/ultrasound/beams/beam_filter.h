// The point spread of the probe: complex echoes of all lines to intensities.
#pragma once

#include <vector>

#include "acus/imaging/acoustics/probe.h"
#include "acus/imaging/slicing/ct_sampler.h"
#include "acus/imaging/ultrasound/beams/beam_options.h"
#include "acus/imaging/ultrasound/speckle/look_phase.h"

namespace acus::ultrasound {

/// Echoes before the point spread, in phase and in quadrature.
struct ComplexBeams {
  slicing::BeamImage re;
  slicing::BeamImage im;
};

/// A separable window, Gaussian along and across the beam (widths: beam_width.h), whose width
/// across varies with depth. The peak along the beam is 1 and the sum across is 1: a flat reflector
/// gives an envelope of its reflection. The grain of the speckle is part of the window: speckle is
/// filtered by the rest, and the echoes of interfaces are spread by Spread() first.
class BeamFilter {
 public:
  /// @throws InputError if the pulse covers more samples than the window may.
  BeamFilter(const acoustics::Probe& probe, const BeamOptions& options,
             const acoustics::ScanGrid& grid);

  double grain_mm() const { return grain_mm_; }  ///< Lattice of the speckle.
  /// Phase of the speckle under steered lines.
  const LookPhase& look() const { return look_; }
  /// Gain of the speckle of one sample, so that its envelope has the root mean square requested.
  float SpeckleGain(int k) const { return speckle_gain_[static_cast<std::size_t>(k)]; }
  /// Gain of white noise, one complex number per sample, so that its envelope has a root mean
  /// square of 1.
  float NoiseGain(int k) const { return noise_gain_[static_cast<std::size_t>(k)]; }
  /// Width of the window across over that along the beam, in mm.
  double AcrossOverAlong(int k) const { return across_over_along_[static_cast<std::size_t>(k)]; }
  /// Shares of an echo that lies `fraction` (-0.5 to 0.5) of a sample beside a sample: of that
  /// sample and of the neighbour on that side. The filtered echo peaks at 1 on the grid wherever it
  /// lies, and the neighbour is as strong as a pulse at the true place makes it.
  struct Shares {
    double nearest = 1.0;
    double neighbour = 0.0;
  };
  Shares SharesAt(double fraction) const;
  /// Window that an interface is spread with along the beam: half of it, with the middle.
  const std::vector<float>& Spread() const { return spread_; }

  /// Rows [first, last) of `intensity`, from echoes with any margins.
  /// @param scratch  Two rows of at least in.re.stride() floats, aligned.
  void Apply(const ComplexBeams& in, int first, int last, float* scratch,
             slicing::BeamImage& intensity) const;

 private:
  void MakeAxial(const acoustics::Probe& probe, double reach);
  void MakeLateral(const acoustics::Probe& probe, double reach);

  const acoustics::ScanGrid& grid_;
  bool on_;
  double grain_mm_ = 0.0;
  double grain_sigma_mm_ = 0.0;
  LookPhase look_;
  double pulse_at_neighbour_ = 0.0;  ///< Filtered echo of a sample at the next one.
  std::vector<float> along_;
  std::vector<float> spread_;
  std::vector<float> speckle_gain_;
  std::vector<float> noise_gain_;
  std::vector<double> across_over_along_;
  std::vector<int> across_half_;  ///< By sample.
  std::vector<std::size_t> across_at_;
  std::vector<float> across_;
};

}  // namespace acus::ultrasound
