#include "acus/window/space_layer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <numbers>
#include <vector>
#include <vtkActor.h>
#include <vtkCamera.h>
#include <vtkCellArray.h>
#include <vtkCullerCollection.h>
#include <vtkFloatArray.h>
#include <vtkImageData.h>
#include <vtkLight.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkQuadricDecimation.h>
#include <vtkRenderer.h>
#include <vtkTexture.h>

namespace acus::window {
namespace {

void FillPoints(const Eigen::Matrix3Xf& nodes, vtkPoints& points) {
  points.SetNumberOfPoints(nodes.cols());
  auto* data = static_cast<float*>(points.GetVoidPointer(0));
  std::memcpy(data, nodes.data(), sizeof(float) * static_cast<std::size_t>(nodes.size()));
  points.Modified();
}

void FillCells(const Eigen::Matrix3Xi& triangles, vtkCellArray& cells) {
  cells.Reset();
  for (Eigen::Index t = 0; t < triangles.cols(); ++t) {
    const std::array<vtkIdType, 3> corners{triangles(0, t), triangles(1, t), triangles(2, t)};
    cells.InsertNextCell(3, corners.data());
  }
  cells.Modified();
}

/// The projection in the convention of OpenGL, for eyes that look along -z with y up. The image's
/// edges are half a pixel outside the outermost pixels' centres.
void Project(const volume_rendering::Camera& camera, const DepthRange& range, vtkMatrix4x4& out) {
  const double width = camera.width_px;
  const double height = camera.height_px;
  const double depth = range.far_mm - range.near_mm;
  out.Zero();
  out.SetElement(0, 0, 2.0 * camera.focal_px[0] / width);
  out.SetElement(0, 2, 1.0 - 2.0 * (camera.centre_px[0] + 0.5) / width);
  out.SetElement(1, 1, 2.0 * camera.focal_px[1] / height);
  out.SetElement(1, 2, 2.0 * (camera.centre_px[1] + 0.5) / height - 1.0);
  out.SetElement(2, 2, -(range.far_mm + range.near_mm) / depth);
  out.SetElement(2, 3, -2.0 * range.far_mm * range.near_mm / depth);
  out.SetElement(3, 2, -1.0);
}

/// Triangles whose corners do not lie on a line: the others stop the thinning.
Eigen::Matrix3Xi WithArea(const mesh::Surface& surface) {
  Eigen::Matrix3Xi out(3, surface.triangles.cols());
  Eigen::Index kept = 0;
  for (Eigen::Index t = 0; t < surface.triangles.cols(); ++t) {
    const Eigen::Vector3d a = surface.nodes_mm.col(surface.triangles(0, t));
    const Eigen::Vector3d b = surface.nodes_mm.col(surface.triangles(1, t));
    const Eigen::Vector3d c = surface.nodes_mm.col(surface.triangles(2, t));
    if ((b - a).cross(c - a).norm() > 1e-6) out.col(kept++) = surface.triangles.col(t);
  }
  out.conservativeResize(3, kept);
  return out;
}

struct Eye {
  vtkNew<vtkRenderer> renderer;
  vtkNew<vtkMatrix4x4> projection;

  void SetPlace(const Rectangle& place, const Rectangle& window) {
    renderer->SetDraw(place.empty() ? 0 : 1);
    if (place.empty()) return;
    renderer->SetViewport(static_cast<double>(place.left) / window.width,
                          1.0 - static_cast<double>(place.top + place.height) / window.height,
                          static_cast<double>(place.left + place.width) / window.width,
                          1.0 - static_cast<double>(place.top) / window.height);
  }
  void SetCamera(const volume_rendering::Camera& camera, const DepthRange& range, bool by_angle) {
    vtkCamera& out = *renderer->GetActiveCamera();
    const Eigen::Vector3d eye = camera.EyeInCtMm();
    const Eigen::Matrix3d& axes = camera.camera_from_ct.linear();
    // Red-cyan eyes converge on the focus: at the geometric mean of the depth range.
    const double focus_mm = std::sqrt(range.near_mm * range.far_mm);
    const Eigen::Vector3d focus = eye + focus_mm * axes.row(2).transpose();
    const Eigen::Vector3d up = -axes.row(1).transpose();
    out.SetPosition(eye.data());
    out.SetFocalPoint(focus.data());
    out.SetViewUp(up.data());
    out.SetClippingRange(range.near_mm, range.far_mm);
    out.SetUseExplicitProjectionTransformMatrix(!by_angle);
    if (by_angle) {
      out.SetViewAngle(2.0 * std::atan(0.5 * camera.height_px / camera.focal_px[1]) * 180.0 /
                       std::numbers::pi);
      return;
    }
    Project(camera, range, *projection);
    out.SetExplicitProjectionTransformMatrix(projection);
  }
};

}  // namespace

struct SpaceLayer::Thing {
  vtkNew<vtkPoints> points;
  vtkNew<vtkFloatArray> normals;
  vtkNew<vtkFloatArray> at;
  vtkNew<vtkCellArray> cells;
  vtkNew<vtkPolyData> surface;
  vtkNew<vtkPolyDataMapper> mapper;
  vtkNew<vtkActor> actor;
  vtkNew<vtkMatrix4x4> pose;
  vtkNew<vtkImageData> image;
  vtkNew<vtkTexture> texture;

