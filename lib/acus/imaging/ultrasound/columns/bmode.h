// B-mode from a CT, after "Towards an Augmented Ultrasound Guided Spinal Needle Insertion System"
// (2010), section II-C, and Shams et al. 2008, to which it refers.
#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <optional>

#include "acus/data/image/image.h"
#include "acus/data/volume/volume.h"
#include "acus/imaging/acoustics/probe.h"
#include "acus/imaging/slicing/beam_bend.h"
#include "acus/imaging/ultrasound/columns/bmode_options.h"

namespace acus::ultrasound {

/// Slices the CT in the probe's plane, puts in the needle, follows each scan line down through
/// reflection and transmission, applies the Hanning windows of pulse and beam, and compresses
/// logarithmically. Equations: docs/models/ultrasound_2010.md.
///
/// Not for two threads at a time: it holds buffers. Several renderers may share one CT.
class BModeRenderer {
 public:
  /// Keeps a reference to `ct`, which must outlive this.
  /// @throws InputError if the probe or an option is out of range.
  BModeRenderer(const volume::CtVolume& ct, const acoustics::Probe& probe,
                const BModeOptions& options);
  ~BModeRenderer();
  BModeRenderer(BModeRenderer&&) noexcept;
  BModeRenderer& operator=(BModeRenderer&&) noexcept;

  /// Allocation-free after the first call with one thread. The same bits with any `num_threads`.
  /// @throws InputError if the pose or the needle is not finite.
  /// @param rest  Where the tissue was at rest; null: it has not moved. Speckle moves with it.
  void Render(const Eigen::Isometry3d& ct_from_probe,
              const std::optional<image::NeedleInImage>& needle, image::GrayImage& out,
              int num_threads = 1, const slicing::RestMap* rest = nullptr);

  const image::ImageGeometry& image() const;
  const acoustics::Probe& probe() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace acus::ultrasound
