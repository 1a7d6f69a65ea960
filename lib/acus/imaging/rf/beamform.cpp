#include "acus/imaging/rf/beamform.h"

#include <cmath>
#include <numbers>

#include "acus/base/core/error.h"
#include "acus/base/core/parallel.h"

namespace acus::rf {
namespace {

using Complexf = std::complex<float>;

/// An element that takes part in a pixel.
struct Tap {
  int element = 0;
  double path_us = 0.0;
  Complexf weight;  ///< Apodisation, and the phase of the carrier over the path back.
};

double ApertureWeight(Apodisation apodisation, double across) {
  if (apodisation == Apodisation::kRectangular) return 1.0;
  return 0.5 * (1.0 + std::cos(2.0 * std::numbers::pi * across));
}

/// exp(2 pi i cycles).
Complexf Phasor(double cycles) {
  const auto phase = static_cast<float>(2.0 * std::numbers::pi * (cycles - std::floor(cycles)));
  return {std::cos(phase), std::sin(phase)};
}

/// @return the sum of the weights.
float FindTaps(const Array& array, const BeamformOptions& options, double carrier_mhz,
               const Eigen::Vector2d& place_mm, std::vector<Tap>& taps) {
  taps.clear();
  double sum = 0.0;
  for (std::size_t e = 0; e < array.elements.size(); ++e) {
    const Element& element = array.elements[e];
    const Eigen::Vector2d path_mm = place_mm - element.position_mm;
    const double depth_mm = element.normal.dot(path_mm);
    if (depth_mm <= 0.0) continue;
    const double aside_mm = element.normal.y() * path_mm.x() - element.normal.x() * path_mm.y();
    // Within +-0.5 across the aperture that the F-number allows.
    const double across = options.f_number * aside_mm / depth_mm;
    if (std::abs(across) > 0.5) continue;
    const double weight = ApertureWeight(options.apodisation, across);
    const double path_us = path_mm.norm() / options.sound_speed_mm_per_us;
    taps.push_back(
        {static_cast<int>(e), path_us, static_cast<float>(weight) * Phasor(path_us * carrier_mhz)});
    sum += weight;
  }
  return static_cast<float>(sum);
}

/// The weighted sum of one transmission over the taps, linearly interpolated; the phase of its
/// arrival is still missing.
Complexf SumOverAperture(const Baseband& data, int transmit, double arrival_us,
                         const std::vector<Tap>& taps) {
  const double rate = data.sampling_mhz;
  const double start = (arrival_us - data.start_us) * rate;
  const double last = data.samples - 1;
  float re = 0.0F;
  float im = 0.0F;
  for (const Tap& tap : taps) {
    const double at = start + tap.path_us * rate;
    if (!(at >= 0.0 && at < last)) continue;
    const int k = static_cast<int>(at);
    const auto part = static_cast<float>(at - k);
    const Complexf* trace = data.Trace(transmit, tap.element) + k;
    const float value_re = trace[0].real() + part * (trace[1].real() - trace[0].real());
    const float value_im = trace[0].imag() + part * (trace[1].imag() - trace[0].imag());
    re += tap.weight.real() * value_re - tap.weight.imag() * value_im;
    im += tap.weight.real() * value_im + tap.weight.imag() * value_re;
  }
  return {re, im};
}

void CheckInputs(const Baseband& data, const Array& array, const std::vector<Transmit>& transmits,
                 const PixelGrid& grid, const BeamformOptions& options) {
  ACUS_REQUIRE(static_cast<int>(array.elements.size()) == data.elements,
               "delay and sum: the data are of ", data.elements, " elements, the probe has ",
               array.elements.size());
  ACUS_REQUIRE(static_cast<int>(transmits.size()) == data.transmits,
               "delay and sum: the data have ", data.transmits, " transmissions, the settings ",
               transmits.size());
  ACUS_REQUIRE(grid.columns >= 1 && grid.rows >= 1 && grid.columns <= 16384 && grid.rows <= 65536,
               "delay and sum: the grid is ", grid.columns, " x ", grid.rows,
               "; between 1 x 1 and 16384 x 65536 are allowed");
  ACUS_REQUIRE(grid.first_mm.allFinite() && grid.step_mm.allFinite(),
               "delay and sum: the grid has a place that is not a finite number");
  ACUS_REQUIRE(options.f_number >= 0.0 && options.sound_speed_mm_per_us > 0.0,
               "delay and sum: the F-number is ", options.f_number, ", the speed of sound ",
               options.sound_speed_mm_per_us, " mm/us; at least 0 and above 0 are needed");
}

}  // namespace

IqImage DelayAndSum(const Baseband& data, const Array& array,
                    const std::vector<Transmit>& transmits, const PixelGrid& grid,
                    const BeamformOptions& options, int num_threads) {
  CheckInputs(data, array, transmits, grid, options);
  std::vector<TransmitTiming> timings;
  for (const Transmit& transmit : transmits) {
    timings.emplace_back(array, transmit, options.sound_speed_mm_per_us);
  }
  IqImage image{grid, {}};
  image.values.resize(static_cast<std::size_t>(grid.columns) * grid.rows);
  ParallelFor(grid.rows, num_threads, [&](int row) {
    std::vector<Tap> taps;
    for (int column = 0; column < grid.columns; ++column) {
      const Eigen::Vector2d place_mm = grid.At(column, row);
      const float weights = FindTaps(array, options, data.carrier_mhz, place_mm, taps);
      Complexf sum{};
      for (int t = 0; t < data.transmits; ++t) {
        const double arrival_us = timings[static_cast<std::size_t>(t)].ArrivalUs(place_mm);
        sum += SumOverAperture(data, t, arrival_us, taps) *
               Phasor((arrival_us - data.start_us) * data.carrier_mhz);
      }
      if (weights > 0.0F) sum /= weights * static_cast<float>(data.transmits);
      image.values[static_cast<std::size_t>(row) * grid.columns + column] = sum;
    }
  });
  return image;
}

std::vector<float> Envelope(const IqImage& image) {
  std::vector<float> out;
  out.reserve(image.values.size());
  for (const Complexf& value : image.values) out.push_back(std::abs(value));
  return out;
}

}  // namespace acus::rf
