#include "acus/rig/camera/canvas.h"

#include <algorithm>
#include <cmath>

#include "acus/base/core/error.h"

namespace acus::camera {
namespace {

/// Light from the upper left of the camera, and from all around.
float Lambert(const Eigen::Vector3d& normal_in_camera) {
  static const Eigen::Vector3d to_light = Eigen::Vector3d(-0.35, -0.6, -0.72).normalized();
  return static_cast<float>(0.45 + 0.55 * std::max(0.0, normal_in_camera.dot(to_light)));
}

struct Corner {
  Eigen::Vector2d pixel;
  double inverse_z;
  float light;
};

/// Twice the signed area: above 0 if a, b, c turn clockwise as seen (rows grow downwards).
double Turn(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

void PaintTriangle(const Corner& a, const Corner& b, const Corner& c, const Eigen::Array3f& colour,
                   Canvas& canvas) {
  const double area = Turn(a.pixel, b.pixel, c.pixel);
  const auto first = [](double lowest) { return std::max(0, static_cast<int>(std::ceil(lowest))); };
  const int left = first(std::min({a.pixel[0], b.pixel[0], c.pixel[0]}));
  const int top = first(std::min({a.pixel[1], b.pixel[1], c.pixel[1]}));
  const int right = std::min(canvas.width_px - 1,
                             static_cast<int>(std::max({a.pixel[0], b.pixel[0], c.pixel[0]})));
  const int bottom = std::min(canvas.height_px - 1,
                              static_cast<int>(std::max({a.pixel[1], b.pixel[1], c.pixel[1]})));
  const float luma = colour.matrix().dot(Eigen::Vector3f(0.299F, 0.587F, 0.114F));
  for (int row = top; row <= bottom; ++row) {
    for (int column = left; column <= right; ++column) {
      const Eigen::Vector2d p(column, row);
      const double wa = Turn(b.pixel, c.pixel, p) / area;
      const double wb = Turn(c.pixel, a.pixel, p) / area;
      const double wc = 1.0 - wa - wb;
      if (wa < 0.0 || wb < 0.0 || wc < 0.0) continue;
      const double inverse_z = wa * a.inverse_z + wb * b.inverse_z + wc * c.inverse_z;
      const std::size_t at = canvas.Pixel(column, row);
      const auto z = static_cast<float>(1.0 / inverse_z);
      if (!(z < canvas.z_mm[at])) continue;
      canvas.z_mm[at] = z;
      const auto light = static_cast<float>(wa * a.light + wb * b.light + wc * c.light);
      if (canvas.channels == 1) {
        canvas.level[at] = light * luma;
      } else {
        for (int k = 0; k < 3; ++k) canvas.level[3 * at + k] = light * colour[k];
      }
    }
  }
}

/// From a line of sight (x, y, 1) to a place on a marker's plane, times w: a homography. The third
/// row is w; above 0 where the plane is before the camera.
Eigen::Matrix3d PlaneFromSlope(const Eigen::Isometry3d& camera_from_sheet) {
  Eigen::Matrix3d slope_from_plane;
  slope_from_plane << camera_from_sheet.linear().col(0), camera_from_sheet.linear().col(1),
      camera_from_sheet.translation();
  Eigen::Matrix3d inverse = slope_from_plane.inverse();
  // w = 1/z of the point, up to here.
  return inverse;
}

struct Box {
  int left, top, right, bottom;
};

/// Pixels around the sheet's outline, by points along it; empty if one of them is not seen.
Box BoxOf(const Eigen::Isometry3d& camera_from_sheet, const Eigen::Array2d& half_mm,
          const CameraModel& camera) {
  Eigen::AlignedBox2d box;
  constexpr int kSteps = 8;
  for (int i = 0; i < kSteps; ++i) {
    const double t = 2.0 * i / kSteps - 1.0;
    for (const Eigen::Array2d& share : {Eigen::Array2d(t, 1), Eigen::Array2d(1, -t),
                                        Eigen::Array2d(-t, -1), Eigen::Array2d(-1, t)}) {
      const Eigen::Vector3d at(share[0] * half_mm[0], share[1] * half_mm[1], 0.0);
      const auto pixel = camera.Project(camera_from_sheet * at);
      if (!pixel) return {0, 0, -1, -1};
      box.extend(*pixel);
    }
  }
  const CameraParameters& p = camera.parameters();
  const auto clamped = [](double value, int last) {
    return static_cast<int>(std::clamp(value, -1.0, last + 1.0));
  };
  return {std::max(0, clamped(std::floor(box.min()[0]) - 1, p.width_px)),
          std::max(0, clamped(std::floor(box.min()[1]) - 1, p.height_px)),
          std::min(p.width_px - 1, clamped(std::ceil(box.max()[0]) + 1, p.width_px)),
          std::min(p.height_px - 1, clamped(std::ceil(box.max()[1]) + 1, p.height_px))};
}

/// What is where on a sheet.
class Print {
 public:
  Print(const PrintedSheet& sheet, bool from_behind)
      : sheet_(sheet),
        columns_(static_cast<double>(sheet.bits[0].size())),
        rows_(static_cast<double>(sheet.bits.size())),
        half_mm_(0.5 * sheet.module_mm * Eigen::Array2d(columns_, rows_) + sheet.margin_mm),
        from_behind_(from_behind) {}
  const Eigen::Array2d& half_mm() const { return half_mm_; }
  bool OnPaper(double x_mm, double y_mm) const {
    return std::abs(x_mm) <= half_mm_[0] && std::abs(y_mm) <= half_mm_[1];
  }
  bool White(double x_mm, double y_mm) const {
    if (from_behind_) return true;
    const double column = std::floor(x_mm / sheet_.module_mm + 0.5 * columns_);
    const double row = std::floor(0.5 * rows_ - y_mm / sheet_.module_mm);
    if (column < 0.0 || row < 0.0 || column >= columns_ || row >= rows_) return true;
    return sheet_.bits[static_cast<std::size_t>(row)][static_cast<std::size_t>(column)];
  }

 private:
  const PrintedSheet& sheet_;
  double columns_, rows_;
  Eigen::Array2d half_mm_;
  bool from_behind_;
};

/// Places in a pixel, -0.5 to 0.5: Hammersley's points, of which no two are in one row or column
/// and no direction is favoured, so that every edge is placed as finely as others.
std::vector<Eigen::Vector2d> SamplePlaces(int samples) {
  const int count = samples * samples;
  std::vector<Eigen::Vector2d> places;
  for (int i = 0; i < count; ++i) {
    double mirrored = 0.0;
    double digit = 0.5;
    for (int rest = i; rest > 0; rest /= 2, digit *= 0.5) mirrored += digit * (rest % 2);
    places.emplace_back((i + 0.5) / count - 0.5, mirrored + 0.5 / count - 0.5);
  }
  return places;
}

}  // namespace

void Canvas::Resize(int new_width_px, int new_height_px, int new_channels) {
  width_px = new_width_px;
  height_px = new_height_px;
  channels = new_channels;
  const std::size_t pixels =
      static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px);
  level.resize(pixels * static_cast<std::size_t>(channels));
  z_mm.assign(pixels, std::numeric_limits<float>::infinity());
}

RayTable::RayTable(const CameraModel& camera)
    : width_px_(camera.parameters().width_px), height_px_(camera.parameters().height_px) {
  slopes_.reserve(static_cast<std::size_t>(width_px_) * static_cast<std::size_t>(height_px_));
  for (int row = 0; row < height_px_; ++row) {
    for (int column = 0; column < width_px_; ++column) {
      const auto ray = camera.Ray({column, row});
      ACUS_ASSERT(ray.has_value());  // CameraModel's constructor saw to that.
      slopes_.emplace_back(ray->head<2>());
    }
  }
}

Eigen::Vector2d RayTable::Slope(double column, double row) const {
  const int c = std::clamp(static_cast<int>(column), 0, width_px_ - 2);
  const int r = std::clamp(static_cast<int>(row), 0, height_px_ - 2);
  const double u = column - c;
  const double v = row - r;
  const Eigen::Vector2d* at = &slopes_[static_cast<std::size_t>(r) * width_px_ + c];
  return (1.0 - v) * ((1.0 - u) * at[0] + u * at[1]) +
         v * ((1.0 - u) * at[width_px_] + u * at[width_px_ + 1]);
}

ShadedBody PrepareBody(const mesh::Surface& surface, const Eigen::Array3f& srgb) {
  ACUS_REQUIRE(surface.nodes_mm.allFinite() && surface.triangles.cols() > 0,
               "the body's surface has no triangle, or a node that is not finite");
  ACUS_REQUIRE(
      surface.triangles.minCoeff() >= 0 && surface.triangles.maxCoeff() < surface.nodes_mm.cols(),
      "the body's surface has a triangle of nodes that it does not have");
  ShadedBody body{.surface = surface,
                  .normals = Eigen::Matrix3Xd::Zero(3, surface.nodes_mm.cols()),
                  .colour = 255.0F * srgb};
  for (Eigen::Index t = 0; t < surface.triangles.cols(); ++t) {
    const Eigen::Vector3i nodes = surface.triangles.col(t);
    const Eigen::Vector3d a = surface.nodes_mm.col(nodes[0]);
    const Eigen::Vector3d normal =
        (surface.nodes_mm.col(nodes[1]) - a).cross(surface.nodes_mm.col(nodes[2]) - a);
    for (int k = 0; k < 3; ++k) body.normals.col(nodes[k]) += normal;
  }
  for (Eigen::Index n = 0; n < body.normals.cols(); ++n) body.normals.col(n).stableNormalize();
  return body;
}

void PaintBody(const ShadedBody& body, const Eigen::Isometry3d& camera_from_body,
               const CameraModel& camera, Canvas& canvas) {
  const Eigen::Index count = body.surface.nodes_mm.cols();
  std::vector<Corner> corners(static_cast<std::size_t>(count));
  for (Eigen::Index n = 0; n < count; ++n) {
    const Eigen::Vector3d at = camera_from_body * Eigen::Vector3d(body.surface.nodes_mm.col(n));
    const auto pixel = camera.Project(at);
    corners[static_cast<std::size_t>(n)] = {
        .pixel = pixel.value_or(Eigen::Vector2d::Zero()),
        .inverse_z = pixel ? 1.0 / at[2] : 0.0,
        .light = Lambert(camera_from_body.linear() * body.normals.col(n))};
  }
  for (Eigen::Index t = 0; t < body.surface.triangles.cols(); ++t) {
    const Corner& a = corners[static_cast<std::size_t>(body.surface.triangles(0, t))];
    const Corner& b = corners[static_cast<std::size_t>(body.surface.triangles(1, t))];
    const Corner& c = corners[static_cast<std::size_t>(body.surface.triangles(2, t))];
    if (a.inverse_z == 0.0 || b.inverse_z == 0.0 || c.inverse_z == 0.0) continue;
    // Counter-clockwise from outside is negative here, where rows grow downwards.
    if (Turn(a.pixel, b.pixel, c.pixel) >= 0.0) continue;
    PaintTriangle(a, b, c, body.colour, canvas);
  }
}

PrintedSheet PrintMarker(const std::string& dictionary, int id, double side_mm) {
  const auto code = MarkerBits(dictionary, id);
  const std::size_t modules = code.size() + 2;
  PrintedSheet sheet;
  sheet.module_mm = side_mm / static_cast<double>(modules);
  sheet.margin_mm = sheet.module_mm;
  sheet.bits.assign(modules, std::vector<bool>(modules, false));
  for (std::size_t row = 0; row < code.size(); ++row) {
    std::copy(code[row].begin(), code[row].end(), sheet.bits[row + 1].begin() + 1);
  }
  return sheet;
}

void PaintSheet(const PrintedSheet& sheet, const Eigen::Isometry3d& camera_from_sheet,
                const Ink& ink, const CameraModel& camera, const RayTable& rays, Canvas& canvas) {
  Eigen::Vector3d normal = camera_from_sheet.linear().col(2);
  const bool from_behind = normal.dot(camera_from_sheet.translation()) > 0.0;
  if (from_behind) normal = -normal;
  const Print print(sheet, from_behind);
  const Box box = BoxOf(camera_from_sheet, print.half_mm(), camera);
  const Eigen::Matrix3d plane_from_slope = PlaneFromSlope(camera_from_sheet);
  const float light = Lambert(normal);
  const std::vector<Eigen::Vector2d> places = SamplePlaces(ink.samples);
  const auto count = static_cast<int>(places.size());
  for (int row = box.top; row <= box.bottom; ++row) {
    for (int column = box.left; column <= box.right; ++column) {
      const std::size_t at = canvas.Pixel(column, row);
      int paper = 0;
      int white = 0;
      double inverse_z = 0.0;
      for (const Eigen::Vector2d& in_pixel : places) {
        const Eigen::Vector2d slope = rays.Slope(column + in_pixel[0], row + in_pixel[1]);
        const Eigen::Vector3d place = plane_from_slope * slope.homogeneous();
        if (!(place[2] > 0.0)) continue;
        const double x_mm = place[0] / place[2];
        const double y_mm = place[1] / place[2];
        if (!print.OnPaper(x_mm, y_mm)) continue;
        ++paper;
        white += print.White(x_mm, y_mm) ? 1 : 0;
        inverse_z = place[2];
      }
      if (paper == 0) continue;
      const auto z = static_cast<float>(1.0 / inverse_z);
      if (!(z < canvas.z_mm[at] + 1e-3F)) continue;
      const float share = static_cast<float>(paper) / static_cast<float>(count);
      const float tone = ink.black + (ink.white - ink.black) * static_cast<float>(white) /
                                         static_cast<float>(paper);
      for (int k = 0; k < canvas.channels; ++k) {
        float& level = canvas.level[at * static_cast<std::size_t>(canvas.channels) + k];
        level += share * (light * tone - level);
      }
      if (2 * paper > count) canvas.z_mm[at] = z;
    }
  }
}

}  // namespace acus::camera
