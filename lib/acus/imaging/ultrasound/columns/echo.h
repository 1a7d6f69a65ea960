// Reflection and transmission along scan lines: Hounsfield units to echo intensities.
#pragma once

#include <cstdint>
#include <vector>

#include "acus/imaging/acoustics/probe.h"
#include "acus/imaging/slicing/ct_sampler.h"
#include "acus/imaging/slicing/kernels.h"
#include "acus/imaging/ultrasound/columns/bmode_options.h"

namespace acus::ultrasound {

/// A curve over HU in the form that the kernels evaluate. @throws InputError if it has no knot,
/// more than Curve::kMaxKnots, or knots not in order.
slicing::kernels::Curve CurveOf(const std::vector<HuKnot>& knots);

/// Follows each scan line down, from intensity 1 at the face (0 where it is against air):
///   r_k     = ((Z_b - Z_a) / (Z_b + Z_a))^2, Z_a and Z_b one interface span apart around sample k,
///   echo_k  = E_k * r_k * (angle weight) + E_k * scattered_k,
///   E_{k+1} = E_k * (1 - r_k)^2 * attenuation_k^2        (two-way).
/// Stages that are off are not called. Deterministic with any number of threads.
class EchoTracer {
 public:
  /// @throws InputError if an option is out of range.
  EchoTracer(const acoustics::ScanGrid& grid, double frequency_mhz, const BModeOptions& options,
             const volume::Geometry& ct_geometry);

  /// Fills gel gaps in `hu` and writes `echo` (resized by this; margins are not filled).
  /// `lines` and `bend` place the texture; they must be those that `hu` was sampled with.
  void Trace(const slicing::BeamLines& lines, const slicing::BeamBend& bend, slicing::BeamImage& hu,
             slicing::BeamImage& echo, int num_threads);

  /// Samples that an interface spans.
  int span_samples() const { return span_; }

 private:
  struct Piece;
  void MakeTile(double grain_mm, const volume::Geometry& ct_geometry, std::uint64_t seed);
  void StartEnergy(const slicing::BeamImage& hu);
  void TracePiece(const slicing::BeamLines& lines, const slicing::BeamBend& bend,
                  const slicing::BeamImage& hu, slicing::BeamImage& echo, int first_lane,
                  int lanes);
  const float* ScatterRow(const slicing::BeamLines& lines, const slicing::BeamBend& bend,
                          const slicing::BeamImage& hu, int k, int first_lane, int lanes);

  BModeOptions options_;
  acoustics::ScanGrid grid_;
  slicing::kernels::Curve impedance_;
  slicing::kernels::Curve nepers_;   ///< Two-way, per sample.
  slicing::kernels::Curve scatter_;  ///< Share per sample.
  slicing::kernels::EchoRow echo_row_;
  int span_ = 1;
  std::vector<float> per_two_lateral_mm_;  ///< By sample; empty if the angle stage is off.
  std::vector<std::uint8_t> tile_data_;    ///< Empty if the texture stage is off.
  slicing::kernels::Tile tile_{};
  slicing::BeamImage
      work_;  ///< Rows: energy, reflected, weight, scattered, nepers, then impedances.
};

}  // namespace acus::ultrasound
