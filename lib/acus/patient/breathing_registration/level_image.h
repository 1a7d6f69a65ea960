// Images for registration: coarser, smoothed, with their gradients.
#pragma once

#include <Eigen/Core>
#include <array>

#include "acus/data/volume/volume.h"

namespace acus::breathing_registration {

/// A cubic grid of that spacing over the box of `ct`, along its axes, from its first voxel.
volume::Geometry CubicGrid(const volume::Geometry& ct, double spacing_mm);

/// HU in the units of registration: contrast of soft tissue counts in full, that of lung (which
/// is some ten times larger) a quarter, that of bone a fifth.
double Contrast(double hu) noexcept;

/// Contrast of a CT on a coarser grid: Gaussian averages with a standard deviation of half its
/// spacing. @pre same axes.
volume::Grid<float> Averaged(const volume::CtVolume& ct, const volume::Geometry& grid,
                             int num_threads);
/// The same of an image that is coarse already.
volume::Grid<float> Averaged(const volume::Grid<float>& image, const volume::Geometry& grid,
                             int num_threads);

/// An image that is read between its voxels, with its gradient.
class ModelImage {
 public:
  ModelImage(const volume::Grid<float>& image, int num_threads);

  struct Sample {
    float value = 0.0F;
    Eigen::Vector3f gradient = Eigen::Vector3f::Zero();  ///< Per voxel, along the grid's axes.
    bool within = false;                                 ///< Otherwise value and gradient are 0.
  };
  /// Trilinear; the gradient is that of central differences. @param index  In voxels.
  Sample At(const Eigen::Vector3f& index) const noexcept;
  const Eigen::Array4f& Voxel(std::size_t n) const { return voxels_[n]; }

  const volume::Geometry& geometry() const { return geometry_; }

 private:
  volume::Geometry geometry_;
  std::vector<Eigen::Array4f> voxels_;  ///< Value, gradient.
};

}  // namespace acus::breathing_registration
