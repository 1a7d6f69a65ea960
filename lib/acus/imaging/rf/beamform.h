// Delay and sum: channel data to an image with phase.
#pragma once

#include <complex>
#include <vector>

#include "acus/imaging/rf/analytic.h"
#include "acus/imaging/rf/array.h"
#include "acus/imaging/rf/transmit.h"

namespace acus::rf {

/// Weights across the aperture: 1, or 0.5 (1 + cos(2 pi u)), u in [-0.5, 0.5] across it.
enum class Apodisation { kRectangular, kHann };

/// Pixel (c, r) is at x = first_mm.x() + c step_mm.x(), depth first_mm.y() + r step_mm.y().
struct PixelGrid {
  Eigen::Vector2d first_mm = Eigen::Vector2d::Zero();
  Eigen::Vector2d step_mm = Eigen::Vector2d::Ones();
  int columns = 0;
  int rows = 0;

  Eigen::Vector2d At(int column, int row) const {
    return first_mm + step_mm.cwiseProduct(Eigen::Vector2d(column, row));
  }
};

struct BeamformOptions {
  double sound_speed_mm_per_us = 1.54;
  double f_number = 1.5;  ///< Depth below an element over the aperture; 0: all elements.
  Apodisation apodisation = Apodisation::kRectangular;
};

/// values[row * columns + column]: the analytic signal. Its magnitude is the envelope, its real
/// part the RF.
struct IqImage {
  PixelGrid grid;
  std::vector<std::complex<float>> values;

  std::complex<float> At(int column, int row) const {
    return values[static_cast<std::size_t>(row) * grid.columns + column];
  }
};

/// The coherent mean over all transmissions and over the elements of the aperture. Places that no
/// element records are 0. The same bits with any number of threads.
/// @throws InputError if the number of elements or transmissions differs from that of the data, or
///     the grid or an option is out of range.
IqImage DelayAndSum(const Baseband& data, const Array& array,
                    const std::vector<Transmit>& transmits, const PixelGrid& grid,
                    const BeamformOptions& options, int num_threads);

/// |values|, by pixel.
std::vector<float> Envelope(const IqImage& image);

}  // namespace acus::rf