  void SetPixels(int width, int height, int components, const std::uint8_t* pixels) {
    const int* size = image->GetDimensions();
    if (actor->GetTexture() == nullptr || size[0] != width || size[1] != height) {
      image->SetDimensions(width, height, 1);
      image->AllocateScalars(VTK_UNSIGNED_CHAR, components);
      texture->SetInputData(image);
      texture->InterpolateOn();
      texture->SetWrap(vtkTexture::ClampToEdge);
      texture->SetColorModeToDirectScalars();
      actor->SetTexture(texture);
    }
    // An unchanged image is not sent to the graphics card again.
    const std::size_t bytes = static_cast<std::size_t>(width) * static_cast<std::size_t>(height) *
                              static_cast<std::size_t>(components);
    if (std::memcmp(image->GetScalarPointer(), pixels, bytes) == 0) return;
    std::memcpy(image->GetScalarPointer(), pixels, bytes);
    image->Modified();
  }
};

struct SpaceLayer::Content {
  std::array<Eye, 2> eyes;
  vtkNew<vtkLight> light;
  std::vector<std::unique_ptr<Thing>> things;

  Thing& Of(int thing) { return *things[static_cast<std::size_t>(thing)]; }
};

SpaceLayer::SpaceLayer() : content_(std::make_unique<Content>()) {
  for (Eye& eye : content_->eyes) {
    // They cull with VTK's standard camera, which this one is not.
    eye.renderer->GetCullers()->RemoveAllItems();
    eye.renderer->InteractiveOff();
    eye.renderer->DrawOff();
  }
}

SpaceLayer::~SpaceLayer() = default;

vtkRenderer* SpaceLayer::renderer(int eye) {
  return content_->eyes[static_cast<std::size_t>(eye)].renderer;
}

void SpaceLayer::SetBackground(const Eigen::Array3f& top, const Eigen::Array3f& bottom) {
  const Eigen::Array3d upper = top.cast<double>();
  const Eigen::Array3d lower = bottom.cast<double>();
  for (Eye& eye : content_->eyes) {
    eye.renderer->SetBackground(lower[0], lower[1], lower[2]);
    eye.renderer->SetBackground2(upper[0], upper[1], upper[2]);
    eye.renderer->GradientBackgroundOn();
  }
}

void SpaceLayer::PaintBackground() {
  // Renderers of upper layers do not clear the image.
  for (Eye& eye : content_->eyes) eye.renderer->PreserveColorBufferOff();
}

void SpaceLayer::SetLight(const Eigen::Vector3d& towards) {
  const Eigen::Vector3d far_away = 1e4 * towards.normalized();
  content_->light->SetLightTypeToSceneLight();
  content_->light->SetPosition(far_away.data());
  content_->light->SetFocalPoint(0.0, 0.0, 0.0);
  content_->light->SetIntensity(0.75);
  for (Eye& eye : content_->eyes) {
    vtkNew<vtkLight> headlight;
    headlight->SetLightTypeToHeadlight();
    headlight->SetIntensity(0.45);
    eye.renderer->AutomaticLightCreationOff();
    eye.renderer->RemoveAllLights();
    eye.renderer->AddLight(content_->light);
    eye.renderer->AddLight(headlight);
  }
}

void SpaceLayer::SetView(const Rectangle& place, const Rectangle& window,
                         const volume_rendering::Camera& camera, const DepthRange& range,
                         bool both_eyes) {
  Eye& eye = content_->eyes[0];
  eye.SetPlace(place, window);
  if (!place.empty()) eye.SetCamera(camera, range, both_eyes);
}

void SpaceLayer::SetRightEye(const Rectangle& place, const Rectangle& window,
                             const std::optional<volume_rendering::Camera>& camera,
                             const DepthRange& range) {
  Eye& eye = content_->eyes[1];
  eye.SetPlace(camera ? place : Rectangle{}, window);
  if (camera && !place.empty()) eye.SetCamera(*camera, range, /*by_angle=*/false);
}

int SpaceLayer::Add(const mesh::Surface& surface, const Look& look) {
  auto thing = std::make_unique<Thing>();
  thing->points->SetDataTypeToFloat();
  thing->normals->SetNumberOfComponents(3);
  thing->at->SetNumberOfComponents(2);
  thing->surface->SetPoints(thing->points);
  thing->surface->SetPolys(thing->cells);
  thing->mapper->SetInputData(thing->surface);
  thing->mapper->StaticOn();  // Its one input changes in place.
  thing->actor->SetMapper(thing->mapper);
  vtkProperty& property = *thing->actor->GetProperty();
  property.SetColor(static_cast<double>(look.colour[0]), static_cast<double>(look.colour[1]),
                    static_cast<double>(look.colour[2]));
  property.SetOpacity(look.opacity);
  property.SetLighting(look.lit);
  property.SetAmbient(look.lit ? 0.22 : 0.0);
  property.SetSpecular(look.lit ? 0.12 : 0.0);
  property.SetSpecularPower(18.0);
  property.SetBackfaceCulling(look.both_sides ? 0 : 1);
  thing->actor->ForceOpaqueOn();  // Blended all the same, but in order.
  for (Eye& eye : content_->eyes) eye.renderer->AddActor(thing->actor);
  content_->things.push_back(std::move(thing));
  const int number = static_cast<int>(content_->things.size()) - 1;
  SetSurface(number, surface);
  return number;
}

void SpaceLayer::SetSurface(int thing, const mesh::Surface& surface) {
  Thing& out = content_->Of(thing);
  FillPoints(surface.nodes_mm.cast<float>(), *out.points);
  FillCells(surface.triangles, *out.cells);
  out.surface->Modified();
}

void SpaceLayer::SetNodes(int thing, const Eigen::Matrix3Xf& nodes_mm,
                          const Eigen::Matrix3Xf* normals) {
  Thing& out = content_->Of(thing);
  FillPoints(nodes_mm, *out.points);
  if (normals != nullptr) {
    out.normals->SetNumberOfTuples(normals->cols());
    std::memcpy(out.normals->GetVoidPointer(0), normals->data(),
                sizeof(float) * static_cast<std::size_t>(normals->size()));
    out.normals->Modified();
    out.surface->GetPointData()->SetNormals(out.normals);
  }
  out.surface->Modified();
}

void SpaceLayer::SetPose(int thing, const Eigen::Isometry3d& ct_from_thing) {
  Thing& out = content_->Of(thing);
  const Eigen::Matrix4d matrix = ct_from_thing.matrix();
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) {
      out.pose->SetElement(row, column, matrix(row, column));
    }
  }
  out.actor->SetUserMatrix(out.pose);
}

