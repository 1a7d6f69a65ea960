#include "acus/patient/segmentation/preview.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "acus/base/core/error.h"
#include "acus/data/image/png.h"
#include "acus/data/volume/labels.h"
#include "acus/patient/segmentation/voxels/mask.h"

namespace acus::segmentation {
namespace {

constexpr double kWindowLowHu = -160.0;
constexpr double kWindowHighHu = 240.0;
constexpr int kImageSize = 900;  ///< Pixels of the longer side.
constexpr int kLegendWidth = 190;
constexpr double kFontScale = 0.5;
const cv::Scalar kWhite(255, 255, 255);

/// How a plane lies in the image: patient axes (0 = L, 1 = P, 2 = S) to the right and down, with
/// sign, and the letters of the four sides.
struct View {
  int right_axis;
  int right_sign;
  int down_axis;
  int down_sign;
  const char* left;
  const char* right;
  const char* top;
  const char* bottom;
};

View ViewOf(Plane plane) {
  switch (plane) {
    case Plane::kAxial:
      return {0, 1, 1, 1, "R", "L", "A", "P"};
    case Plane::kCoronal:
      return {0, 1, 2, -1, "R", "L", "S", "I"};
    case Plane::kSagittal:
      break;
  }
  return {1, 1, 2, -1, "A", "P", "S", "I"};
}

/// For each patient axis, the grid axis nearest to it and whether it runs the same way.
struct AxisMap {
  std::array<int, 3> grid_axis{};
  std::array<int, 3> sign{};
};

AxisMap NearestAxes(const volume::Geometry& geometry) {
  AxisMap map;
  Eigen::Matrix3d left = geometry.direction.cwiseAbs();
  for (int step = 0; step < 3; ++step) {
    Eigen::Index patient = 0;
    Eigen::Index grid = 0;
    left.maxCoeff(&patient, &grid);
    map.grid_axis[static_cast<std::size_t>(patient)] = static_cast<int>(grid);
    map.sign[static_cast<std::size_t>(patient)] = geometry.direction(patient, grid) > 0 ? 1 : -1;
    left.row(patient).setConstant(-1.0);
    left.col(grid).setConstant(-1.0);
  }
  return map;
}

cv::Vec3b Bgr(volume::Label label) {
  // Bone's own colour could not be seen on bone, which is white in a CT.
  static const volume::Label kBone = volume::LabelOf("bone");
  if (label == kBone) return {255, 200, 0};
  const auto rgb = volume::ColourOf(label);
  return {rgb[2], rgb[1], rgb[0]};
}

/// The slice at pixel resolution: for every pixel the voxel under it.
class Slice {
 public:
  Slice(const volume::Geometry& g, Plane plane, const Eigen::Array3i& voxel) : voxel_(voxel) {
    const AxisMap map = NearestAxes(g);
    const View view = ViewOf(plane);
    u_axis_ = map.grid_axis[static_cast<std::size_t>(view.right_axis)];
    v_axis_ = map.grid_axis[static_cast<std::size_t>(view.down_axis)];
    u_flipped_ = map.sign[static_cast<std::size_t>(view.right_axis)] * view.right_sign < 0;
    v_flipped_ = map.sign[static_cast<std::size_t>(view.down_axis)] * view.down_sign < 0;
    nu_ = g.size[u_axis_];
    nv_ = g.size[v_axis_];
    const double width_mm = nu_ * g.spacing_mm[u_axis_];
    const double height_mm = nv_ * g.spacing_mm[v_axis_];
    pixels_per_mm_ = kImageSize / std::max(width_mm, height_mm);
    width_ = std::max(1, static_cast<int>(std::lround(width_mm * pixels_per_mm_)));
    height_ = std::max(1, static_cast<int>(std::lround(height_mm * pixels_per_mm_)));
  }
  int width() const { return width_; }
  int height() const { return height_; }
  double pixels_per_mm() const { return pixels_per_mm_; }
  Eigen::Array3i VoxelAt(int x, int y) const {
    const int u = std::min(nu_ - 1, x * nu_ / width_);
    const int v = std::min(nv_ - 1, y * nv_ / height_);
    Eigen::Array3i at = voxel_;
    at[u_axis_] = u_flipped_ ? nu_ - 1 - u : u;
    at[v_axis_] = v_flipped_ ? nv_ - 1 - v : v;
    return at;
  }

