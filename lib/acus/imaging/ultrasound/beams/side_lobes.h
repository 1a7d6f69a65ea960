// Side lobes and grating lobes: what strong reflectors beside a line add to it.
#pragma once

#include <cstdint>
#include <vector>

#include "acus/imaging/acoustics/probe.h"
#include "acus/imaging/slicing/ct_sampler.h"

namespace acus::ultrasound {

/// Weights of the elements across an aperture.
enum class Apodisation { kRectangular, kCosine, kHann };

/// Energy that a pulse keeps on its way through an array of `elements` elements that is focused at
/// sin(angle) = s0, at s0 + `sine`, one way, relative to s0:
///   sum over i, j of w_i w_j rho((i - j) pitch sine) / (sum of w)^2,
/// rho(d) = exp(-(k0 b d)^2) cos(k0 d) the autocorrelation of a pulse with a Gaussian spectrum; b
/// follows from the fractional bandwidth. For a narrow band this is the array factor with its
/// grating lobes at sine = lambda / pitch; a short pulse smears them over N pulses.
double ArrayEnergy(double pitch_over_wavelength, int elements, double sine,
                   double fractional_bandwidth, Apodisation apodisation);

/// Amplitude that one element sends at an angle to its normal, relative to the normal: a piston in
/// a soft baffle, sinc(width sin / lambda) cos (Selfridge, Kino, Khuri-Yakub, A theory for the
/// radiation pattern of a narrow-strip acoustic transducer, Appl. Phys. Lett. 37:35, 1980).
double ElementDirectivity(double width_over_wavelength, double sine);

/// Two-way intensity at an angle from the line, relative to the line: ArrayEnergy of the
/// transmitting and of the receiving aperture at a depth; for the second harmonic the square of the
/// first times the second at twice the frequency. Without the directivity of elements.
double LobeIntensity(const acoustics::Probe& probe, Apodisation apodisation, double depth_mm,
                     double sine);

/// Spreads the intensity of strong echoes along arcs of equal range to the lines beside them, by
/// LobeIntensity, ElementDirectivity and the lobe of a rough mirror that faces the reflector's own
/// line; a phased probe sees reflectors from one place, so that the first alone counts. Within the
/// main lobe nothing is added: that is the point spread. What is fainter than kFaintest is omitted
/// before any image: a probe without visible lobes costs nothing.
class SideLobes {
 public:
  static constexpr double kFaintest = 1e-7;  ///< Intensity: -70 dB.
  /// Share of the pitch that an element fills. Estimate.
  static constexpr double kElementShare = 0.9;

  /// @param rows  Rows of tissue, along the scan lines; kept by reference.
  SideLobes(const acoustics::Probe& probe, const acoustics::ScanGrid& rows, Apodisation apodisation,
            double lobe_deg, double diffuse_share);

  bool any() const { return any_; }

  /// @param echoes  Intensity of interfaces and needle, by row and line.
  void Spread(const slicing::BeamImage& echoes);
  /// What is added to the intensity of a row, by line.
  const float* added(int row) const { return added_.row(row); }

 private:
  /// Where the echo of a reflector appears in another line.
  struct Ghost {
    float level = 0.0F;      ///< Intensity in each of its rows; 0: not visible.
    std::int16_t first = 0;  ///< Row, from that of the reflector.
    std::int16_t count = 0;
  };
  double LineOfBin(int bin) const;
  void MakeGhosts(const acoustics::Probe& probe, Apodisation apodisation, double lobe_deg,
                  double diffuse_share);

  const acoustics::ScanGrid& rows_;
  int lines_per_bin_;
  int bins_;
  int rows_per_step_;
  int steps_;
  bool any_ = false;
  std::vector<Ghost> ghosts_;  ///< By step of depth, bin of the reflector, bin of the line.
  std::vector<float> cells_;   ///< Main lobes in a bin, by step of depth.
  std::vector<float> sums_;    ///< Changes from row to row, by bin.
  slicing::BeamImage added_;
};

}  // namespace acus::ultrasound
