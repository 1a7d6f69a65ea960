// What arrives at every place of the image, through all rays of a finite aperture.
#pragma once

#include <vector>

#include "acus/data/image/image.h"
#include "acus/imaging/slicing/ct_sampler.h"
#include "acus/imaging/ultrasound/aperture/aperture_rays.h"
#include "acus/imaging/ultrasound/beams/steered_rays.h"

namespace acus::ultrasound {

/// Amplitude at a place: the mean over the aperture of what remains on the straight way from each
/// element, squared, since the echo comes back through the same aperture. A bone narrower than the
/// aperture throws a shadow that fills in below it; the edge of a wide one is a penumbra that grows
/// with depth.
class ApertureField {
 public:
  /// @param steered  The rays of a phased probe, which then take the place of `rays`; or null. Its
  ///     elements' directivity is part of what arrives.
  ApertureField(const ApertureRays& rays, int lines, int rows,
                const SteeredRays* steered = nullptr);

  /// Amplitude that one row leaves, one way, by line: to be filled before March().
  float* left(int row) { return left_.data() + row * stride_ + margin_; }

  /// @param contact  By line: what its element sends into the patient, 0 to 1.
  void March(const std::vector<float>& contact, int num_threads);

  /// Changes what arrives at a row by a factor for each line. @pre after March().
  void Scale(int row, const float* factor);

  /// Two-way amplitude at a row, by line.
  const float* arriving(int row) const { return arriving_.row(row); }

 private:
  /// Directions are marched in this many groups, whose sums are added in order: the same bits with
  /// any number of threads.
  static constexpr int kGroups = 3;

  void FillMargins(float* row) const;
  void MarchSteered(int group, const std::vector<float>& contact);
  void MarchGroup(int group, const std::vector<float>& contact);

  const ApertureRays& rays_;
  const SteeredRays* steered_;
  int lines_;
  int rows_;
  std::ptrdiff_t margin_;
  std::ptrdiff_t stride_;
  image::AlignedFloats left_;
  image::AlignedFloats ray_[kGroups];
  slicing::BeamImage sum_[kGroups];
  slicing::BeamImage arriving_;
};

}  // namespace acus::ultrasound
