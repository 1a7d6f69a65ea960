#include "acus/window/frame_maker.h"

#include <algorithm>

#include "acus/scene/simulation/image_renderer.h"

namespace acus::window {
namespace {

Severity SeverityOf(live::Severity severity) {
  return static_cast<Severity>(severity);
}
static_assert(static_cast<int>(Severity::kFault) == static_cast<int>(live::Severity::kFault));

image::ColourImage ColourOf(const camera::Picture& picture) {
  image::ColourImage colour;
  colour.Resize(picture.width_px, picture.height_px);
  for (std::size_t i = 0; i < colour.rgb.size(); ++i) {
    colour.rgb[i] = picture.pixels[picture.channels == 3 ? i : i / 3];
  }
  return colour;
}

}  // namespace

FrameMaker::FrameMaker(const live::LiveSession& session) : session_(session) {}

const DisplayFrame& FrameMaker::Make(const live::LivePicture& picture,
                                     const camera::CameraView* video) {
  const simulation::Scene& scene = session_.scene();
  const live::LiveSnapshot& snapshot = picture.snapshot;
  frame_.session_s = session_.session_s();
  motion_.reset();
  if (scene.breathing && scene.breathing->image) {
    motion_ = scene.breathing->At(snapshot.moment.session_s, snapshot.moment.breath);
  }
  frame_.motion = motion_ ? &*motion_ : nullptr;
  AddTools(picture);
  AddPictures(picture);
  frame_.video.reset();
  if (video != nullptr) AddVideo(*video);
  AddReadouts(picture);
  return frame_;
}

void FrameMaker::AddTools(const live::LivePicture& picture) {
  const simulation::Snapshot moment = picture.snapshot.ForRenderer();
  frame_.needle = simulation::NeedleInPicture(session_.scene(), moment);
  frame_.ct_from_probe.reset();
  if (moment.probe_valid) frame_.ct_from_probe = moment.ct_from_probe;
  frame_.target_in_ct_mm = picture.snapshot.target_in_ct_mm;
}

void FrameMaker::AddPictures(const live::LivePicture& picture) {
  frame_.ultrasound.picture = picture.images.b_mode;
  frame_.ultrasound.probe = frame_.ultrasound.picture.pixels.empty() ? nullptr : picture.probe;
  frame_.ultrasound.frozen = picture.snapshot.frozen;
  frame_.ct_slice = picture.images.ct_slice;
  frame_.effects = picture.effects;
}

void FrameMaker::AddVideo(const camera::CameraView& video) {
  const camera::CameraTracker* tracker = session_.video();
  const camera::CameraParameters& model = tracker->camera().parameters();
  VideoPicture& out = frame_.video.emplace();
  out.picture = ColourOf(video.picture);
  out.camera.focal_px = model.focal_px;
  out.camera.centre_px = model.centre_px;
  out.camera.width_px = model.width_px;
  out.camera.height_px = model.height_px;
  const auto& k = model.radial;
  out.distortion = {k[0], k[1], model.tangential[0], model.tangential[1], k[2]};
  out.pose_valid = video.camera_from_reference.has_value();
  if (!out.pose_valid) return;
  out.camera.camera_from_ct =
      *video.camera_from_reference * session_.scene().ct_from_reference.inverse();
}

void FrameMaker::AddReadouts(const live::LivePicture& picture) {
  const live::LiveSnapshot& snapshot = picture.snapshot;
  frame_.breath_held = snapshot.breath_held;
  frame_.left_handed = snapshot.hands_swapped;
  const live::ForceLimits limits = session_.force_limits();
  frame_.force = {};
  if (limits.needle_n > 0.0) frame_.force.needle_n = snapshot.needle_force_n;
  if (limits.probe_n > 0.0) frame_.force.probe_n = snapshot.probe_force_n;
  frame_.force.limit_n = std::max(limits.needle_n, limits.probe_n);
  const live::CoreStatistics& core = session_.statistics();
  const live::PictureStatistics& pictures = session_.picture_statistics();
  frame_.latency = {.device_to_force_ms = 1e-6 * core.device_to_force.QuantileNs(0.5),
                    .tracker_to_picture_ms = 1e-6 * pictures.tracker_to_picture.QuantileNs(0.5),
                    .pictures_per_s = pictures.per_s(),
                    .missed_steps = static_cast<long>(core.missed_by_computation.load())};
  frame_.status.clear();
  for (const live::StatusLine& line : session_.Status()) {
    frame_.status.push_back({SeverityOf(line.severity), line.text});
  }
  if (snapshot.forces_paused) {
    frame_.status.push_back({Severity::kWarning, "Forces are paused."});
  }
}

}  // namespace acus::window
