// Contractions that travel along a tube, one after the other.
#pragma once

namespace acus::effects {

/// Along the tube a contraction is one period of a raised cosine; ahead of and behind it the wall
/// is at rest. docs/models/peristalsis.md.
class ContractionWave {
 public:
  /// @param contraction  Largest motion of the wall inwards, as a share of its radius.
  /// @throws InputError if a number is not finite, the contraction is outside [0, 0.9], another is
  ///     not above 0, or a contraction is longer than their distance, speed over rate.
  ContractionWave(double waves_per_min, double speed_mm_per_s, double length_mm,
                  double contraction);

  double spacing_mm() const { return spacing_mm_; }

  /// Number of waves that have begun, with the fraction of the next one: the only state over time.
  /// @param session_s  Not finite: 0.
  double WavesAt(double session_s) const noexcept;

  /// Strain of the radius, 0 or below. @param along_mm  Distance from where the waves begin.
  double StrainAt(double along_mm, double waves) const noexcept;

 private:
  double period_s_;
  double spacing_mm_;
  double length_share_;
  double contraction_;
};

}  // namespace acus::effects
