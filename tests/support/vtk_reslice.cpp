#include "support/vtk_reslice.h"

#include <algorithm>
#include <cmath>
#include <vtkImageData.h>
#include <vtkImageReslice.h>
#include <vtkMatrix4x4.h>
#include <vtkMultiThreader.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkShortArray.h>

#include "acus/base/core/error.h"

namespace acus::testing_support {

struct VtkReslice::State {
  volume::Geometry geometry;
  vtkNew<vtkImageData> image;
  vtkNew<vtkMatrix4x4> axes;
  vtkNew<vtkImageReslice> reslice;
};

VtkReslice::VtkReslice(const volume::CtVolume& ct, const image::ImageGeometry& image,
                       int num_threads, Threads threads)
    : state_(std::make_unique<State>()) {
  // Images of VTK have no direction here: slices are taken in the volume's own frame, from which
  // the pose is brought over below.
  State& s = *state_;
  s.geometry = ct.geometry;
  const volume::Geometry& g = ct.geometry;
  s.image->SetDimensions(g.size[0], g.size[1], g.size[2]);
  s.image->SetSpacing(g.spacing_mm[0], g.spacing_mm[1], g.spacing_mm[2]);
  vtkNew<vtkShortArray> voxels;
  constexpr int kNotOurs = 1;  // The CT keeps its voxels.
  voxels->SetArray(const_cast<std::int16_t*>(ct.voxels.data()),
                   static_cast<vtkIdType>(ct.voxels.size()), kNotOurs);
  s.image->GetPointData()->SetScalars(voxels);

  vtkMultiThreader::SetGlobalMaximumNumberOfThreads(num_threads);
  s.reslice->SetInputData(s.image);
  s.reslice->SetResliceAxes(s.axes);
  s.reslice->SetOutputDimensionality(2);
  s.reslice->SetInterpolationModeToLinear();
  s.reslice->SetBackgroundLevel(-1024.0);
  s.reslice->SetOutputSpacing(image.lateral_mm_per_px, image.axial_mm_per_px, 1.0);
  s.reslice->SetOutputOrigin(-0.5 * (image.width_px - 1) * image.lateral_mm_per_px,
                             image.depth_of_top_row_mm, 0.0);
  s.reslice->SetOutputExtent(0, image.width_px - 1, 0, image.height_px - 1, 0, 0);
  s.reslice->SetNumberOfThreads(num_threads);
  s.reslice->SetEnableSMP(threads == Threads::kSmp);
}

VtkReslice::~VtkReslice() = default;

const std::int16_t* VtkReslice::Render(const Eigen::Isometry3d& ct_from_probe) {
  State& s = *state_;
  Eigen::Isometry3d ct_from_volume = Eigen::Isometry3d::Identity();
  ct_from_volume.linear() = s.geometry.direction;
  ct_from_volume.translation() = s.geometry.origin_mm;
  const Eigen::Isometry3d volume_from_probe = ct_from_volume.inverse() * ct_from_probe;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 4; ++c) s.axes->SetElement(r, c, volume_from_probe(r, c));
  }
  s.reslice->Update();
  ACUS_ASSERT(s.reslice->GetOutput()->GetScalarType() == VTK_SHORT);
  return static_cast<const std::int16_t*>(s.reslice->GetOutput()->GetScalarPointer());
}

int VtkReslice::num_threads() const {
  return state_->reslice->GetNumberOfThreads();
}

double LargestDifferenceHu(VtkReslice& reslice, slicing::CtSliceRenderer& slice,
                           const Eigen::Isometry3d& ct_from_probe) {
  image::GrayImage image;
  slice.Render(ct_from_probe, std::nullopt, image);
  const std::int16_t* theirs = reslice.Render(ct_from_probe);
  double largest = 0.0;
  for (int r = 0; r < image.height; ++r) {
    for (int c = 0; c < image.width; ++c) {
      largest = std::max(largest, std::abs(double{slice.hu().row(r)[c]} - *theirs++));
    }
  }
  return largest;
}

}  // namespace acus::testing_support
