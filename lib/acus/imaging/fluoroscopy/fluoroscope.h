// Digitally reconstructed radiographs: the CT and the needle as a C-arm shows them.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "acus/data/image/image.h"
#include "acus/data/volume/volume.h"
#include "acus/imaging/fluoroscopy/attenuation_volume.h"
#include "acus/imaging/fluoroscopy/c_arm.h"
#include "acus/imaging/fluoroscopy/needle_shadow.h"
#include "acus/imaging/slicing/beam_bend.h"

namespace acus::fluoroscopy {

/// Sums attenuation along the ray to each pixel (Joseph's method on HU, Beer-Lambert), adds the
/// metal that the needle puts in its way, and shows it. Equations: docs/models/fluoroscopy.md.
///
/// Not for two threads at a time: it holds buffers.
class Fluoroscope {
 public:
  /// Copies what it needs of `ct`.
  /// @throws InputError if the C-arm, its pose or the CT is out of range, or if the grey is to be
  ///     chosen from the patient and no ray meets him.
  Fluoroscope(const volume::CtVolume& ct, const CArm& c_arm, const CArmPose& pose,
              int num_threads = 1);

  /// The same bits with any `num_threads`. Allocates nothing after the first call.
  /// @param rest  Where the tissue was at rest; null: it has not moved.
  /// @throws InputError if the needle is not finite.
  void Render(const std::optional<image::NeedleInImage>& needle, image::GrayImage& out,
              int num_threads = 1, const slicing::RestMap* rest = nullptr);

  /// The same image where the patient lies as in the last Render: only the needle's shadow is
  /// new.
  /// @pre Render was called.
  void RenderNeedle(const std::optional<image::NeedleInImage>& needle, image::GrayImage& out);

  /// Sum of attenuation of pixel (column, row) of the last image, no unit: -ln of the intensity.
  float Sum(int column, int row) const {
    return sums_.data()[static_cast<std::ptrdiff_t>(row) * stride_ + column];
  }
  const CArmGeometry& geometry() const { return geometry_; }
  const CArm& c_arm() const { return c_arm_; }
  /// Sums of attenuation that are shown brightest and darkest.
  double window_low() const { return low_; }
  double window_high() const { return high_; }
  std::size_t volume_bytes() const { return volume_.bytes(); }

 private:
  /// The rays of a tile of pixels. They stay the same for all images.
  struct Tile {
    kernels::RayTile rays;
    float per_value[kernels::RayTile::kRays];  ///< Sum of attenuation per sum of values.
    int first_slice = 0;
    int end_slice = 0;
  };
  void PlaceTile(int first_column, int first_row, Tile& tile) const;
  void PlaceRay(const Eigen::Vector3d& pixel_mm, int number, Tile& tile) const;
  std::size_t num_sums() const;
  void SumAll(int num_threads);
  void ChooseWindow();
  void Show(image::GrayImage& out) const;

  CArm c_arm_;
  CArmGeometry geometry_;
  AttenuationVolume volume_;
  NeedleShadow shadow_;
  Eigen::Vector3d source_;  ///< In slices.
  double low_ = 0.0;
  double high_ = 1.0;
  int stride_;
  std::vector<Tile> tiles_;
  image::AlignedFloats patient_;  ///< The sums without the needle.
  image::AlignedFloats sums_;
};

}  // namespace acus::fluoroscopy
