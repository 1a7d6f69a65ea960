#include "acus/window/image_layer.h"

#include <cstring>
#include <optional>
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

#include "acus/window/sketch.h"

namespace acus::window {
namespace {

// Distortion is corrected piecewise: with pieces of 16 pixels in 640, to 0.1 pixel for k1 = -0.3.
constexpr int kColumns = 40;
constexpr int kRows = 30;

/// One image on a grid of points.
struct Sheet {
  vtkNew<vtkImageData> image;
  vtkNew<vtkTexture> texture;
  vtkNew<vtkPoints> points;
  vtkNew<vtkFloatArray> at;
  vtkNew<vtkPolyData> net;
  vtkNew<vtkPolyDataMapper2D> mapper;
  vtkNew<vtkTexturedActor2D> actor;
  int columns = 0;
  int rows = 0;

  Sheet() {
    texture->SetInputData(image);
    texture->InterpolateOn();
    texture->SetWrap(vtkTexture::ClampToEdge);
    texture->SetColorModeToDirectScalars();
    at->SetNumberOfComponents(2);
    net->SetPoints(points);
    net->GetPointData()->SetTCoords(at);
    mapper->SetInputData(net);
    actor->SetMapper(mapper);
    actor->SetTexture(texture);
    actor->VisibilityOff();
  }

  void SetPixels(int width, int height, int components, const std::uint8_t* pixels) {
    const int* size = image->GetDimensions();
    if (size[0] != width || size[1] != height ||
        image->GetNumberOfScalarComponents() != components ||
        image->GetScalarPointer() == nullptr) {
      image->SetDimensions(width, height, 1);
      image->AllocateScalars(VTK_UNSIGNED_CHAR, components);
    }
    // An unchanged image is not sent to the graphics card again.
    const std::size_t bytes = static_cast<std::size_t>(width) * static_cast<std::size_t>(height) *
                              static_cast<std::size_t>(components);
    if (std::memcmp(image->GetScalarPointer(), pixels, bytes) == 0) return;
    std::memcpy(image->GetScalarPointer(), pixels, bytes);
    image->Modified();
  }

  void SetNet(int new_columns, int new_rows) {
    if (columns == new_columns && rows == new_rows) return;
    columns = new_columns;
    rows = new_rows;
    const vtkIdType count = static_cast<vtkIdType>(columns + 1) * (rows + 1);
    points->SetNumberOfPoints(count);
    at->SetNumberOfTuples(count);
    vtkNew<vtkCellArray> cells;
    for (int r = 0; r < rows; ++r) {
      for (int c = 0; c < columns; ++c) {
        const vtkIdType first = static_cast<vtkIdType>(r) * (columns + 1) + c;
        const vtkIdType corners[] = {first, first + 1, first + columns + 2, first + columns + 1};
        cells->InsertNextCell(4, corners);
      }
    }
    net->SetPolys(cells);
  }
  void SetNode(int column, int row, const Eigen::Vector2d& place,
               const Eigen::Vector2d& in_texture) {
    const vtkIdType node = static_cast<vtkIdType>(row) * (columns + 1) + column;
    points->SetPoint(node, place[0], place[1], 0.0);
    at->SetTuple2(node, in_texture[0], in_texture[1]);
  }
};

}  // namespace

Eigen::Vector2d Distorted(const Eigen::Vector2d& pixel, const volume_rendering::Camera& camera,
                          const std::array<double, 5>& distortion) {
  const auto& [k1, k2, p1, p2, k3] = distortion;
  const Eigen::Vector2d slope = (pixel - camera.centre_px).cwiseQuotient(camera.focal_px);
  const double x = slope[0];
  const double y = slope[1];
  const double r2 = x * x + y * y;
  const double radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
  const Eigen::Vector2d bent(radial * x + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
                             radial * y + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y);
  return bent.cwiseProduct(camera.focal_px) + camera.centre_px;
}

struct ImageLayer::Content {
  vtkNew<vtkRenderer> renderer;
  std::array<Sheet, kViewKinds.size()> sheets;
  int height_px = 0;

  Sheet& Of(ViewKind view) { return sheets[static_cast<std::size_t>(view)]; }
  /// VTK counts rows from below.
  Eigen::Vector2d Place(double column, double row) const { return {column, height_px - row}; }
};

ImageLayer::ImageLayer() : content_(std::make_unique<Content>()) {
  vtkRenderer& renderer = *content_->renderer;
  constexpr Colour kBack = palette::kPanel;
  renderer.SetBackground(kBack.red / 255.0, kBack.green / 255.0, kBack.blue / 255.0);
  renderer.InteractiveOff();
  for (Sheet& sheet : content_->sheets) renderer.AddActor2D(sheet.actor);
}

ImageLayer::~ImageLayer() = default;

vtkRenderer* ImageLayer::renderer() {
  return content_->renderer;
}

void ImageLayer::SetWindowSize(int /*width_px*/, int height_px) {
  content_->height_px = height_px;
}

void ImageLayer::Show(ViewKind view, const image::GrayImage& image, const Rectangle& place) {
  Show(view, image.width, image.height, 1, image.pixels, place);
}

void ImageLayer::Show(ViewKind view, const image::ColourImage& image, const Rectangle& place) {
  Show(view, image.width, image.height, 3, image.rgb, place);
}

void ImageLayer::Show(ViewKind view, int width, int height, int components,
                      const std::vector<std::uint8_t>& pixels, const Rectangle& place) {
  Sheet& sheet = content_->Of(view);
  sheet.actor->SetVisibility(!place.empty() && !pixels.empty());
  if (sheet.actor->GetVisibility() == 0) return;
  sheet.SetPixels(width, height, components, pixels.data());
  sheet.SetNet(1, 1);
  for (const int row : {0, 1}) {
    for (const int column : {0, 1}) {
      sheet.SetNode(
          column, row,
          content_->Place(place.left + column * place.width, place.top + row * place.height),
          Eigen::Vector2d(column, row));
    }
  }
  sheet.points->Modified();
  sheet.at->Modified();
}

void ImageLayer::Show(const image::ColourImage& image, const volume_rendering::Camera& camera,
                      const std::array<double, 5>& distortion, const Rectangle& place) {
  Sheet& sheet = content_->Of(ViewKind::kVideo);
  sheet.actor->SetVisibility(!place.empty() && !image.rgb.empty());
  if (sheet.actor->GetVisibility() == 0) return;
  sheet.texture->SetWrap(vtkTexture::ClampToBorder);
  sheet.SetPixels(image.width, image.height, 3, image.rgb.data());
  const bool bent = distortion != std::array<double, 5>{};
  sheet.SetNet(bent ? kColumns : 1, bent ? kRows : 1);
  const Eigen::Array2d size(image.width, image.height);
  for (int r = 0; r <= sheet.rows; ++r) {
    for (int c = 0; c <= sheet.columns; ++c) {
      const Eigen::Array2d share(static_cast<double>(c) / sheet.columns,
                                 static_cast<double>(r) / sheet.rows);
      const Eigen::Vector2d pixel = (share * size - 0.5).matrix();
      const Eigen::Vector2d seen = bent ? Distorted(pixel, camera, distortion) : pixel;
      sheet.SetNode(
          c, r,
          content_->Place(place.left + share[0] * place.width, place.top + share[1] * place.height),
          ((seen.array() + 0.5) / size).matrix());
    }
  }
  sheet.points->Modified();
  sheet.at->Modified();
}

void ImageLayer::Hide(ViewKind view) {
  content_->Of(view).actor->VisibilityOff();
}

}  // namespace acus::window
