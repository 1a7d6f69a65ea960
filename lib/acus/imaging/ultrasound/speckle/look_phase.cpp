#include "acus/imaging/ultrasound/speckle/look_phase.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "acus/imaging/acoustics/beam_width.h"

namespace acus::ultrasound {

LookPhase::LookPhase(const acoustics::Probe& probe, const acoustics::ScanGrid& grid,
                     double grain_sigma_mm) {
  if (probe.steer_rad == 0.0) return;
  const double wave_number_per_mm = 2.0 * std::numbers::pi * acoustics::ReceivedMhz(probe) /
                                    (1e-3 * acoustics::kScannerSpeedMPerS);
  const double sine = std::sin(probe.steer_rad);
  const double cosine = std::cos(probe.steer_rad);
  const auto lanes = static_cast<std::size_t>(kernels::RoundUp(grid.lines()));
  const double line_mm = grid.lines() > 1 ? probe.ArrayLengthMm() / (grid.lines() - 1) : 0.0;
  lanes_[0].Reserve(lanes);
  lanes_[1].Reserve(lanes);
  for (std::size_t l = 0; l < lanes; ++l) {
    const double along_face_mm = (static_cast<double>(l) - 0.5 * (grid.lines() - 1)) * line_mm;
    const double phase = 2.0 * wave_number_per_mm * along_face_mm * sine;
    lanes_[0].data()[l] = static_cast<float>(std::cos(phase));
    lanes_[1].data()[l] = static_cast<float>(std::sin(phase));
  }
  for (int k = 0; k < grid.samples; ++k) {
    const double range_mm = k * grid.step_mm;
    const double radius_mm = probe.radius_mm;
    const double depth_mm = probe.kind == acoustics::ProbeKind::kLinear
                                ? range_mm * cosine
                                : std::sqrt(radius_mm * radius_mm + range_mm * range_mm +
                                            2.0 * radius_mm * range_mm * cosine) -
                                      radius_mm;
    const double phase = 2.0 * wave_number_per_mm * (range_mm - depth_mm);
    rows_.push_back({static_cast<float>(std::cos(phase)), static_cast<float>(std::sin(phase))});
  }
  const double per_grain = 2.0 * wave_number_per_mm * sine * grain_sigma_mm;
  gain_ = static_cast<float>(std::exp(0.5 * per_grain * per_grain));
}

void LookPhase::Set(int k, int first, kernels::SpeckleRow& row) const {
  if (!on()) return;
  const Turn& turn = rows_[static_cast<std::size_t>(k)];
  for (int part = 0; part < 2; ++part) row.turn_of_lane[part] = lanes_[part].data() + first;
  row.turn_of_row[0] = turn.re;
  row.turn_of_row[1] = turn.im;
  row.gain *= gain_;
}

}  // namespace acus::ultrasound
