// The label map in the plane of the probe: for each pixel, the tissue that the image shows there.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "acus/data/image/image.h"
#include "acus/data/volume/volume.h"
#include "acus/imaging/acoustics/probe.h"
#include "acus/imaging/slicing/beam_bend.h"

namespace acus::slicing {

/// Samples a label map on the pixels of one image geometry, through the rest map that bends the
/// lines of the other images. Not for two threads at a time: it holds buffers.
class LabelSlice {
 public:
  /// Keeps a reference to `labels`, which must outlive this.
  /// @throws InputError if the image has no pixel.
  LabelSlice(const volume::LabelMap& labels, const image::ImageGeometry& image);

  /// Label of the voxel nearest to where the tissue of each pixel was at rest; 0 outside the
  /// volume. Allocation-free after the first call.
  /// @param rest  Where the tissue was at rest; null: it has not moved.
  /// @throws InputError if the pose is not finite.
  void Render(const Eigen::Isometry3d& ct_from_probe, const RestMap* rest, image::GrayImage& out);

  /// Sets the pixels of the last Render whose tissue was within `radius_mm` of a place at rest.
  void MarkSphere(const Eigen::Vector3d& centre_ct_mm, double radius_mm, std::uint8_t value,
                  image::GrayImage& out) const;

  /// Where the tissue of pixel (column, row) of the last Render was at rest, CT space, mm.
  Eigen::Vector3d RestOfPixelMm(int column, int row) const;

 private:
  std::uint8_t LabelAtIndex(const float* index) const;

  const volume::LabelMap& labels_;
  Eigen::Affine3d ct_from_index_;
  Eigen::Affine3d index_from_ct_;
  image::ImageGeometry image_;
  acoustics::ScanGrid grid_;
  BeamLines lines_;
  BeamBend bend_;
  std::vector<float> index_;  ///< Three for each pixel: continuous voxel indices at rest.
};

}  // namespace acus::slicing