 private:
  Eigen::Array3i voxel_;
  int u_axis_, v_axis_, nu_, nv_, width_, height_;
  bool u_flipped_, v_flipped_;
  double pixels_per_mm_;
};

cv::Mat Image(const volume::CtVolume& ct, const volume::LabelMap& labels, const Slice& slice) {
  cv::Mat image(slice.height(), slice.width() + kLegendWidth, CV_8UC3, cv::Scalar(0, 0, 0));
  const auto label_at = [&](int x, int y) {
    const Eigen::Array3i v = slice.VoxelAt(x, y);
    return labels.At(v[0], v[1], v[2]);
  };
  for (int y = 0; y < slice.height(); ++y) {
    for (int x = 0; x < slice.width(); ++x) {
      const Eigen::Array3i v = slice.VoxelAt(x, y);
      const double hu = ct.At(v[0], v[1], v[2]);
      const double grey = 255.0 * (hu - kWindowLowHu) / (kWindowHighHu - kWindowLowHu);
      const auto level = static_cast<std::uint8_t>(std::clamp(grey, 0.0, 255.0));
      cv::Vec3b& pixel = image.at<cv::Vec3b>(y, x);
      pixel = {level, level, level};
      // The outline is drawn on the side of the label with the higher number, one pixel wide.
      const volume::Label here = label_at(x, y);
      const volume::Label beside = x + 1 < slice.width() ? label_at(x + 1, y) : here;
      const volume::Label below = y + 1 < slice.height() ? label_at(x, y + 1) : here;
      if (beside != here || below != here) pixel = Bgr(std::max({here, beside, below}));
    }
  }
  return image;
}

void Text(cv::Mat& image, const std::string& text, int x, int y) {
  cv::putText(image, text, {x, y}, cv::FONT_HERSHEY_SIMPLEX, kFontScale, kWhite, 1, cv::LINE_AA);
}

void DrawLegend(cv::Mat& image, const volume::LabelMap& labels, int left) {
  int y = 26;
  for (const auto& [label, name] : labels.names) {
    if (label == 0) continue;
    const cv::Vec3b colour = Bgr(label);
    cv::rectangle(image, {left + 12, y - 11, 16, 12}, cv::Scalar(colour), cv::FILLED);
    Text(image, name, left + 36, y);
    y += 22;
  }
}

void DrawScaleBar(cv::Mat& image, const Slice& slice) {
  const double width_mm = slice.width() / slice.pixels_per_mm();
  const int bar_mm = width_mm > 250.0 ? 100 : width_mm > 100.0 ? 50 : 10;
  const int length = static_cast<int>(std::lround(bar_mm * slice.pixels_per_mm()));
  const int y = slice.height() - 14;
  cv::rectangle(image, {14, y, length, 4}, kWhite, cv::FILLED);
  Text(image, Message(bar_mm, " mm"), 14, y - 8);
}

}  // namespace

Eigen::Array3i BodyCentre(const volume::LabelMap& labels) {
  Mask inside(labels.geometry);
  for (std::size_t i = 0; i < inside.voxels.size(); ++i) {
    inside.voxels[i] = labels.voxels[i] != 0 ? 1 : 0;
  }
  const Box box = BoundsOf(inside);
  return box.empty() ? Eigen::Array3i(labels.geometry.size / 2)
                     : Eigen::Array3i((box.low + box.high) / 2);
}

void WritePreview(const std::filesystem::path& path, const volume::CtVolume& ct,
                  const volume::LabelMap& labels, Plane plane, const Eigen::Array3i& voxel) {
  ACUS_REQUIRE((ct.geometry.size == labels.geometry.size).all(),
               "a preview needs CT and labels on one grid");
  const Slice slice(ct.geometry, plane, voxel);
  const View view = ViewOf(plane);
  cv::Mat drawing = Image(ct, labels, slice);
  DrawLegend(drawing, labels, slice.width());
  DrawScaleBar(drawing, slice);
  Text(drawing, view.left, 6, slice.height() / 2);
  Text(drawing, view.right, slice.width() - 18, slice.height() / 2);
  Text(drawing, view.top, slice.width() / 2, 18);
  Text(drawing, view.bottom, slice.width() / 2, slice.height() - 6);
  image::ColourImage image;
  image.Resize(drawing.cols, drawing.rows);
  cv::Mat rgb(drawing.rows, drawing.cols, CV_8UC3, image.rgb.data());
  cv::cvtColor(drawing, rgb, cv::COLOR_BGR2RGB);
  image::WritePng(path, image);
}

void WritePreviews(const std::filesystem::path& folder, const volume::CtVolume& ct,
                   const volume::LabelMap& labels) {
  const Eigen::Array3i centre = BodyCentre(labels);
  WritePreview(folder / "preview_axial.png", ct, labels, Plane::kAxial, centre);
  WritePreview(folder / "preview_coronal.png", ct, labels, Plane::kCoronal, centre);
  WritePreview(folder / "preview_sagittal.png", ct, labels, Plane::kSagittal, centre);
}

}  // namespace acus::segmentation
