#include "acus/window/marks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "acus/base/translation/translation.h"
#include "acus/imaging/volume_rendering/tools.h"

namespace acus::window {
namespace {

using translation::Translated;

/// Farther from the plane than this, a point is not in the image.
constexpr double kInPlaneMm = 3.0;

Eigen::Vector2i Corner(int column, int row) {
  return {column, row};
}

void DrawDepthScale(const PlaneOnScreen& plane, const acoustics::Probe& probe,
                    const TextSizes& sizes, Sketch& sketch) {
  const double px_per_mm =
      plane.place.height / (plane.geometry.height_px * plane.geometry.axial_mm_per_px);
  const double top = plane.place.top - px_per_mm * plane.geometry.depth_of_top_row_mm;
  const int left = plane.place.left - 6;
  const double scale = MarkScale(sizes);
  const int label_mm = px_per_mm * 10.0 > 22.0 ? 10 : 20;
  for (int mm = 0; mm <= static_cast<int>(probe.depth_mm + 0.5); mm += 5) {
    const double row = top + px_per_mm * mm;
    if (row > plane.place.top + plane.place.height) break;
    const bool is_cm = mm % 10 == 0;
    if (!is_cm && px_per_mm < 1.6) continue;
    sketch.Line({left - (is_cm ? 8 : 4), row}, {left, row}, scale, palette::kFaint);
    if (mm % label_mm != 0) continue;
    const int middle = static_cast<int>(row) - sketch.TextHeight(sizes.small_px) / 2;
    sketch.Text(Corner(left - 12, middle), std::to_string(mm / 10),
                {.size_px = sizes.small_px, .colour = palette::kFaint, .align = Align::kRight});
  }
  const double focus = top + px_per_mm * probe.focus_mm;
  if (probe.focus_mm > 0.0 && focus < plane.place.top + plane.place.height) {
    sketch.Triangle({left + 1.0, focus - 5.0 * scale}, {left + 1.0, focus + 5.0 * scale},
                    {left - 7.0 * scale, focus}, palette::kNeedle);
  }
}

/// The path ahead of the tip, up to the border of the image.
void DrawGuide(const image::NeedleInImage& needle, const PlaneOnScreen& plane, double scale,
               Sketch& sketch) {
  constexpr double kAheadMm = 200.0;
  Eigen::Vector3d tip_mm = needle.tip_in_ct_mm;
  Eigen::Vector3d axis = needle.axis_in_ct;
  if (needle.shape.num_points >= 2) {
    tip_mm = needle.shape.At(0);
    axis = (needle.shape.At(0) - needle.shape.At(1)).normalized();
  }
  const Eigen::Vector3d tip = plane.At(tip_mm);
  const Eigen::Vector3d ahead = plane.At(tip_mm + kAheadMm * axis);
  if (!tip.allFinite() || !ahead.allFinite()) return;
  sketch.Dashes(tip.head<2>(), ahead.head<2>(), scale, palette::kNeedle.Faded(0.75));
  // The intersection with the plane, if it is ahead of the tip.
  const double leaves = tip[2] - ahead[2];
  if (std::abs(leaves) < 1e-6) return;
  const double share = tip[2] / leaves;
  if (share <= 0.0 || share >= 1.0 || std::abs(tip[2]) < kInPlaneMm) return;
  sketch.Ring((tip + share * (ahead - tip)).head<2>(), 5.0 * scale, scale, palette::kNeedle);
}

void DrawTargetIn(const PlaneOnScreen& plane, const Eigen::Vector3d& target_mm,
                  const TextSizes& sizes, bool with_distance, Sketch& sketch) {
  const Eigen::Vector3d at = plane.At(target_mm);
  if (!at.allFinite()) return;
  const bool in_plane = std::abs(at[2]) <= kInPlaneMm;
  const Colour colour = palette::kTarget.Faded(in_plane ? 1.0 : 0.55);
  const double scale = MarkScale(sizes);
  sketch.Ring(at.head<2>(), 8.0 * scale, 1.5 * scale, colour);
  if (in_plane) sketch.Dot(at.head<2>(), 2.0 * scale, colour);
  const bool inside = plane.place.Contains(static_cast<int>(at[0]), static_cast<int>(at[1]));
  if (in_plane || !with_distance || !inside) return;
  const std::string text = Translated("{1} mm off plane", {Digits(std::abs(at[2]), 0)});
  const bool to_the_left = at[0] > plane.place.left + 0.6 * plane.place.width;
  sketch.Text(Corner(static_cast<int>(at[0] + (to_the_left ? -13.0 : 13.0) * scale),
                     static_cast<int>(at[1]) - sketch.TextHeight(sizes.small_px) / 2),
              text,
              {.size_px = sizes.small_px,
               .colour = colour,
               .align = to_the_left ? Align::kRight : Align::kLeft,
               .shade = true});
}

}  // namespace

std::string Digits(double value, int after_point) {
  std::array<char, 40> out{};
  std::snprintf(out.data(), out.size(), "%.*f", after_point, value);
  return out.data();
}

TextSizes SizesFor(int window_height_px) {
  const double scale = std::clamp(window_height_px / 800.0, 0.8, 2.8);
  const auto size = [&](double px) { return static_cast<int>(std::lround(scale * px)); };
  return {.small_px = size(13.0), .normal_px = size(15.0), .large_px = size(24.0)};
}

double MarkScale(const TextSizes& sizes) {
  return sizes.small_px / 13.0;
}

int Scaled(int px, const TextSizes& sizes) {
  return static_cast<int>(std::lround(px * MarkScale(sizes)));
}

Rectangle ImageRoom(ViewKind view, const Rectangle& place, const TextSizes& sizes) {
  const int title = sizes.normal_px + 12;
  const bool is_ultrasound = view == ViewKind::kUltrasound;
  const int side = is_ultrasound ? 4 * sizes.small_px : 6;
  const int below = is_ultrasound ? sizes.normal_px + 12 : 6;
  Rectangle out = place;
  if (view == ViewKind::kTeaching || view == ViewKind::kVolume) {
    out.top += title;
    out.height -= title;
    return out;
  }
  out.left += side;
  out.width -= 2 * side;
  out.top += title;
  out.height -= title + below;
  return out;
}

double PlaneOnScreen::PxPerMm() const {
  return place.width / (geometry.width_px * geometry.lateral_mm_per_px);
}

Eigen::Vector3d PlaneOnScreen::At(const Eigen::Vector3d& place_in_ct_mm) const {
  const Eigen::Vector3d in_probe = ct_from_probe.inverse() * place_in_ct_mm;
  const Eigen::Vector3d pixel = geometry.probe_from_image().inverse() * in_probe;
  return {place.left + (pixel[0] + 0.5) * place.width / geometry.width_px,
          place.top + (pixel[1] + 0.5) * place.height / geometry.height_px, in_probe[2]};
}

void DrawTitle(std::string_view title, std::string_view detail, const Rectangle& place,
               const TextSizes& sizes, Sketch& sketch, Colour detail_colour) {
  const int top = place.top + 5;
  const int used = sketch.Text(Corner(place.left + 10, top), title,
                               {.size_px = sizes.normal_px, .bold = true, .shade = true},
                               std::max(0, place.width - 20));
  const int room = place.width - used - 44;
  if (detail.empty() || room < 40) return;
  sketch.Text(
      Corner(place.left + place.width - 10, top + 1), detail,
      {.size_px = sizes.small_px, .colour = detail_colour, .align = Align::kRight, .shade = true},
      room);
}

void DrawUltrasoundMarks(const DisplayFrame& frame, const Rectangle& place,
                         const PlaneOnScreen& plane, const ViewChoice& choice, Sketch& sketch,
                         const TextSizes& sizes) {
  const acoustics::Probe& probe = *frame.ultrasound.probe;
  sketch.SetClip(place);
  const std::string title = Translated(TitleOf(ViewKind::kUltrasound));
  if (frame.ultrasound.frozen) {
    DrawTitle(title, Translated("FROZEN: F resumes"), place, sizes, sketch, palette::kWarning);
  } else {
    DrawTitle(title, probe.name + ", " + Digits(probe.frequency_mhz, 1) + " MHz", place, sizes,
              sketch);
  }
  DrawDepthScale(plane, probe, sizes, sketch);
  sketch.SetClip(plane.place);
  // The marked side, as the ridge on the probe: on the right, in the direction of +x.
  const double scale = MarkScale(sizes);
  const double inset = 12.0 * scale;
  sketch.Ring({plane.place.left + plane.place.width - inset, plane.place.top + inset}, 6.0 * scale,
              2.0 * scale, palette::kGood);
  if (frame.ct_from_probe) {
    if (frame.needle && choice.needle_guide) DrawGuide(*frame.needle, plane, scale, sketch);
    if (frame.target_in_ct_mm) DrawTargetIn(plane, *frame.target_in_ct_mm, sizes, true, sketch);
  }
  sketch.SetClip(place);
  const int below = place.top + place.height - sizes.normal_px - 8;
  const std::string readout = Translated("Depth {1} cm", {Digits(probe.depth_mm / 10.0, 1)}) +
                              "    " + Translated("Gain {1} dB", {Digits(probe.gain_db, 0)});
  sketch.Text(Corner(place.left + place.width / 2, below), readout,
              {.size_px = sizes.small_px, .align = Align::kMiddle}, place.width - 20);
  if (frame.ultrasound.frozen) sketch.Frame(plane.place, palette::kWarning);
}

void DrawSliceMarks(const DisplayFrame& frame, const PlaneOnScreen& plane, const TextSizes& sizes,
                    Sketch& sketch) {
  sketch.SetClip(plane.place);
  if (frame.target_in_ct_mm) DrawTargetIn(plane, *frame.target_in_ct_mm, sizes, false, sketch);
  if (!frame.needle) return;
  const math::Polyline& shape = frame.needle->shape;
  const Eigen::Vector3d tip =
      plane.At(shape.num_points >= 2 ? shape.At(0) : frame.needle->tip_in_ct_mm);
  const double scale = MarkScale(sizes);
  if (std::abs(tip[2]) > kInPlaneMm) return;
  sketch.Ring(tip.head<2>(), 4.0 * scale, scale, palette::kNeedle);
}

void DrawVideoMarks(const DisplayFrame& frame, const Rectangle& place, const TextSizes& sizes,
                    Sketch& sketch) {
  if (!frame.video || !frame.video->pose_valid) return;
  const volume_rendering::Camera& camera = frame.video->camera;
  const double scale = MarkScale(sizes);
  const auto on_screen = [&](const Eigen::Vector3d& at) -> std::optional<Eigen::Vector2d> {
    if (!at.allFinite() || (camera.camera_from_ct * at)[2] < 1.0) return std::nullopt;
    const Eigen::Array2d share =
        (camera.ProjectPx(at).array() + 0.5) / Eigen::Array2d(camera.width_px, camera.height_px);
    return Eigen::Vector2d(place.left + share[0] * place.width,
                           place.top + share[1] * place.height);
  };
  const auto line = [&](const Eigen::Vector3d& a, const Eigen::Vector3d& b, double width,
                        Colour colour) {
    const auto from = on_screen(a);
    const auto to = on_screen(b);
    if (from && to) sketch.Line(*from, *to, width * scale, colour);
  };
  sketch.SetClip(place);
  if (frame.ct_from_probe && frame.ultrasound.probe) {
    const Eigen::Matrix3Xd outline =
        *frame.ct_from_probe * volume_rendering::PlaneOf(*frame.ultrasound.probe).outline_mm;
    for (Eigen::Index i = 1; i < outline.cols(); ++i) {
      line(outline.col(i - 1), outline.col(i), 1.0, palette::kText.Faded(0.6));
    }
  }
  if (frame.needle) {
    const image::NeedleInImage& needle = *frame.needle;
    if (needle.shape.num_points >= 2) {
      for (int i = 1; i < needle.shape.num_points; ++i) {
        line(needle.shape.At(i - 1), needle.shape.At(i), 2.0, palette::kNeedle);
      }
    } else {
      line(needle.tip_in_ct_mm, needle.tip_in_ct_mm - needle.length_mm * needle.axis_in_ct, 2.0,
           palette::kNeedle);
    }
  }
  if (frame.target_in_ct_mm) {
    if (const auto at = on_screen(*frame.target_in_ct_mm)) {
      sketch.Ring(*at, 8.0 * scale, 1.5 * scale, palette::kTarget);
      sketch.Dot(*at, 2.0 * scale, palette::kTarget);
    }
  }
}

std::optional<double> ImagedTipToTargetMm(const DisplayFrame& frame) {
  if (!frame.needle || !frame.target_in_ct_mm) return std::nullopt;
  const image::NeedleInImage& needle = *frame.needle;
  const Eigen::Vector3d tip =
      needle.shape.num_points >= 2 ? needle.shape.At(0) : needle.tip_in_ct_mm;
  const double distance = (tip - *frame.target_in_ct_mm).norm();
  if (!std::isfinite(distance)) return std::nullopt;
  return distance;
}

}  // namespace acus::window
