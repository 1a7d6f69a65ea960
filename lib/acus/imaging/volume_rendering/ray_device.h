// Whoever casts the rays of a whole image in place of the threads of PatientView.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "acus/imaging/volume_rendering/camera.h"
#include "acus/imaging/volume_rendering/fragments.h"
#include "acus/imaging/volume_rendering/volume_ray.h"

namespace acus::volume_rendering {

class RayDevice {
 public:
  virtual ~RayDevice() = default;

  /// As its driver calls itself.
  virtual std::string name() const = 0;

  /// @param scene  With a CT. That, its slopes, transfer function and classes are the same in all
  ///     calls; `hidden` and `lattice` are not used.
  /// @param rgba  Four bytes a pixel, row by row from the top: colour weighted by opacity, opacity.
  /// @throws InputError if it cannot, now or any more.
  virtual void Cast(const VolumeScene& scene, const RaySettings& settings, const Camera& camera,
                    const FragmentLists& surfaces, std::vector<std::uint8_t>& rgba) = 0;
};

}  // namespace acus::volume_rendering
