#include "acus/window/video_view.h"

#include <algorithm>

#include "acus/imaging/volume_rendering/tools.h"

namespace acus::window {
namespace {

/// Two triangles, in order around the corners from the upper left one.
mesh::Surface Quad(const std::array<Eigen::Vector3d, 4>& corners_mm) {
  mesh::Surface out;
  out.nodes_mm.resize(3, 4);
  for (int i = 0; i < 4; ++i) out.nodes_mm.col(i) = corners_mm[static_cast<std::size_t>(i)];
  out.triangles.resize(3, 2);
  out.triangles << 0, 0, 1, 2, 2, 3;
  return out;
}

/// The position of a camera's image in space, if it is painted on a plane through the centre of the
/// box, perpendicular to the line of sight. From that camera it fits pixel by pixel; from another
/// one near by, points near the plane still do.
mesh::Surface PaintedThrough(const Eigen::Vector3d& middle_in_ct_mm,
                             const volume_rendering::Camera& camera) {
  const double depth = std::max(1.0, (camera.camera_from_ct * middle_in_ct_mm)[2]);
  const double right = camera.width_px - 0.5;
  const double bottom = camera.height_px - 0.5;
  const Eigen::Vector3d eye = camera.EyeInCtMm();
  const auto at = [&](double column, double row) -> Eigen::Vector3d {
    return eye + depth * camera.DirectionInCt({column, row});
  };
  return Quad({at(-0.5, -0.5), at(right, -0.5), at(right, bottom), at(-0.5, bottom)});
}

constexpr double kPlaneOpacity = 0.85;
constexpr double kBehind = 5.0;

}  // namespace

VideoView::VideoView(const volume_rendering::PatientInView& patient, const mesh::Surface* outline,
                     const OverlaySettings& settings) {
  if (patient.ct || !patient.surfaces.empty()) {
    overlay_ = std::make_unique<OverlayRenderer>(patient, outline, settings);
  }
  const Look painted{
      .colour = Eigen::Array3f::Ones(), .opacity = 1.0, .lit = false, .both_sides = true};
  mesh::Surface any;
  any.nodes_mm = Eigen::Matrix3Xd::Identity(3, 4);
  any = Quad({any.nodes_mm.col(0), any.nodes_mm.col(1), any.nodes_mm.col(2), any.nodes_mm.col(3)});
  sheet_ = layer_.Add(any, painted);
  Eigen::Matrix2Xf corners(2, 4);
  corners << 0, 1, 1, 0, 0, 0, 1, 1;
  layer_.SetTexturePlaces(sheet_, corners);
  plane_ = layer_.Add(any, painted);
}

void VideoView::Update(const DisplayFrame& frame, const Rectangle& place, const Rectangle& window,
                       double overlay_share) {
  const bool shown = frame.video && frame.video->pose_valid && !place.empty() &&
                     frame.video->camera.camera_from_ct.matrix().allFinite();
  if (!shown) {
    layer_.SetView({}, window, {}, {});
    return;
  }
  layer_.SetView(place, window, frame.video->camera, {.near_mm = 20.0, .far_mm = 4000.0 * kBehind});
  UpdateOverlay(frame, overlay_share);
  UpdatePlane(frame, overlay_share);
}

void VideoView::UpdateOverlay(const DisplayFrame& frame, double share) {
  if (!overlay_ || share <= 0.0) {
    layer_.SetShown(sheet_, false);
    return;
  }
  overlay_->Ask(frame.video->camera, frame.motion);
  if (overlay_->Take(image_)) {
    has_image_ = true;
    painted_ = PaintedThrough(overlay_->box_in_ct_mm().center(), image_.camera);
    layer_.SetTexture(
        sheet_,
        {.width = image_.camera.width_px, .height = image_.camera.height_px, .rgba = image_.rgba});
  }
  layer_.SetShown(sheet_, has_image_);
  if (!has_image_) return;
  // The depth along its rays makes no difference from here: behind everything else.
  const Eigen::Vector3d eye = frame.video->camera.EyeInCtMm();
  mesh::Surface behind = painted_;
  behind.nodes_mm = (kBehind * (painted_.nodes_mm.colwise() - eye)).colwise() + eye;
  layer_.SetSurface(sheet_, behind);
  layer_.SetOpacity(sheet_, share);
}

void VideoView::UpdatePlane(const DisplayFrame& frame, double share) {
  const auto& ultrasound = frame.ultrasound;
  const bool shown =
      frame.ct_from_probe && ultrasound.probe && !ultrasound.image.pixels.empty() && share > 0.0;
  layer_.SetShown(plane_, shown);
  if (!shown) return;
  if (ultrasound.probe != probe_) {
    probe_ = ultrasound.probe;
    const volume_rendering::ImagePlane plane = volume_rendering::PlaneOf(*probe_);
    layer_.SetSurface(plane_, plane.surface);
    const image::ImageGeometry image = acoustics::ImageOf(*probe_);
    const Eigen::Array2f size(static_cast<float>(image.width_px),
                              static_cast<float>(image.height_px));
    layer_.SetTexturePlaces(plane_,
                            ((plane.pixel_of_node.array() + 0.5F).colwise() / size).matrix());
  }
  layer_.SetPose(plane_, *frame.ct_from_probe);
  layer_.SetTexture(plane_, ultrasound.image);
  layer_.SetOpacity(plane_, kPlaneOpacity * std::min(1.0, share / 0.7));
}

}  // namespace acus::window
