#include "acus/imaging/slicing/ct_sampler.h"

#include <algorithm>
#include <cmath>

#include "acus/base/core/error.h"
#include "acus/base/core/parallel.h"
#include "acus/imaging/slicing/kernels.h"

namespace acus::slicing {
namespace {

/// Rows per piece of parallel work.
constexpr int kRowsPerPiece = 64;

/// The kernels read pairs of voxels along each axis: a single one is doubled.
std::vector<std::int16_t> Thickened(const volume::CtVolume& ct, const Eigen::Array3i& size) {
  std::vector<std::int16_t> out(static_cast<std::size_t>(size[0]) * size[1] * size[2]);
  const Eigen::Array3i last = ct.geometry.size - 1;
  std::size_t n = 0;
  for (int k = 0; k < size[2]; ++k) {
    for (int j = 0; j < size[1]; ++j) {
      for (int i = 0; i < size[0]; ++i) {
        out[n++] = ct.At(std::min(i, last[0]), std::min(j, last[1]), std::min(k, last[2]));
      }
    }
  }
  return out;
}

}  // namespace

void BeamImage::Resize(int lines, int samples) {
  lines_ = lines;
  samples_ = samples;
  stride_ = kernels::RoundUp(lines) + 2 * kMargin;
  data_.Reserve(static_cast<std::size_t>(stride_) * static_cast<std::size_t>(samples));
}

void BeamImage::FillMargins(int k) {
  float* values = row(k);
  std::fill(padded_row(k), values, values[0]);
  std::fill(values + lines_, padded_row(k) + stride_, values[lines_ - 1]);
}

CtSampler::CtSampler(const volume::CtVolume& ct)
    : ct_(ct), voxels_(ct.voxels.data()), size_(ct.geometry.size) {
  ACUS_REQUIRE((size_ > 0).all(), "CT: has no voxels (", size_[0], " x ", size_[1], " x ", size_[2],
               ")");
  ACUS_REQUIRE(ct.voxels.size() == ct.geometry.num_voxels(), "CT: ", ct.voxels.size(),
               " voxels, but its size says ", ct.geometry.num_voxels());
  ACUS_REQUIRE(ct.voxels.size() < (std::size_t{1} << 30), "CT: ", ct.voxels.size(),
               " voxels are too many for imaging; the limit is 2^30. Crop or resample it");
  index_from_ct_ = ct.geometry.index_from_ct();
  ACUS_REQUIRE(index_from_ct_.matrix().allFinite(),
               "CT: its spacing or direction cannot be inverted");
  if ((size_ == 1).any()) {
    size_ = size_.max(2);
    thickened_ = Thickened(ct, size_);
    voxels_ = thickened_.data();
  }
}

double CtSampler::At(const Eigen::Vector3d& ct_mm) const {
  const Eigen::Array3d index = (index_from_ct_ * ct_mm).array();
  const Eigen::Array3i& size = ct_.geometry.size;
  if (!((index >= -0.5).all() && (index <= size.cast<double>() - 0.5).all())) return kOutsideHu;
  const Eigen::Array3d inside = index.max(0.0).min((size - 1).cast<double>());
  const Eigen::Array3i low = inside.floor().cast<int>();
  const Eigen::Array3i high = (low + 1).min(size - 1);
  const Eigen::Array3d f = inside - low.cast<double>();
  double sum = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    const bool u[3] = {(corner & 1) != 0, (corner & 2) != 0, (corner & 4) != 0};
    double weight = 1.0;
    for (int a = 0; a < 3; ++a) weight *= u[a] ? f[a] : 1.0 - f[a];
    sum +=
        weight * ct_.At(u[0] ? high[0] : low[0], u[1] ? high[1] : low[1], u[2] ? high[2] : low[2]);
  }
  return sum;
}

void CtSampler::PlaceLines(const acoustics::ScanGrid& grid, const Eigen::Isometry3d& ct_from_probe,
                           BeamLines& lines) const {
  slicing::PlaceLines(grid, index_from_ct_, ct_from_probe, lines);
}

kernels::Voxels CtSampler::Voxels(float outside) const {
  return {.data = voxels_,
          .last = {static_cast<float>(size_[0] - 1), static_cast<float>(size_[1] - 1),
                   static_cast<float>(size_[2] - 1)},
          .edge = {static_cast<float>(ct_.geometry.size[0]) - 0.5F,
                   static_cast<float>(ct_.geometry.size[1]) - 0.5F,
                   static_cast<float>(ct_.geometry.size[2]) - 0.5F},
          .row_bytes = 2 * size_[0],
          .slice_bytes = 2 * size_[0] * size_[1],
          .outside = outside};
}

void CtSampler::Sample(const BeamLines& lines, const BeamBend& bend, BeamImage& hu, int num_threads,
                       float outside) const {
  const kernels::Voxels voxels = Voxels(outside);
  const int lanes = kernels::RoundUp(hu.lines());
  const auto piece = [&](int p) {
    const int end = std::min(hu.samples(), (p + 1) * kRowsPerPiece);
    BeamBend::Row row;
    float sample = 0.0F;
    for (int k = p * kRowsPerPiece; k < end; ++k) {
      for (int first = 0; first < lanes; first += BeamBend::kMaxLanes) {
        const int count = std::min(BeamBend::kMaxLanes, lanes - first);
        const kernels::Lines placed = bend.PlaceRow(lines, k, first, count, row, sample);
        kernels::SampleRow(voxels, placed, sample, count, hu.row(k) + first);
      }
    }
  };
  ParallelFor((hu.samples() + kRowsPerPiece - 1) / kRowsPerPiece, num_threads, std::ref(piece));
}

}  // namespace acus::slicing
