// Whoever renders whole images in place of the threads of PatientView.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <string>

#include "acus/imaging/volume_rendering/camera.h"
#include "acus/imaging/volume_rendering/fragments.h"
#include "acus/imaging/volume_rendering/volume_ray.h"

namespace acus::volume_rendering {

/// An image for a device: what VolumeScene does not have.
struct DeviceImage {
  Camera camera;  ///< Of the rays: with supersampling there are more than pixels.
  int supersampling = 1;
  RaySettings rays;
  Eigen::Array3f background_top = Eigen::Array3f::Zero();
  Eigen::Array3f background_bottom = Eigen::Array3f::Zero();
  /// Those with `at_rest` have the same nodes and triangles in all images.
  std::span<const Drawing> drawings;
  const ShadowFrame* shadows = nullptr;  ///< Of drawings that throw shadows; null: none do.
};

class RayDevice {
 public:
  virtual ~RayDevice() = default;

  /// As its driver calls itself.
  virtual std::string name() const = 0;

  /// What stays the same may be copied to the device from now on, in the background.
  /// @param scene  CT, slopes, transfer function, classes and blocks, which must outlive the
  /// device.
  /// @param field  What the patient breathes by; null: never.
  virtual void Load(const VolumeScene& scene, const breathing::MotionField* field) = 0;

  /// @param scene  With what was loaded, and the moment; `hidden`, `lattice` and `shadows` are not
  ///     used, and of `blocks` only what does not depend on the moment.
  /// @param rgb  Three bytes a pixel, row by row from the top, over the background.
  /// @param coverage  One byte a pixel: the opacity.
  /// @throws InputError if it cannot, now or any more.
  virtual void Render(const VolumeScene& scene, const DeviceImage& image,
                      std::span<std::uint8_t> rgb, std::span<std::uint8_t> coverage) = 0;

  /// Bytes sent to the device so far.
  virtual std::uint64_t bytes_sent() const = 0;
};

}  // namespace acus::volume_rendering
