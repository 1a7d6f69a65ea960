// Echo intensities to an image: windows of pulse and beam, logarithmic compression, scan
// conversion.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "acus/data/image/image.h"
#include "acus/imaging/acoustics/probe.h"
#include "acus/imaging/slicing/ct_sampler.h"
#include "acus/imaging/ultrasound/display/scan_conversion.h"

namespace acus::ultrasound {

/// Half of a symmetric Hanning window, w[t] = (1 + cos(2 pi t spacing / length)) / 2 scaled so that
/// the whole window sums to 1. One entry, 1, if the length is below two spacings.
/// @throws InputError if more than `max_half` + 1 entries come out.
std::vector<float> HalfHanning(double length_mm, double spacing_mm, int max_half);

/// Share of white that the probe's gain adds to an image made by a table of greys, which holds for
/// `gain_of_table_db` (dB; nothing: for the probe's gain). Greys are logarithmic: every dB adds
/// 1 / dynamic range.
double BrightnessOfGain(const acoustics::Probe& probe, std::optional<double> gain_of_table_db);

/// Grey = 255 * log(1 + a I) / log(1 + a), a = 10^(dynamic range / 10), where I is the windowed
/// intensity times the gains: the pulse's window has a peak of 1, the beam's a sum of 1.
/// Deterministic with any number of threads.
class EchoDisplay {
 public:
  /// @throws InputError if a window covers too many samples or lines.
  EchoDisplay(const acoustics::Probe& probe, const acoustics::ScanGrid& grid);

  /// Margins of `echo` are not read. Fills all of `out`.
  void Show(const slicing::BeamImage& echo, image::GrayImage& out, int num_threads);

 private:
  void CompressLine(const slicing::BeamImage& echo, int k, float* scratch,
                    std::uint8_t* grey) const;

  ScanConversion conversion_;
  std::vector<float> along_;   ///< Half window, samples.
  std::vector<float> across_;  ///< Half window, lines.
  std::vector<float> gain_;    ///< a times the gains, by sample.
  float scale_ = 0.0F;
  slicing::BeamImage scratch_;  ///< Two rows per piece of work.
};

}  // namespace acus::ultrasound
