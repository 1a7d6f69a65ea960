#include "acus/imaging/slicing/label_slice.h"

#include <algorithm>
#include <cmath>

namespace acus::slicing {

LabelSlice::LabelSlice(const volume::LabelMap& labels, const image::ImageGeometry& image)
    : labels_(labels),
      ct_from_index_(labels.geometry.ct_from_index()),
      index_from_ct_(labels.geometry.index_from_ct()),
      image_(image),
      grid_(acoustics::ScanGridOf(image)),
      index_(3 * static_cast<std::size_t>(image.width_px) *
             static_cast<std::size_t>(image.height_px)) {}

std::uint8_t LabelSlice::LabelAtIndex(const float* index) const {
  const auto& geometry = labels_.geometry;
  int voxel[3];
  for (int axis = 0; axis < 3; ++axis) {
    const float at = index[axis];
    // Compared as a float: what is far outside does not fit an int.
    if (!(at >= -0.5F && at < static_cast<float>(geometry.size[axis]) - 0.5F)) return 0;
    voxel[axis] = static_cast<int>(std::floor(at + 0.5F));
    if (voxel[axis] >= geometry.size[axis]) return 0;  // The sum is rounded.
  }
  return labels_.At(voxel[0], voxel[1], voxel[2]);
}

void LabelSlice::Render(const Eigen::Isometry3d& ct_from_probe, const RestMap* rest,
                        image::GrayImage& out) {
  PlaceLines(grid_, index_from_ct_, ct_from_probe, lines_);
  bend_.Set(grid_, ct_from_probe, index_from_ct_, rest);
  out.Resize(image_.width_px, image_.height_px);
  const int lanes = kernels::RoundUp(image_.width_px);
  BeamBend::Row row;
  float sample = 0.0F;
  for (int r = 0; r < image_.height_px; ++r) {
    const std::size_t first_pixel =
        static_cast<std::size_t>(r) * static_cast<std::size_t>(image_.width_px);
    for (int first = 0; first < lanes; first += BeamBend::kMaxLanes) {
      const int count = std::min(BeamBend::kMaxLanes, lanes - first);
      const kernels::Lines placed = bend_.PlaceRow(lines_, r, first, count, row, sample);
      const int pixels = std::min(count, image_.width_px - first);
      for (int lane = 0; lane < pixels; ++lane) {
        const std::size_t pixel = first_pixel + static_cast<std::size_t>(first + lane);
        float* index = index_.data() + 3 * pixel;
        for (int axis = 0; axis < 3; ++axis) {
          index[axis] = placed.start[axis][lane] + sample * placed.step[axis][lane];
        }
        out.pixels[pixel] = LabelAtIndex(index);
      }
    }
  }
}

void LabelSlice::MarkSphere(const Eigen::Vector3d& centre_ct_mm, double radius_mm,
                            std::uint8_t value, image::GrayImage& out) const {
  // The axes of the volume are perpendicular: distances are those along them.
  const Eigen::Vector3f centre = (index_from_ct_ * centre_ct_mm).cast<float>();
  const Eigen::Vector3f spacing_mm = labels_.geometry.spacing_mm.matrix().cast<float>();
  const auto reach_mm2 = static_cast<float>(radius_mm * radius_mm);
  for (std::size_t pixel = 0; pixel < out.pixels.size(); ++pixel) {
    const Eigen::Map<const Eigen::Vector3f> index(index_.data() + 3 * pixel);
    const Eigen::Vector3f off_mm = (index - centre).cwiseProduct(spacing_mm);
    if (off_mm.squaredNorm() <= reach_mm2) out.pixels[pixel] = value;
  }
}

Eigen::Vector3d LabelSlice::RestOfPixelMm(int column, int row) const {
  const std::size_t pixel =
      static_cast<std::size_t>(row) * static_cast<std::size_t>(image_.width_px) +
      static_cast<std::size_t>(column);
  const Eigen::Map<const Eigen::Vector3f> index(index_.data() + 3 * pixel);
  return ct_from_index_ * index.cast<double>();
}

}  // namespace acus::slicing
