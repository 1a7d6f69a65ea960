#include "acus/imaging/ultrasound/aperture/aperture_rows.h"

#include <algorithm>

namespace acus::ultrasound {

acoustics::ScanGrid Coarser(const acoustics::ScanGrid& grid, int samples) {
  acoustics::ScanGrid rows = grid;
  rows.step_mm = samples * grid.step_mm;
  rows.samples = (grid.samples - 1) / samples + 2;
  return rows;
}

int SamplesPerRow(const acoustics::ScanGrid& grid, const volume::Geometry& geometry) {
  constexpr double kFarthestMm = 0.8;
  const double rows_mm = std::min(geometry.spacing_mm.minCoeff(), kFarthestMm);
  return std::clamp(static_cast<int>(rows_mm / grid.step_mm), 1, 16);
}

int SamplesPerShownRow(const acoustics::Probe& probe, const acoustics::ScanGrid& grid) {
  const double samples = acoustics::ImageOf(probe).axial_mm_per_px / grid.step_mm;
  return std::max(1, 2 * static_cast<int>(0.5 * (samples - 1.0)) + 1);
}

acoustics::ScanGrid ShownRows(const acoustics::ScanGrid& grid, int samples) {
  acoustics::ScanGrid rows = grid;
  rows.step_mm = samples * grid.step_mm;
  rows.samples = (grid.samples - 1) / samples + 1;
  return rows;
}

}  // namespace acus::ultrasound
