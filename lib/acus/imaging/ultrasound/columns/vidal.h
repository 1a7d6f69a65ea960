// Ultrasound-like images from a CT, after Vidal et al. 2008, section 3.4: a slice of the CT turned
// into grey by a look-up table, a shadow mask, a slice of a noise volume, and reflections where
// Sobel's filter finds edges across the beam. No physics, and fast.
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "acus/data/image/image.h"
#include "acus/data/volume/volume.h"
#include "acus/imaging/acoustics/probe.h"
#include "acus/imaging/slicing/beam_bend.h"
#include "acus/imaging/slicing/ct_sampler.h"
#include "acus/imaging/ultrasound/beams/scan_end.h"
#include "acus/imaging/ultrasound/columns/vidal_options.h"
#include "acus/imaging/ultrasound/display/scan_conversion.h"
#include "acus/imaging/ultrasound/speckle/noise_tile.h"

namespace acus::ultrasound {

/// Equations: docs/models/ultrasound_vidal.md. Not for two threads at a time: it holds buffers.
class VidalRenderer {
 public:
  /// Keeps a reference to `ct`, which must outlive this.
  /// @throws InputError if the probe or an option is out of range.
  VidalRenderer(const volume::CtVolume& ct, const acoustics::Probe& probe,
                const VidalOptions& options);

  /// Allocation-free after the first call. The same bits with any `num_threads`.
  /// @throws InputError if the pose or the needle is not finite.
  /// @param rest  Where the tissue was at rest; null: it has not moved. Noise moves with it.
  void Render(const Eigen::Isometry3d& ct_from_probe,
              const std::optional<image::NeedleInImage>& needle, image::GrayImage& out,
              int num_threads = 1, const slicing::RestMap* rest = nullptr);

  const image::ImageGeometry& image() const { return conversion_.image(); }
  const acoustics::Probe& probe() const { return probe_; }

 private:
  void FindShadows();
  void GreyRow(int k, int piece, std::uint8_t* grey);
  void AddReflections(int k, int lanes, float* grey) const;

  acoustics::Probe probe_;
  VidalOptions options_;
  acoustics::ScanGrid grid_;
  slicing::CtSampler sampler_;
  ScanConversion conversion_;
  slicing::kernels::Curve grey_;
  double brightness_;               ///< With what the gain adds.
  std::optional<NoiseTile> noise_;  ///< Empty if the stage is off.
  float tile_per_index_[3] = {};
  int sobel_samples_ = 1;         ///< Half of the span.
  std::vector<int> sobel_lines_;  ///< The same across the beams, by sample.
  std::vector<float> per_mm_across_;
  slicing::BeamLines lines_;
  slicing::BeamBend bend_;
  slicing::BeamImage hu_;
  ScanEnds scan_ends_;
  int surface_samples_ = 0;
  std::vector<int> shadow_from_;  ///< By line: first sample of bone or gas.
  std::vector<int> needle_from_;  ///< The same of the needle.
  slicing::BeamImage scratch_;    ///< Two rows per piece of work.
};

}  // namespace acus::ultrasound
