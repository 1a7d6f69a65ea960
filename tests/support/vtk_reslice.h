// Oblique slices by vtkImageReslice, the yardstick of speed for images from a CT.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <memory>

#include "acus/data/image/image.h"
#include "acus/data/volume/volume.h"
#include "acus/imaging/slicing/ct_slice.h"

namespace acus::testing_support {

/// Trilinear slices of a CT in voxels of its own type, on a fixed number of threads of VTK's pool
/// or of its multithreader, whichever is faster here.
class VtkReslice {
 public:
  enum class Threads { kMultiThreader, kSmp };

  /// Keeps a reference to `ct`, whose voxels it shares; it must outlive this.
  VtkReslice(const volume::CtVolume& ct, const image::ImageGeometry& image, int num_threads,
             Threads threads);
  ~VtkReslice();

  /// hu[row * width + column]; valid until the next call. -1024 outside the volume.
  const std::int16_t* Render(const Eigen::Isometry3d& ct_from_probe);

  /// Threads that VTK says it uses.
  int num_threads() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// The largest difference of VTK's slice and ours at a pose. VTK rounds to whole numbers.
double LargestDifferenceHu(VtkReslice& reslice, slicing::CtSliceRenderer& slice,
                           const Eigen::Isometry3d& ct_from_probe);

}  // namespace acus::testing_support
