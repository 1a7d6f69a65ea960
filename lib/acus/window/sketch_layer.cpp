#include "acus/window/sketch_layer.h"

#include <vtkCellArray.h>
#include <vtkFloatArray.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper2D.h>
#include <vtkRenderer.h>
#include <vtkTexture.h>
#include <vtkTexturedActor2D.h>
#include <vtkUnsignedCharArray.h>

namespace acus::window {

struct SketchLayer::Content {
  vtkNew<vtkRenderer> renderer;
  vtkNew<vtkImageData> image;
  vtkNew<vtkTexture> texture;
  vtkNew<vtkPoints> points;
  vtkNew<vtkFloatArray> at;
  vtkNew<vtkUnsignedCharArray> colours;
  vtkNew<vtkCellArray> cells;
  vtkNew<vtkPolyData> net;
  vtkNew<vtkPolyDataMapper2D> mapper;
  vtkNew<vtkTexturedActor2D> actor;
  Eigen::Array2f atlas_px;
};

SketchLayer::SketchLayer(const FontAtlas& atlas) : content_(std::make_unique<Content>()) {
  Content& c = *content_;
  c.atlas_px = {static_cast<float>(atlas.width()), static_cast<float>(atlas.height())};
  c.image->SetDimensions(atlas.width(), atlas.height(), 1);
  c.image->AllocateScalars(VTK_UNSIGNED_CHAR, 4);
  auto* pixel = static_cast<std::uint8_t*>(c.image->GetScalarPointer());
  for (const std::uint8_t opacity : atlas.opacity()) {
    for (int i = 0; i < 3; ++i) *pixel++ = 255;
    *pixel++ = opacity;
  }
  c.texture->SetInputData(c.image);
  c.texture->InterpolateOn();
  c.texture->SetColorModeToDirectScalars();
  c.texture->SetWrap(vtkTexture::ClampToEdge);
  c.points->SetDataTypeToFloat();
  c.at->SetNumberOfComponents(2);
  c.colours->SetNumberOfComponents(4);
  c.net->SetPoints(c.points);
  c.net->SetPolys(c.cells);
  c.net->GetPointData()->SetTCoords(c.at);
  c.net->GetPointData()->SetScalars(c.colours);
  c.mapper->SetInputData(c.net);
  c.actor->SetMapper(c.mapper);
  c.actor->SetTexture(c.texture);
  c.renderer->AddActor2D(c.actor);
  c.renderer->InteractiveOff();
}

SketchLayer::~SketchLayer() = default;

vtkRenderer* SketchLayer::renderer() {
  return content_->renderer;
}

void SketchLayer::Draw(const Sketch& sketch, int window_height_px) {
  Content& c = *content_;
  const auto& vertices = sketch.vertices();
  const auto count = static_cast<vtkIdType>(vertices.size());
  const auto before = c.points->GetNumberOfPoints();
  c.points->SetNumberOfPoints(count);
  c.at->SetNumberOfTuples(count);
  c.colours->SetNumberOfTuples(count);
  const auto height = static_cast<float>(window_height_px);
  for (vtkIdType i = 0; i < count; ++i) {
    const Sketch::Vertex& v = vertices[static_cast<std::size_t>(i)];
    c.points->SetPoint(i, v.x, height - v.y, 0.0);
    c.at->SetTuple2(i, v.u / c.atlas_px[0], v.v / c.atlas_px[1]);
    const std::uint8_t colour[] = {v.colour.red, v.colour.green, v.colour.blue, v.colour.opacity};
    c.colours->SetTypedTuple(i, colour);
  }
  if (count != before) {
    c.cells->Reset();
    for (vtkIdType i = 0; i + 3 < count; i += 4) {
      const vtkIdType corners[] = {i, i + 1, i + 2, i + 3};
      c.cells->InsertNextCell(4, corners);
    }
    c.cells->Modified();
  }
  c.points->Modified();
  c.at->Modified();
  c.colours->Modified();
  c.net->Modified();
}

}  // namespace acus::window
