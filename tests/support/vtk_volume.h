// Volume rendering by VTK on the CPU, to time ours against: at rest, as its mappers take no warped
// volume. Needs a display (Xvfb).
#pragma once

#include <memory>

#include "acus/data/volume/volume.h"
#include "acus/imaging/volume_rendering/camera.h"
#include "acus/imaging/volume_rendering/transfer_function.h"

namespace acus::testing_support {

/// vtkFixedPointVolumeRayCastMapper with shading, samples `step_mm` apart, and one of our presets
/// for its colours and opacities.
class VtkVolume {
 public:
  /// @throws std::runtime_error if there is no display.
  VtkVolume(const volume::CtVolume& ct, std::span<const volume_rendering::OpacityNode> nodes,
            const volume_rendering::Camera& camera, double step_mm, int num_threads);
  ~VtkVolume();

  /// Draws the image anew.
  void Render();
  /// Of the mapper alone, without what shows its image in a window.
  double MapperSeconds() const;
  /// Share of pixels that are not black.
  double CoveredShare();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace acus::testing_support
