#include "acus/window/window.h"

#include <algorithm>
#include <cmath>

#include "acus/base/core/error.h"
#include "acus/base/translation/translation.h"
#include "acus/imaging/graphics/shader_rays.h"
#include "acus/window/exercise_panel.h"
#include "acus/window/image_layer.h"
#include "acus/window/marks.h"
#include "acus/window/screen.h"
#include "acus/window/sketch_layer.h"
#include "acus/window/status_bar.h"
#include "acus/window/steering.h"
#include "acus/window/teaching_view.h"
#include "acus/window/video_view.h"
#include "acus/window/volume_view.h"

namespace acus::window {
namespace {

using translation::Translated;

void Check(const WindowSettings& settings) {
  ACUS_REQUIRE(settings.width_px >= 320 && settings.height_px >= 240 && settings.width_px <= 8192 &&
                   settings.height_px <= 8192,
               "display: a window of ", settings.width_px, " x ", settings.height_px,
               " pixels; allowed is 320 x 240 to 8192 x 8192");
  ACUS_REQUIRE(settings.max_triangles >= 1000 && settings.max_triangles <= 5'000'000,
               "display: surfaces of ", settings.max_triangles,
               " triangles; allowed is 1000 to 5000000");
  ACUS_REQUIRE(settings.overlay_scale >= 0.05 && settings.overlay_scale <= 2.0,
               "display: overlay_scale is ", settings.overlay_scale, "; allowed is 0.05 to 2");
  ACUS_REQUIRE(settings.edge_falloff_share >= 0.0 && settings.edge_falloff_share <= 1.0,
               "display: edge_falloff_share is ", settings.edge_falloff_share,
               "; allowed is 0 to 1");
  ACUS_REQUIRE(settings.volume_moving_scale >= 0.05 && settings.volume_moving_scale <= 1.0,
               "display: volume_moving_scale is ", settings.volume_moving_scale,
               "; allowed is 0.05 to 1");
  ACUS_REQUIRE(settings.teaching_view_each >= 1, "display: teaching_view_each is ",
               settings.teaching_view_each, "; allowed is 1 and more");
}

bool IsFinite(const image::NeedleInImage& needle) {
  bool finite = needle.tip_in_ct_mm.allFinite() && needle.axis_in_ct.allFinite() &&
                std::isfinite(needle.length_mm) && std::isfinite(needle.radius_mm);
  for (int i = 0; i < needle.shape.num_points; ++i) {
    finite = finite && needle.shape.At(i).allFinite();
  }
  return finite && (needle.length_mm > 0.0 || needle.shape.num_points >= 2);
}

bool IsWhole(const image::GrayImage& image) {
  return image.width > 0 && image.height > 0 &&
         image.pixels.size() ==
             static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
}

bool IsWhole(const image::ColourImage& image) {
  return image.width > 0 && image.height > 0 &&
         image.rgb.size() ==
             3 * static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
}

/// Removes values that cannot be drawn: a fault of a tracker must not stop the display.
void MakeDrawable(DisplayFrame& out) {
  if (out.needle && !IsFinite(*out.needle)) out.needle.reset();
  if (out.ct_from_probe && !out.ct_from_probe->matrix().allFinite()) out.ct_from_probe.reset();
  if (out.target_in_ct_mm && !out.target_in_ct_mm->allFinite()) out.target_in_ct_mm.reset();
  const auto& probe = out.ultrasound.probe;
  if (!IsWhole(out.ultrasound.image) || !probe ||
      out.ultrasound.image.width != acoustics::ImageOf(*probe).width_px ||
      out.ultrasound.image.height != acoustics::ImageOf(*probe).height_px) {
    out.ultrasound.image = {};
  }
  if (!IsWhole(out.ct_slice)) out.ct_slice = {};
  std::erase_if(out.effects, [](const simulation::EffectImage& effect) {
    return !IsWhole(effect.pixels.gray) && !IsWhole(effect.pixels.colour);
  });
  if (out.video) {
    const image::ColourImage& image = out.video->image;
    const volume_rendering::Camera& camera = out.video->camera;
    if (!IsWhole(image)) {
      out.video.reset();
    } else if (!camera.camera_from_ct.matrix().allFinite() || !camera.centre_px.allFinite() ||
               !(camera.focal_px.array() > 0.0).all() || camera.width_px != image.width ||
               camera.height_px != image.height) {
      out.video->pose_valid = false;
    }
  }
}

/// The device that casts the rays. Drivers are loaded here: during a session, that would delay its
/// steps.
VolumeRays FoundRays(VolumeRays wanted, bool has_volume) {
  if (!has_volume || wanted == VolumeRays::kProcessor) return VolumeRays::kProcessor;
  try {
    graphics::MakeShaderRays(DriverFor(wanted));
    return wanted;
  } catch (const InputError&) {
    if (wanted == VolumeRays::kGraphics) throw;
    return VolumeRays::kProcessor;
  }
}

/// The centre of the eye's rotation is that of this box.
Eigen::AlignedBox3d BoxOf(const Eigen::AlignedBox3d& surfaces,
                          const std::vector<VolumeLook>& looks) {
  if (!surfaces.isEmpty() || looks.empty() || !looks.front().patient.ct) return surfaces;
  const volume::Geometry& grid = looks.front().patient.ct->geometry;
  const Eigen::Affine3d ct_from_index = grid.ct_from_index();
  Eigen::AlignedBox3d box;
  for (int n = 0; n < 8; ++n) {
    const Eigen::Array3i corner(n & 1, (n >> 1) & 1, n >> 2);
    box.extend(ct_from_index * (corner * (grid.size - 1)).cast<double>().matrix());
  }
  return box;
}

bool IsListed(const WindowSettings& settings, ViewKind kind) {
  return settings.views.empty() ? kind != ViewKind::kVolume
                                : std::ranges::find(settings.views, kind) != settings.views.end();
}

}  // namespace

struct Window::Content {
  WindowSettings settings;
  std::vector<VolumeLook> looks;
  std::unique_ptr<Screen> owned_screen;
  Screen& screen;
  FontAtlas atlas;
  Sketch sketch{atlas};
  ImageLayer images;
  TeachingView teaching;
  Orbit orbit;
  VideoView video;
  VolumeView volume;
  SketchLayer marks;
  Steering steering;
  Layout layout;
  std::vector<ViewKind> shown;
  DisplayFrame drawn;  ///< The displayed frame: its buffers are used again.
  long frames = 0;
  bool eye_is_placed = false;

