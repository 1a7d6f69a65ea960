// B-mode in beam space, checked against theory: the model `beams`. Equations, limits and what was
// measured: docs/models/ultrasound_beams.md.
#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <optional>

#include "acus/data/image/image.h"
#include "acus/imaging/acoustics/probe.h"
#include "acus/imaging/slicing/beam_bend.h"
#include "acus/imaging/slicing/ct_sampler.h"
#include "acus/imaging/ultrasound/beams/beam_options.h"

namespace acus::ultrasound {

/// Follows scan_lines lines of samples_per_line samples (BeamGridOf) through labels or a CT at
/// rest: interfaces, attenuation, speckle that is fixed to the tissue, the needle; then the point
/// spread of the probe on complex echoes, the envelope, logarithmic compression and scan
/// conversion.
///
/// Not for two threads at a time: it holds buffers. Several renderers may share volumes.
class BeamRenderer {
 public:
  /// Keeps references to the volumes of `tissue`, which must outlive this; the table is read here.
  /// @throws InputError if the probe or an option is out of range, the volumes are missing, empty
  ///     or do not fit each other, or a label has no acoustic entry.
  BeamRenderer(const BeamTissue& tissue, const acoustics::Probe& probe, const BeamOptions& options);
  ~BeamRenderer();
  BeamRenderer(BeamRenderer&&) noexcept;
  BeamRenderer& operator=(BeamRenderer&&) noexcept;

  /// Allocation-free after the first call with the same `num_threads` and spacing of `rest`. The
  /// same bits with any number of threads and on every instruction set.
  /// @param rest  Where the tissue was at rest; null: it has not moved. Speckle moves with it.
  /// @throws InputError if the pose or the needle is not finite.
  void Render(const Eigen::Isometry3d& ct_from_probe,
              const std::optional<image::NeedleInImage>& needle, image::GrayImage& out,
              int num_threads = 1, const slicing::RestMap* rest = nullptr);

  /// Amplitude before compression and gains, of the last image: row(k)[line]. 1 is the echo of a
  /// flat perfect reflector at a right angle there, without attenuation. Computed on request.
  const slicing::BeamImage& envelope();

  const acoustics::ScanGrid& grid() const;
  const image::ImageGeometry& image() const;
  const acoustics::Probe& probe() const;
  const BeamOptions& options() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace acus::ultrasound
