#include "support/vtk_volume.h"

#include <cstdlib>
#include <stdexcept>
#include <vtkAutoInit.h>
#include <vtkCamera.h>
#include <vtkColorTransferFunction.h>
#include <vtkFixedPointVolumeRayCastMapper.h>
#include <vtkImageImport.h>
#include <vtkNew.h>
#include <vtkPiecewiseFunction.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkUnsignedCharArray.h>
#include <vtkVolume.h>
#include <vtkVolumeProperty.h>

VTK_MODULE_INIT(vtkRenderingOpenGL2);
VTK_MODULE_INIT(vtkRenderingVolumeOpenGL2);

namespace acus::testing_support {

struct VtkVolume::State {
  vtkNew<vtkImageImport> import;
  vtkNew<vtkFixedPointVolumeRayCastMapper> mapper;
  vtkNew<vtkVolumeProperty> property;
  vtkNew<vtkVolume> volume;
  vtkNew<vtkRenderer> renderer;
  vtkNew<vtkRenderWindow> window;
};

VtkVolume::VtkVolume(const volume::CtVolume& ct,
                     std::span<const volume_rendering::OpacityNode> nodes,
                     const volume_rendering::Camera& camera, double step_mm, int num_threads)
    : state_(std::make_unique<State>()) {
  if (std::getenv("DISPLAY") == nullptr) throw std::runtime_error("VTK needs a display");
  State& s = *state_;
  const volume::Geometry& g = ct.geometry;
  s.import->SetImportVoidPointer(const_cast<std::int16_t*>(ct.voxels.data()), 1);
  s.import->SetDataScalarTypeToShort();
  s.import->SetNumberOfScalarComponents(1);
  s.import->SetWholeExtent(0, g.size[0] - 1, 0, g.size[1] - 1, 0, g.size[2] - 1);
  s.import->SetDataExtentToWholeExtent();
  s.import->SetDataSpacing(g.spacing_mm[0], g.spacing_mm[1], g.spacing_mm[2]);
  s.import->SetDataOrigin(g.origin_mm[0], g.origin_mm[1], g.origin_mm[2]);
  s.mapper->SetInputConnection(s.import->GetOutputPort());
  s.mapper->SetNumberOfThreads(num_threads);
  s.mapper->AutoAdjustSampleDistancesOff();
  s.mapper->LockSampleDistanceToInputSpacingOff();
  s.mapper->SetImageSampleDistance(1.0F);
  s.mapper->SetSampleDistance(static_cast<float>(step_mm));
  vtkNew<vtkColorTransferFunction> colour;
  vtkNew<vtkPiecewiseFunction> opacity;
  opacity->AddPoint(-1025.0, 0.0);
  for (const volume_rendering::OpacityNode& node : nodes) {
    colour->AddRGBPoint(node.hu, node.colour[0], node.colour[1], node.colour[2]);
    opacity->AddPoint(node.hu, 1.0 - std::exp(-node.extinction_per_mm));
  }
  s.property->SetColor(colour);
  s.property->SetScalarOpacity(opacity);
  s.property->SetScalarOpacityUnitDistance(1.0);
  s.property->SetInterpolationTypeToLinear();
  s.property->ShadeOn();
  s.volume->SetMapper(s.mapper);
  s.volume->SetProperty(s.property);
  s.renderer->AddVolume(s.volume);
  s.renderer->SetBackground(0.0, 0.0, 0.0);
  s.window->SetOffScreenRendering(1);
  s.window->SetSize(camera.width_px, camera.height_px);
  s.window->SetMultiSamples(0);
  s.window->AddRenderer(s.renderer);
  const Eigen::Vector3d eye = camera.EyeInCtMm();
  const Eigen::Matrix3d axes = camera.camera_from_ct.linear();
  const Eigen::Vector3d focus = eye + axes.row(2).transpose() * 100.0;
  const Eigen::Vector3d up = -axes.row(1).transpose();
  vtkCamera* view = s.renderer->GetActiveCamera();
  view->SetPosition(eye[0], eye[1], eye[2]);
  view->SetFocalPoint(focus[0], focus[1], focus[2]);
  view->SetViewUp(up[0], up[1], up[2]);
  view->SetViewAngle(2.0 * std::atan(0.5 * camera.height_px / camera.focal_px[1]) * 180.0 / M_PI);
  s.renderer->ResetCameraClippingRange();
}
VtkVolume::~VtkVolume() = default;

void VtkVolume::Render() {
  state_->volume->Modified();
  state_->window->Render();
}

double VtkVolume::MapperSeconds() const {
  return state_->volume->GetEstimatedRenderTime();
}

double VtkVolume::CoveredShare() {
  vtkNew<vtkUnsignedCharArray> pixels;
  const int* size = state_->window->GetSize();
  state_->window->GetPixelData(0, 0, size[0] - 1, size[1] - 1, 1, pixels);
  vtkIdType lit = 0;
  for (vtkIdType n = 0; n < pixels->GetNumberOfTuples(); ++n) {
    lit += pixels->GetTypedComponent(n, 0) > 8;
  }
  return static_cast<double>(lit) / static_cast<double>(pixels->GetNumberOfTuples());
}

}  // namespace acus::testing_support