  Content(const PatientOnDisplay& patient, const WindowSettings& s, std::unique_ptr<Screen> opened)
      : settings(s),
        looks(patient.in_volume_view),
        owned_screen(opened ? std::move(opened)
                            : std::make_unique<Screen>(s.title, s.width_px, s.height_px)),
        screen(*owned_screen),
        teaching(patient.in_teaching_view, s.max_triangles),
        orbit(BoxOf(teaching.box_in_ct_mm(), looks)),
        video(patient.in_overlay, teaching.skin(),
              {.scale = s.overlay_scale,
               .falloff_share = s.edge_falloff_share,
               .in_background = s.overlay_in_background}),
        volume(looks, {.moving_scale = s.volume_moving_scale,
                       .in_background = s.volume_in_background,
                       .rays = FoundRays(s.volume_rays, !looks.empty())}),
        marks(atlas),
        steering(IsListed(s, ViewKind::kVolume)) {
    screen.Add(images.renderer(), 0);
    screen.Add(video.layer().renderer(0), 1);
    screen.Add(teaching.layer().renderer(0), 1);
    screen.Add(teaching.layer().renderer(1), 1);
    screen.Add(marks.renderer(), 2);
    // Its own background, over that of the images.
    teaching.layer().PaintBackground();
  }

  Rectangle WindowPlace() const {
    return {.left = 0, .top = 0, .width = screen.width_px(), .height = screen.height_px()};
  }

