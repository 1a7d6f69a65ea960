// Differences of two grey images: PSNR and structural similarity.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

namespace acus::comparison {

/// A view of a grey image, row by row. @pre pixels.size() == width * height.
struct GrayView {
  int width = 0;
  int height = 0;
  std::span<const std::uint8_t> pixels;
};

/// Mean of the squared differences, grey levels^2. @pre same size, not empty.
double MeanSquaredError(const GrayView& a, const GrayView& b);

/// Peak signal-to-noise ratio for 8 bits: 10 log10(255^2 / mse); nothing if mse is 0 (identical).
std::optional<double> PsnrDb(double mean_squared_error);

/// Mean structural similarity (Wang, Bovik, Sheikh & Simoncelli 2004, doi:10.1109/TIP.2003.819861):
/// Gaussian window of 11 x 11 with sigma 1.5, K1 = 0.01, K2 = 0.03, range 255, over all positions
/// where the window fits. 1 for identical images. An image smaller than the window in a direction
/// has one window of its whole length there. @pre same size, not empty.
double Ssim(const GrayView& a, const GrayView& b);

}  // namespace acus::comparison
