#include "acus/imaging/ultrasound/speckle/binomial_window.h"

#include <algorithm>

namespace acus::ultrasound {

void SmoothSlice(std::vector<float>& slice, int nx, int ny, std::vector<float>& scratch) {
  const auto row_size = static_cast<std::size_t>(nx + 2 * kBinomialReach);
  scratch.resize(row_size + slice.size());
  float* const row = scratch.data();
  float* const kept = scratch.data() + row_size;
  for (int y = 0; y < ny; ++y) {
    const float* at = slice.data() + static_cast<std::ptrdiff_t>(y) * nx;
    float* out = kept + static_cast<std::ptrdiff_t>(y) * nx;
    std::fill_n(row, kBinomialReach, at[0]);
    std::copy_n(at, nx, row + kBinomialReach);
    std::fill_n(row + kBinomialReach + nx, kBinomialReach, at[nx - 1]);
    for (int x = 0; x < nx; ++x) {
      out[x] = kBinomial[0] * (row[x] + row[x + 4]) + kBinomial[1] * (row[x + 1] + row[x + 3]) +
               kBinomial[2] * row[x + 2];
    }
  }
  const auto line = [&](int y) {
    return kept + static_cast<std::ptrdiff_t>(std::clamp(y, 0, ny - 1)) * nx;
  };
  for (int y = 0; y < ny; ++y) {
    float* out = slice.data() + static_cast<std::ptrdiff_t>(y) * nx;
    const float* a = line(y - 2);
    const float* b = line(y - 1);
    const float* c = line(y);
    const float* d = line(y + 1);
    const float* e = line(y + 2);
    for (int x = 0; x < nx; ++x) {
      out[x] = kBinomial[0] * (a[x] + e[x]) + kBinomial[1] * (b[x] + d[x]) + kBinomial[2] * c[x];
    }
  }
}

void SmoothAcrossSlices(const std::array<const float*, 5>& slices, std::size_t count, float* out) {
  const float* a = slices[0];
  const float* b = slices[1];
  const float* c = slices[2];
  const float* d = slices[3];
  const float* e = slices[4];
  for (std::size_t n = 0; n < count; ++n) {
    out[n] = kBinomial[0] * (a[n] + e[n]) + kBinomial[1] * (b[n] + d[n]) + kBinomial[2] * c[n];
  }
}

}  // namespace acus::ultrasound