  void HandleEvents() {
    const std::vector<InputEvent> events = screen.TakeEvents();
    steering.Handle(events, layout, shown);
    if (steering.HoldsKeys() && !screen.HasHeldKeys()) steering.ReleaseKeys();
    const Layout::View* view = layout.Find(ViewKind::kTeaching);
    if (view == nullptr) view = layout.Find(ViewKind::kVolume);
    MoveEye(steering.TakeEyeMotion(), view == nullptr ? 1 : view->place.height);
  }

  /// Once: to the side of the needle, or of the probe, unless the user has chosen another.
  void PlaceEye(const DisplayFrame& frame) {
    if (eye_is_placed) return;
    if (frame.needle) {
      const image::NeedleInImage& needle = *frame.needle;
      orbit.LookAtSideOf(needle.tip_in_ct_mm - needle.length_mm * needle.axis_in_ct);
    } else if (frame.ct_from_probe) {
      orbit.LookAtSideOf(frame.ct_from_probe->translation());
    } else {
      return;
    }
    eye_is_placed = true;
  }

  void MoveEye(const EyeMotion& motion, int height_px) {
    eye_is_placed = eye_is_placed || motion.preset != 0;
    if (motion.preset != 0) orbit.SetPreset(motion.preset);
    if (motion.turn_right_px != 0.0 || motion.turn_down_px != 0.0) {
      orbit.Turn(motion.turn_right_px, motion.turn_down_px);
    }
    if (motion.shift_right_px != 0.0 || motion.shift_down_px != 0.0) {
      orbit.Shift(motion.shift_right_px, motion.shift_down_px, height_px);
    }
    if (motion.zoom != 1.0) orbit.Zoom(motion.zoom);
  }

  void FindShown(const DisplayFrame& frame) {
    shown.clear();
    if (frame.video) shown.push_back(ViewKind::kVideo);
    if (!frame.ultrasound.image.pixels.empty()) shown.push_back(ViewKind::kUltrasound);
    if (!teaching.empty()) shown.push_back(ViewKind::kTeaching);
    if (!volume.empty() && steering.choice().volume.shown) shown.push_back(ViewKind::kVolume);
    if (!frame.ct_slice.pixels.empty()) shown.push_back(ViewKind::kCtSlice);
    for (std::size_t n = 0; n < std::min(frame.effects.size(), kEffectViews.size()); ++n) {
      shown.push_back(kEffectViews[n]);
    }
    std::erase_if(shown, [&](ViewKind kind) {
      return kind != ViewKind::kVolume && !IsListed(settings, kind);
    });
    std::optional<ViewKind> alone = steering.choice().alone;
    // Both eyes see the whole window: it then shows only the teaching view.
    if (FillsWindow(StereoNow())) alone = ViewKind::kTeaching;
    layout =
        LayOut(screen.width_px(), screen.height_px(), shown, alone, frame.exercise.has_value());
  }

  Rectangle PlaceOf(ViewKind kind) const {
    const Layout::View* view = layout.Find(kind);
    return view == nullptr ? Rectangle{} : view->place;
  }

  void DrawVideo(const DisplayFrame& frame, const TextSizes& sizes) {
    const Rectangle place = PlaceOf(ViewKind::kVideo);
    if (place.empty()) {
      images.Hide(ViewKind::kVideo);
      video.Update(frame, {}, WindowPlace(), 0.0);
      return;
    }
    const VideoImage& seen = *frame.video;
    const Rectangle fit =
        Fit(ImageRoom(ViewKind::kVideo, place, sizes), seen.image.width, seen.image.height);
    images.Show(seen.image, seen.camera, seen.distortion, fit);
    video.Update(frame, fit, WindowPlace(), steering.choice().overlay_share);
    const int percent = static_cast<int>(std::lround(100.0 * steering.choice().overlay_share));
    DrawTitle(Translated(TitleOf(ViewKind::kVideo)),
              seen.pose_valid ? "CT " + std::to_string(percent) + " %"
                              : Translated("patient's marker not seen"),
              place, sizes, sketch);
    DrawVideoMarks(frame, fit, sizes, sketch);
  }

