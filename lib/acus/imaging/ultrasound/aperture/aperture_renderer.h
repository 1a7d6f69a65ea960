// B-mode images through a finite aperture: the model `aperture`. Equations, limits and what was
// measured: docs/models/ultrasound_aperture.md.
#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <optional>

#include "acus/data/image/image.h"
#include "acus/imaging/acoustics/probe.h"
#include "acus/imaging/slicing/beam_bend.h"
#include "acus/imaging/slicing/ct_sampler.h"
#include "acus/imaging/ultrasound/aperture/aperture_options.h"

namespace acus::ultrasound {

class ApertureTissueStore;

/// As BeamRenderer, but boundaries of tissues are smooth surfaces, losses are averaged over the
/// aperture, scatterers follow the patient's CT, and a receiver adds what receivers add.
///
/// Not for two threads at a time: it holds buffers.
class ApertureRenderer {
 public:
  /// Reads the volumes and the table of `tissue` here, on up to `num_threads` threads, and keeps
  /// nothing of them but some bytes per voxel around the patient.
  /// @param store  If given, renderers that are made with it share those bytes.
  /// @throws InputError if the probe or an option is out of range, the volumes are missing, empty
  ///     or do not fit each other, or a label has no acoustic entry.
  ApertureRenderer(const BeamTissue& tissue, const acoustics::Probe& probe,
                   const ApertureOptions& options, int num_threads = 2,
                   ApertureTissueStore* store = nullptr);
  ~ApertureRenderer();
  ApertureRenderer(ApertureRenderer&&) noexcept;
  ApertureRenderer& operator=(ApertureRenderer&&) noexcept;

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
  std::size_t volume_bytes() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace acus::ultrasound