void SpaceLayer::SetShown(int thing, bool shown) {
  content_->Of(thing).actor->SetVisibility(shown ? 1 : 0);
}

void SpaceLayer::SetOpacity(int thing, double opacity) {
  content_->Of(thing).actor->GetProperty()->SetOpacity(opacity);
}

void SpaceLayer::SetTexturePlaces(int thing, const Eigen::Matrix2Xf& at) {
  Thing& out = content_->Of(thing);
  out.at->SetNumberOfTuples(at.cols());
  std::memcpy(out.at->GetVoidPointer(0), at.data(),
              sizeof(float) * static_cast<std::size_t>(at.size()));
  out.at->Modified();
  out.surface->GetPointData()->SetTCoords(out.at);
  out.surface->Modified();
}

void SpaceLayer::SetTexture(int thing, const Texture& texture) {
  content_->Of(thing).SetPixels(texture.width, texture.height, 4, texture.rgba.data());
}

void SpaceLayer::SetTexture(int thing, const image::GrayImage& image) {
  content_->Of(thing).SetPixels(image.width, image.height, 1, image.pixels.data());
}

mesh::Surface Thinned(const mesh::Surface& surface, int max_triangles) {
  if (surface.triangles.cols() <= max_triangles) return surface;
  vtkNew<vtkPoints> points;
  points->SetDataTypeToFloat();
  vtkNew<vtkCellArray> cells;
  FillPoints(surface.nodes_mm.cast<float>(), *points);
  FillCells(WithArea(surface), *cells);
  vtkNew<vtkPolyData> whole;
  whole->SetPoints(points);
  whole->SetPolys(cells);
  vtkNew<vtkQuadricDecimation> thinning;
  thinning->SetInputData(whole);
  thinning->SetTargetReduction(1.0 - static_cast<double>(max_triangles) /
                                         static_cast<double>(surface.triangles.cols()));
  thinning->Update();
  vtkPolyData& thin = *thinning->GetOutput();
  mesh::Surface out;
  out.nodes_mm.resize(3, thin.GetNumberOfPoints());
  for (vtkIdType n = 0; n < thin.GetNumberOfPoints(); ++n) {
    thin.GetPoint(n, out.nodes_mm.col(n).data());
  }
  out.triangles.resize(3, thin.GetNumberOfPolys());
  vtkIdType size = 0;
  const vtkIdType* corners = nullptr;
  Eigen::Index kept = 0;
  thin.GetPolys()->InitTraversal();
  while (thin.GetPolys()->GetNextCell(size, corners) != 0) {
    if (size != 3) continue;
    for (int i = 0; i < 3; ++i) out.triangles(i, kept) = static_cast<int>(corners[i]);
    ++kept;
  }
  out.triangles.conservativeResize(3, kept);
  return out;
}

}  // namespace acus::window