  void DrawUltrasound(const DisplayFrame& frame, const TextSizes& sizes) {
    const Rectangle place = PlaceOf(ViewKind::kUltrasound);
    if (place.empty()) return images.Hide(ViewKind::kUltrasound);
    const PlaneOnScreen plane = PlaneIn(frame, ImageRoom(ViewKind::kUltrasound, place, sizes));
    images.Show(ViewKind::kUltrasound, frame.ultrasound.image, plane.place);
    DrawUltrasoundMarks(frame, place, plane, steering.choice(), sketch, sizes);
  }

  void DrawCtSlice(const DisplayFrame& frame, const TextSizes& sizes) {
    const Rectangle place = PlaceOf(ViewKind::kCtSlice);
    if (place.empty()) return images.Hide(ViewKind::kCtSlice);
    Rectangle room = ImageRoom(ViewKind::kCtSlice, place, sizes);
    const bool has_plane = frame.ultrasound.probe != nullptr;
    PlaneOnScreen plane = has_plane ? PlaneIn(frame, room) : PlaneOnScreen{};
    if (!has_plane) plane.place = Fit(room, frame.ct_slice.width, frame.ct_slice.height);
    images.Show(ViewKind::kCtSlice, frame.ct_slice, plane.place);
    DrawTitle(Translated(TitleOf(ViewKind::kCtSlice)), "", place, sizes, sketch);
    if (has_plane && frame.ct_from_probe) DrawSliceMarks(frame, plane, sizes, sketch);
  }

  void DrawEffect(ViewKind kind, const simulation::EffectImage& effect, const TextSizes& sizes) {
    const Rectangle place = PlaceOf(kind);
    if (place.empty()) return images.Hide(kind);
    const auto show = [&](const auto& image) {
      images.Show(kind, image, Fit(ImageRoom(kind, place, sizes), image.width, image.height));
    };
    if (IsWhole(effect.pixels.colour)) {
      show(effect.pixels.colour);
    } else {
      show(effect.pixels.gray);
    }
    DrawTitle(Translated(std::string(effect.title)), "", place, sizes, sketch);
  }

  void DrawTeaching(const DisplayFrame& frame, const TextSizes& sizes) {
    const Rectangle place = PlaceOf(ViewKind::kTeaching);
    if (place.empty()) return teaching.Hide();
    if (frames % settings.teaching_view_each == 0) teaching.Update(frame);
    teaching.SetPlace(ImageRoom(ViewKind::kTeaching, place, sizes), WindowPlace(), orbit,
                      StereoNow());
    DrawTitle(Translated(TitleOf(ViewKind::kTeaching)), StereoText(), place, sizes, sketch);
  }

  /// The chosen mode, if the driver has it.
  Stereo StereoNow() const {
    const Stereo wanted = steering.choice().stereo;
    return wanted == Stereo::kShutter && !screen.has_shutter() ? Stereo::kSideBySide : wanted;
  }

  std::string StereoText() const {
    switch (steering.choice().stereo) {
      case Stereo::kOff:
        return "";
      case Stereo::kSideBySide:
        return Translated("side by side");
      case Stereo::kRedCyan:
        return Translated("red-cyan glasses");
      case Stereo::kShutter:
        break;
    }
    return screen.has_shutter()
               ? Translated("shutter glasses")
               : Translated("side by side: the driver has no stereo for shutter glasses");
  }

  void DrawVolume(const DisplayFrame& frame, const TextSizes& sizes) {
    const Rectangle place = PlaceOf(ViewKind::kVolume);
    const Rectangle room = ImageRoom(ViewKind::kVolume, place, sizes);
    const VolumeChoice& choice = steering.choice().volume;
    volume.Update(frame, room, orbit, choice);
    if (place.empty()) return images.Hide(ViewKind::kVolume);
    const image::ColourImage& image = volume.image();
    if (IsWhole(image)) {
      images.Show(ViewKind::kVolume, image, Fit(room, image.width, image.height));
    } else {
      images.Hide(ViewKind::kVolume);
    }
    DrawTitle(Translated(TitleOf(ViewKind::kVolume)), volume.TitleDetail(choice), place, sizes,
              sketch);
  }

