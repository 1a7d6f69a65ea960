// Reflection and transmission along scan lines: Hounsfield units to echo intensities.
#pragma once

#include <cstdint>
#include <vector>

#include "ultrasound/bmode_options.h"
#include "ultrasound/ct_sampler.h"
#include "ultrasound/kernels.h"
#include "ultrasound/probe.h"

namespace acus::ultrasound {

/// A curve over HU in the form that the kernels evaluate. @throws InputError if it has no knot,
/// more than Curve::kMaxKnots, or knots not in order.
kernels::Curve CurveOf(const std::vector<HuKnot>& knots);

/// Follows each scan line down, from intensity 1 at the face (0 where it is against air):
///   r_k     = ((Z_b - Z_a) / (Z_b + Z_a))^2, Z_a and Z_b one interface span apart around sample k,
///   echo_k  = E_k * r_k * (angle weight) + E_k * scattered_k,
///   E_{k+1} = E_k * (1 - r_k)^2 * attenuation_k^2        (there and back).
/// Stages that are off are not called. Deterministic with any number of threads.
class EchoTracer {
 public:
  /// @throws InputError if an option is out of range.
  EchoTracer(const ScanGrid& grid, double frequency_mhz, const BModeOptions& options,
             const volume::Geometry& ct_geometry);

  /// Fills gel gaps in `hu` and writes `echo` (resized by this; margins are not filled).
  /// `lines` and `bend` place the texture; they must be those that `hu` was sampled with.
  void Trace(const BeamLines& lines, const BeamBend& bend, BeamImage& hu, BeamImage& echo,
             int num_threads);

  /// Samples that an interface spans.
  int span_samples() const { return span_; }

 private:
  struct Piece;
  void MakeTile(double grain_mm, const volume::Geometry& ct_geometry, std::uint64_t seed);
  void StartEnergy(const BeamImage& hu);
  void TracePiece(const BeamLines& lines, const BeamBend& bend, const BeamImage& hu,
                  BeamImage& echo, int first_lane, int lanes);
  const float* ScatterRow(const BeamLines& lines, const BeamBend& bend, const BeamImage& hu, int k,
                          int first_lane, int lanes);

  BModeOptions options_;
  ScanGrid grid_;
  kernels::Curve impedance_;
  kernels::Curve nepers_;   ///< Two-way, per sample.
  kernels::Curve scatter_;  ///< Share per sample.
  kernels::EchoRow echo_row_;
  int span_ = 1;
  std::vector<float> per_two_lateral_mm_;  ///< By sample; empty if the angle stage is off.
  std::vector<std::uint8_t> tile_data_;    ///< Empty if the texture stage is off.
  kernels::Tile tile_{};
  BeamImage work_;  ///< Rows: energy, reflected, weight, scattered, nepers, then impedances.
};

}  // namespace acus::ultrasound
