// The needle as the beams see it: where it sends echoes back, how strong, and what it hides.
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "acus/data/image/image.h"
#include "acus/imaging/acoustics/probe.h"
#include "acus/imaging/ultrasound/beams/beam_options.h"

namespace acus::ultrasound {

/// One echo of the needle.
struct NeedleMark {
  int line = 0;
  int sample = 0;
  float beside = 0.0F;        ///< Of the echo, from that sample, -0.5 to 0.5 samples.
  float echo = 0.0F;          ///< Amplitude, of what arrives there.
  float transmission = 1.0F;  ///< Left behind it.
};

class BeamNeedle {
 public:
  BeamNeedle(const acoustics::Probe& probe, const BeamOptions& options,
             const acoustics::ScanGrid& grid);

  /// Marks sorted by line block of `lanes_per_block`, then sample. Allocation-free.
  /// The echo falls with the distance from the plane as the slice's profile (a Gaussian whose full
  /// width at half maximum is the thickness there) and is nothing from 1.5 thicknesses on.
  /// @throws InputError if the needle is not finite, has no direction or a negative size.
  void Set(const std::optional<image::NeedleInImage>& needle,
           const Eigen::Isometry3d& ct_from_probe, int lanes_per_block);

  const NeedleMark* begin(int block) const { return marks_.data() + first_[Index(block)]; }
  const NeedleMark* end(int block) const { return marks_.data() + first_[Index(block) + 1]; }
  /// Samples from one reverberation within the shaft to the next.
  double ring_samples() const { return ring_samples_; }

 private:
  struct Beam {
    double line;
    double sample;
  };
  static std::size_t Index(int n) { return static_cast<std::size_t>(n); }
  Beam BeamAt(const Eigen::Vector3d& place_mm) const;
  void AddPiece(const Eigen::Vector3d& from_mm, const Eigen::Vector3d& to_mm, double radius_mm);
  double SliceWeight(double from_plane_mm, int sample) const;
  void AddTip(const Eigen::Vector3d& place_mm);
  void AddMark(const Eigen::Vector3d& place_mm, const Eigen::Vector3d& axis, double radius_mm);

  const acoustics::Probe& probe_;
  const BeamOptions& options_;
  const acoustics::ScanGrid& grid_;
  std::size_t most_marks_;
  double ring_samples_ = 0.0;
  std::vector<double> slice_mm_;  ///< Thickness by sample.
  std::vector<NeedleMark> marks_;
  std::vector<std::size_t> first_;  ///< By block.
};

}  // namespace acus::ultrasound