  static PlaneOnScreen PlaneIn(const DisplayFrame& frame, const Rectangle& room) {
    PlaneOnScreen plane;
    plane.geometry = acoustics::ImageOf(*frame.ultrasound.probe);
    plane.place = Fit(room, plane.geometry.width_px * plane.geometry.lateral_mm_per_px,
                      plane.geometry.height_px * plane.geometry.axial_mm_per_px);
    if (frame.ct_from_probe) plane.ct_from_probe = *frame.ct_from_probe;
    return plane;
  }

  void Show(const DisplayFrame& frame) {
    FindShown(frame);
    PlaceEye(frame);
    screen.SetStereo(teaching.empty() ? Stereo::kOff : StereoNow());
    const TextSizes sizes = SizesFor(screen.height_px());
    images.SetWindowSize(screen.width_px(), screen.height_px());
    sketch.Clear();
    DrawVideo(frame, sizes);
    DrawUltrasound(frame, sizes);
    DrawCtSlice(frame, sizes);
    for (std::size_t n = 0; n < kEffectViews.size(); ++n) {
      if (n < frame.effects.size()) {
        DrawEffect(kEffectViews[n], frame.effects[n], sizes);
      } else {
        images.Hide(kEffectViews[n]);
      }
    }
    DrawTeaching(frame, sizes);
    DrawVolume(frame, sizes);
    if (frame.exercise) DrawExercise(*frame.exercise, layout.exercise, sizes, sketch);
    DrawStatusBar(frame, steering.choice(), volume.readout(), layout.status, sizes, sketch);
    if (steering.choice().help) DrawHelp(WindowPlace(), sizes, sketch);
    marks.Draw(sketch, screen.height_px());
    screen.Render();
    ++frames;
  }
};

Window::Window(const PatientOnDisplay& patient, const WindowSettings& settings,
               std::unique_ptr<Screen> screen) {
  Check(settings);
  content_ = std::make_unique<Content>(patient, settings, std::move(screen));
}

Window::~Window() = default;
Window::Window(Window&&) noexcept = default;
Window& Window::operator=(Window&&) noexcept = default;

void Window::Show(const DisplayFrame& frame) {
  if (closed()) return;
  content_->HandleEvents();
  if (closed()) return;
  content_->drawn = frame;
  MakeDrawable(content_->drawn);
  content_->Show(content_->drawn);
  // Must not be accessed after the return.
  content_->drawn.motion = nullptr;
}

void Window::ShowText(const std::string& text) {
  if (closed()) return;
  content_->HandleEvents();
  if (closed()) return;
  DisplayFrame& drawn = content_->drawn;
  drawn.status.clear();
  drawn.latency = {};
  drawn.force = {};
  drawn.coach = text;
  content_->Show(drawn);
}

void Window::Restart() {
  if (closed()) return;
  content_->steering = Steering(IsListed(content_->settings, ViewKind::kVolume));
  content_->eye_is_placed = false;
}

void Window::HandleEvents() {
  if (!closed()) content_->HandleEvents();
}

std::vector<Command> Window::TakeCommands() {
  return content_->steering.TakeCommands();
}
HandInput Window::TakeHandInput() {
  return content_->steering.TakeHandInput();
}
bool Window::closed() const {
  return content_->steering.closed();
}
Layout Window::layout() const {
  return content_->layout;
}
image::ColourImage Window::Screenshot(EyeSide eye) {
  return content_->screen.Screenshot(eye);
}
std::optional<VolumeReadout> Window::volume() const {
  return content_->volume.readout();
}
long Window::num_overlays() const {
  return content_->video.num_overlays();
}

}  // namespace acus::window
