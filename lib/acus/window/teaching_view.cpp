#include "acus/window/teaching_view.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "acus/imaging/volume_rendering/tools.h"

namespace acus::window {
namespace {

/// Direction to the light, CT space, while no tool is near a patient on his back: a lamp over the
/// bed.
const Eigen::Vector3d kOverTheBed(0.3, -1.0, 0.4);
/// The lamp moves when the cosine of its angle to the side of the tools is below this.
constexpr double kFromBehind = 0.45;
constexpr double kLeastNeedleRadiusMm = 0.9;
constexpr double kTargetRadiusMm = 3.0;
constexpr std::string_view kSkin = "skin";
constexpr int kFewestTriangles = 400;
/// Opacity of a shadow on the skin.
constexpr double kShadowOpacity = 0.65;

mesh::Surface Ball(double radius_mm) {
  Eigen::Matrix3Xd middle(3, 13);
  Eigen::VectorXd radii(13);
  for (int i = 0; i <= 12; ++i) {
    const double angle = std::numbers::pi * i / 12.0;
    middle.col(i) << 0.0, 0.0, -radius_mm * std::cos(angle);
    radii[i] = radius_mm * std::sin(angle);
  }
  return volume_rendering::Tube(middle, radii);
}

/// A surface before the real one is available: a thing needs triangles.
mesh::Surface Placeholder() {
  return Ball(1.0);
}

}  // namespace

TeachingView::TeachingView(const std::vector<volume_rendering::SurfaceInView>& surfaces,
                           int max_triangles) {
  layer_.SetBackground({0.17F, 0.20F, 0.24F}, {0.05F, 0.06F, 0.08F});
  double all = 0.0;
  for (const auto& seen : surfaces) all += static_cast<double>(seen.surface.triangles.cols());
  const auto add = [&](const volume_rendering::SurfaceInView& seen) {
    const double share = static_cast<double>(seen.surface.triangles.cols()) / std::max(all, 1.0);
    const int budget = std::max(kFewestTriangles, static_cast<int>(share * max_triangles));
    const mesh::Surface thin = Thinned(seen.surface, budget);
    const bool is_skin = seen.name == kSkin;
    // The texture of shadows contains the skin's own opacity.
    const double opacity = is_skin ? std::max(kShadowOpacity, seen.opacity) : seen.opacity;
    volume_rendering::MovingSurface moving(thin);
    box_in_ct_mm_.extend(moving.RestBox());
    const int thing = layer_.Add(
        thin, {.colour = seen.colour, .opacity = opacity, .lit = true, .both_sides = false});
    layer_.SetNodes(thing, moving.nodes_mm(), &moving.normals());
    if (is_skin) {
      skin_ = thing;
      skin_surface_ = thin;
      has_skin_ = true;
      lit_opacity_ = seen.opacity / opacity;
    }
    organs_.push_back({.thing = thing, .surface = std::move(moving), .pressed = {}});
  };
  // Transparent surfaces after those behind them, and the skin last.
  for (const auto& seen : surfaces) {
    if (seen.name != kSkin && seen.opacity >= 1.0) add(seen);
  }
  const auto tool = [&](const Eigen::Array3f& colour) {
    return layer_.Add(Placeholder(),
                      {.colour = colour, .opacity = 1.0, .lit = true, .both_sides = true});
  };
  shaft_ = tool({0.78F, 0.86F, 0.90F});
  marks_ = tool({0.08F, 0.10F, 0.12F});
  hub_ = tool({0.25F, 0.62F, 0.72F});
  probe_body_ = tool({0.80F, 0.81F, 0.83F});
  probe_mark_ = tool({0.38F, 0.75F, 0.50F});
  target_ = tool({0.98F, 0.80F, 0.25F});
  layer_.SetSurface(target_, Ball(kTargetRadiusMm));
  plane_ = layer_.Add(
      Placeholder(),
      {.colour = Eigen::Array3f::Ones(), .opacity = 1.0, .lit = false, .both_sides = true});
  for (const int thing : {shaft_, marks_, hub_, probe_body_, probe_mark_, target_, plane_}) {
    layer_.SetShown(thing, false);
  }
  for (const auto& seen : surfaces) {
    if (seen.name != kSkin && seen.opacity < 1.0) add(seen);
  }
  for (const auto& seen : surfaces) {
    if (seen.name == kSkin) add(seen);
  }
  SetLight(kOverTheBed);
}

void TeachingView::SetLight(const Eigen::Vector3d& towards) {
  towards_light_ = towards.normalized();
  layer_.SetLight(towards_light_);
  if (!has_skin_) return;
  shadows_ = std::make_unique<ShadowTexture>(skin_surface_, towards_light_);
  layer_.SetTexturePlaces(skin_, shadows_->PlacesOf(skin_surface_.nodes_mm));
  layer_.SetTexture(skin_, shadows_->Finish(lit_opacity_));
}

void TeachingView::AimLight(const DisplayFrame& frame) {
  Eigen::Vector3d tool;
  if (frame.needle) {
    const image::NeedleInImage& needle = *frame.needle;
    tool = needle.shape.num_points >= 2
               ? needle.shape.At(needle.shape.num_points - 1)
               : Eigen::Vector3d(needle.tip_in_ct_mm - needle.length_mm * needle.axis_in_ct);
  } else if (frame.ct_from_probe) {
    tool = frame.ct_from_probe->translation();
  } else {
    return;
  }
  Eigen::Vector3d side = tool - box_in_ct_mm_.center();
  side[2] = 0.0;  // The patient is long: only the direction around the axis is used.
  if (side.norm() < 1.0) return;
  side.normalize();
  if (side.dot(towards_light_) >= kFromBehind) return;
  // Oblique, or shadows would be hidden behind their tools; and from the head, unlike any preset.
  Eigen::Vector3d aslant = side.cross(Eigen::Vector3d::UnitZ());
  if (aslant.dot(kOverTheBed) < 0.0) aslant = -aslant;
  SetLight(side + 0.35 * aslant + 0.9 * Eigen::Vector3d::UnitZ());
}

/// First breath, then tools.
void TeachingView::UpdateOrgan(const DisplayFrame& frame, SpaceLayer& layer, Organ& organ) {
  const bool is_pressed = frame.pressed != nullptr && !frame.pressed->empty();
  if (frame.motion == nullptr && !is_pressed && !organ.is_pressed) return;
  organ.surface.Update(frame.motion, 1);
  const volume_rendering::MovingSurface& breathed = organ.surface;
  organ.is_pressed = is_pressed;
  if (!is_pressed) {
    layer.SetNodes(organ.thing, breathed.nodes_mm(), &breathed.normals());
    return;
  }
  organ.pressed.Update(*frame.pressed, breathed.nodes_mm(), breathed.normals(),
                       breathed.triangles(), 1);
  layer.SetNodes(organ.thing, organ.pressed.nodes_mm(), &organ.pressed.normals());
}

void TeachingView::Update(const DisplayFrame& frame) {
  for (Organ& organ : organs_) UpdateOrgan(frame, layer_, organ);
  UpdateNeedle(frame);
  UpdateProbe(frame);
  const bool has_target = frame.target_in_ct_mm && frame.target_in_ct_mm->allFinite();
  layer_.SetShown(target_, has_target);
  if (has_target) {
    layer_.SetPose(target_, Eigen::Isometry3d(Eigen::Translation3d(*frame.target_in_ct_mm)));
  }
  AimLight(frame);
  if (has_skin_) UpdateShadows(frame);
}

void TeachingView::UpdateNeedle(const DisplayFrame& frame) {
  layer_.SetShown(shaft_, frame.needle.has_value());
  layer_.SetShown(hub_, frame.needle.has_value());
  const mesh::Surface marks =
      frame.needle && frame.needle_graduation_mm > 0.0
          ? volume_rendering::NeedleMarks(*frame.needle, kLeastNeedleRadiusMm,
                                          frame.needle_graduation_mm)
          : mesh::Surface();
  layer_.SetShown(marks_, marks.triangles.cols() > 0);
  if (!frame.needle) return;
  if (marks.triangles.cols() > 0) layer_.SetSurface(marks_, marks);
  layer_.SetSurface(shaft_, volume_rendering::NeedleShaft(*frame.needle, kLeastNeedleRadiusMm));
  layer_.SetSurface(hub_, volume_rendering::NeedleHub(*frame.needle));
}

void TeachingView::UpdateProbe(const DisplayFrame& frame) {
  const auto& probe = frame.ultrasound.probe;
  const bool shown = frame.ct_from_probe && probe;
  for (const int thing : {probe_body_, probe_mark_, plane_}) layer_.SetShown(thing, shown);
  if (!shown) return;
  if (probe != probe_) {
    probe_ = probe;
    probe_surface_ = volume_rendering::ProbeBody(*probe);
    layer_.SetSurface(probe_body_, probe_surface_);
    layer_.SetSurface(probe_mark_, volume_rendering::ProbeMark(*probe));
    const volume_rendering::ImagePlane plane = volume_rendering::PlaneOf(*probe);
    layer_.SetSurface(plane_, plane.surface);
    const image::ImageGeometry image = acoustics::ImageOf(*probe);
    const Eigen::Array2f size(static_cast<float>(image.width_px),
                              static_cast<float>(image.height_px));
    layer_.SetTexturePlaces(plane_,
                            ((plane.pixel_of_node.array() + 0.5F).colwise() / size).matrix());
  }
  for (const int thing : {probe_body_, probe_mark_, plane_}) {
    layer_.SetPose(thing, *frame.ct_from_probe);
  }
  if (!frame.ultrasound.image.pixels.empty()) {
    layer_.SetTexture(plane_, frame.ultrasound.image);
  }
}

void TeachingView::UpdateShadows(const DisplayFrame& frame) {
  shadows_->Clear();
  if (frame.needle) {
    const image::NeedleInImage& needle = *frame.needle;
    if (needle.shape.num_points >= 2) {
      shadows_->AddLine(std::span(needle.shape.point_mm.data(),
                                  static_cast<std::size_t>(needle.shape.num_points)),
                        kLeastNeedleRadiusMm);
    } else {
      const std::array<Eigen::Vector3d, 2> ends{
          needle.tip_in_ct_mm, needle.tip_in_ct_mm - needle.length_mm * needle.axis_in_ct};
      shadows_->AddLine(ends, kLeastNeedleRadiusMm);
    }
    shadows_->AddSurface(volume_rendering::NeedleHub(needle), Eigen::Isometry3d::Identity());
  }
  if (frame.ct_from_probe && probe_) shadows_->AddSurface(probe_surface_, *frame.ct_from_probe);
  layer_.SetTexture(skin_, shadows_->Finish(lit_opacity_));
}

void TeachingView::SetPlace(const Rectangle& place, const Rectangle& window, const Orbit& orbit,
                            Stereo stereo) {
  const double distance = orbit.distance_mm();
  const double size = orbit.patient_size_mm();
  const DepthRange range{.near_mm = std::max(1.0, distance - 1.5 * size),
                         .far_mm = distance + 1.5 * size};
  if (place.width < 2 || place.height < 2) return Hide();
  if (stereo != Stereo::kSideBySide) {
    layer_.SetView(place, window, orbit.CameraFor(place.width, place.height), range,
                   FillsWindow(stereo));
    layer_.SetRightEye({}, window, std::nullopt, range);
    return;
  }
  // A base of a thirtieth of the distance is comfortable at a screen.
  const double half_base = distance / 60.0;
  Rectangle left = place;
  left.width = place.width / 2 - 1;
  Rectangle right = left;
  right.left = place.left + place.width - left.width;
  layer_.SetView(left, window, orbit.EyeFor(left.width, left.height, -half_base), range);
  layer_.SetRightEye(right, window, orbit.EyeFor(right.width, right.height, half_base), range);
}

void TeachingView::Hide() {
  layer_.SetView({}, {}, {}, {});
  layer_.SetRightEye({}, {}, std::nullopt, {});
}

}  // namespace acus::window
