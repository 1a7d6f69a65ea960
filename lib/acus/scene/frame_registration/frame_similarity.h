// How well the image simulated at a pose explains a recorded frame.
// Equations and measurements: docs/models/frame_registration.md.
#pragma once

#include <Eigen/Geometry>
#include <memory>

#include "acus/data/image/image.h"
#include "acus/imaging/acoustics/probe.h"
#include "acus/imaging/ultrasound/aperture/aperture_options.h"

namespace acus::frame_registration {

/// The inputs of the simulation. The references must outlive the objects made from them.
struct SimulatedTissue {
  ultrasound::BeamTissue tissue;
  ultrasound::ApertureOptions options;
};

/// The resolution at which both images are compared.
struct Resolution {
  double pixel_mm = 0.5;  ///< Both images are blurred with this standard deviation.
  int window_px = 13;     ///< Side of the square windows, an odd number of pixels.
  int scan_lines = 96;
  int samples_per_line = 512;
  int aperture_rays = 13;
};

/// The depth of the image has 45 pixels in the coarse resolution, 90 in the fine one.
Resolution CoarseResolution(const acoustics::Probe& probe);
Resolution FineResolution(const acoustics::Probe& probe);

/// Compares a recorded frame with images of the aperture model without speckle, noise and texture,
/// in one elevation plane.
///
/// Not for two threads at a time: it holds buffers.
class FrameSimilarity {
 public:
  /// @param recorded  In the geometry of the probe's image: acoustics::ImageOf(probe).
  /// @throws InputError if the frame has another size, if it is of one grey inside the field of
  ///     view, or as ApertureRenderer.
  FrameSimilarity(const image::GrayImage& recorded, const acoustics::Probe& probe,
                  const SimulatedTissue& simulated, const Resolution& resolution);
  ~FrameSimilarity();
  FrameSimilarity(FrameSimilarity&&) noexcept;
  FrameSimilarity& operator=(FrameSimilarity&&) noexcept;

  /// The share of the recorded frame's local variance that the simulated image explains, 0 to 1: in
  /// each window by the best linear map of its grey levels that is not falling.
  double At(const Eigen::Isometry3d& ct_from_probe);

  /// Area of the field of view over that of a blurred point: approximately the number of
  /// independent grey levels of the frame.
  double independent_values() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace acus::frame_registration
