#include "acus/window/frame_maker.h"

#include <algorithm>

#include "acus/base/translation/translation.h"
#include "acus/run/training/session_metrics.h"
#include "acus/scene/simulation/probe_image_renderer.h"
#include "acus/window/coach.h"
#include "acus/window/exercise_panel.h"
#include "acus/window/marks.h"

namespace acus::window {
namespace {

Severity SeverityOf(live::Severity severity) {
  return static_cast<Severity>(severity);
}
static_assert(static_cast<int>(Severity::kFault) == static_cast<int>(live::Severity::kFault));

void ColourOf(const camera::Image& image, image::ColourImage& out) {
  out.Resize(image.width_px, image.height_px);
  if (image.channels == 3) {
    std::copy_n(image.pixels.begin(), out.rgb.size(), out.rgb.begin());
    return;
  }
  for (std::size_t i = 0; i < out.rgb.size(); ++i) out.rgb[i] = image.pixels[i / 3];
}

bool WantsPlane(const training::Exercise& exercise) {
  const auto is_of_plane = [](const training::Goal& goal) {
    return goal.metric.ends_with("in the image plane");
  };
  return std::ranges::any_of(exercise.goals, is_of_plane) ||
         std::ranges::find(exercise.checklist.steps, training::StepCondition::kNeedleInPlane,
                           &training::ChecklistStep::when) != exercise.checklist.steps.end();
}

}  // namespace

FrameMaker::FrameMaker(const live::LiveSession& session, int trial, std::string caption)
    : session_(session), trial_(trial), caption_(std::move(caption)), tissue_(session.scene()) {
  const simulation::Scene& scene = session.scene();
  if (scene.labels != nullptr) {
    label_at_ = training::LabelsOf({*scene.labels, Eigen::Isometry3d::Identity()});
  }
}

const DisplayFrame& FrameMaker::Make(const live::LiveImage& image, const camera::CameraView* video,
                                     bool steers_probe) {
  const simulation::Scene& scene = session_.scene();
  const live::LiveSnapshot& snapshot = image.snapshot;
  frame_.session_s = session_.session_s();
  motion_.reset();
  if (scene.breathing && scene.breathing->image) {
    motion_ = scene.breathing->At(snapshot.moment.session_s, snapshot.moment.breath);
  }
  frame_.motion = motion_ ? &*motion_ : nullptr;
  tissue_.Ask(snapshot);
  frame_.pressed = tissue_.Newest();
  AddTools(image);
  AddImages(image);
  AddVideo(video);
  AddReadouts(image);
  AddExercise(image, steers_probe);
  return frame_;
}

void FrameMaker::AddTools(const live::LiveImage& image) {
  const simulation::Snapshot moment = image.snapshot.ForRenderer();
  frame_.needle = simulation::ImagedNeedle(session_.scene(), moment);
  const auto& preset = session_.scene().needle;
  frame_.needle_graduation_mm = preset ? preset->graduation_mm : 0.0;
  frame_.ct_from_probe.reset();
  if (moment.probe_valid) frame_.ct_from_probe = moment.ct_from_probe;
  frame_.target_in_ct_mm = image.snapshot.target_in_ct_mm;
  // The report uses the exercise's target: the window shows only that.
  if (const live::LiveExercise* exercise = session_.exercise()) {
    if (exercise->target_in_ct_mm()) frame_.target_in_ct_mm = exercise->target_in_ct_mm();
  }
  frame_.tip_to_target_mm = ImagedTipToTargetMm(frame_);
}

void FrameMaker::AddImages(const live::LiveImage& image) {
  frame_.ultrasound.image = image.images.b_mode;
  frame_.ultrasound.probe = frame_.ultrasound.image.pixels.empty() ? nullptr : image.probe;
  frame_.ultrasound.frozen = image.snapshot.frozen;
  frame_.ct_slice = image.images.ct_slice;
  frame_.effects = image.effects;
}

void FrameMaker::AddVideo(const camera::CameraView* view) {
  if (view == nullptr) {
    frame_.video.reset();
    return;
  }
  const camera::CameraView& video = *view;
  const camera::CameraTracker* tracker = session_.video();
  const camera::CameraParameters& model = tracker->camera().parameters();
  if (!frame_.video) frame_.video.emplace();
  VideoImage& out = *frame_.video;
  if (video.number != camera_shown_) {
    if (camera_shown_ != 0) camera_dropped_ += video.number - camera_shown_ - 1;
    camera_shown_ = video.number;
    ColourOf(video.image, out.image);
  }
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

void FrameMaker::AddReadouts(const live::LiveImage& image) {
  const live::LiveSnapshot& snapshot = image.snapshot;
  frame_.breath_held = snapshot.breath_held;
  frame_.left_handed = snapshot.hands_swapped;
  const live::ForceLimits limits = session_.force_limits();
  frame_.force = {};
  if (limits.needle_n > 0.0) frame_.force.needle_n = snapshot.needle_force_n;
  if (limits.probe_n > 0.0) frame_.force.probe_n = snapshot.probe_force_n;
  if (session_.scene().plan.Needs(effects::ports::kPlungerForce)) {
    frame_.force.plunger_n = snapshot.plunger_n;
  }
  frame_.force.limit_n = std::max(limits.needle_n, limits.probe_n);
  const live::CoreStatistics& core = session_.statistics();
  const live::ImageStatistics& images = session_.image_statistics();
  frame_.latency = {.device_to_force_ms = 1e-6 * core.device_to_force.QuantileNs(0.5),
                    .tracker_to_image_ms = 1e-6 * images.tracker_to_image.QuantileNs(0.5),
                    .images_per_s = session_.recent_images_per_s(),
                    .missed_steps = static_cast<long>(core.missed_by_computation.load()),
                    .late_images = static_cast<long>(images.late.load()),
                    .dropped_of_camera = static_cast<long>(camera_dropped_)};
  frame_.status.clear();
  for (const live::StatusLine& line : session_.Status()) {
    frame_.status.push_back({SeverityOf(line.severity), line.text});
  }
  if (!notice_.empty()) frame_.status.push_back({Severity::kNote, notice_});
  if (snapshot.forces_paused) {
    frame_.status.push_back({Severity::kWarning, translation::Translated("Forces are paused.")});
  }
}

void FrameMaker::AddExercise(const live::LiveImage& image, bool steers_probe) {
  frame_.exercise.reset();
  frame_.coach.clear();
  if (!label_at_) return;
  const simulation::Scene& scene = session_.scene();
  const live::LiveSnapshot& snapshot = image.snapshot;
  const live::LiveExercise* live = session_.exercise();
  static const training::Exercise kNone;
  const training::Exercise& exercise = live == nullptr ? kNone : live->exercise();

  CoachView view;
  view.switch_is_open = session_.switch_is_open();
  view.has_needle = session_.has_needle();
  view.has_probe = session_.has_probe() && scene.probe.has_value();
  view.wants_plane = WantsPlane(exercise);
  view.field = replay::FieldOf(scene, snapshot.depth_mm);
  view.half_thickness_mm = exercise.image_plane.half_thickness_mm;
  view.ct_from_probe = snapshot.moment.ct_from_probe.linear();
  const auto tool = [&](bool is_needle, const Eigen::Isometry3d& ct_from_tool) {
    const live::HeldTool held = session_.HeldBy(is_needle);
    const Eigen::Isometry3d ct_from_device = scene.ct_from_reference * held.reference_from_device;
    return SteeredTool{.is_virtual = held.hand != nullptr,
                       .is_selected = is_needle != steers_probe,
                       .device_from_ct = ct_from_device.linear().transpose(),
                       .along_in_ct = ct_from_tool.linear().col(2)};
  };
  session::PoseSample needle{.valid = snapshot.moment.ct_from_needle.has_value()};
  if (needle.valid) {
    needle.reference_from_tool = transforms::Pose(*snapshot.moment.ct_from_needle);
    view.needle = tool(true, *snapshot.moment.ct_from_needle);
  }
  const session::PoseSample probe{
      .reference_from_tool = transforms::Pose(snapshot.moment.ct_from_probe),
      .valid = snapshot.moment.probe_valid};
  view.probe = tool(false, snapshot.moment.ct_from_probe);
  training::SituationOptions options;
  options.plane = exercise.image_plane;
  options.target_radius_mm = exercise.target_radius_mm;
  if (live != nullptr) options.target_mm = live->target_in_ct_mm();
  view.now =
      SituationOf(needle, session_.has_probe() ? &probe : nullptr, view.field, label_at_, options);
  if (view.now.probe_seen && !view.now.probe_on_skin) {
    view.gap_to_skin_mm = training::GapToSkinMm(probe.reference_from_tool, label_at_);
  }
  if (view.now.probe_seen) {
    view.probe_depth_mm = training::DepthBelowSkinMm(probe.reference_from_tool, label_at_);
  }
  view.target_radius_mm = exercise.target_radius_mm;
  view.breath_held = snapshot.breath_held;
  if (live != nullptr && live->target_in_ct_mm()) {
    frame_.tip_to_target_mm = view.now.tip_to_target_mm;
    if (view.now.tip_mm) view.tip_to_target_in_ct_mm = *options.target_mm - *view.now.tip_mm;
  }
  if (live != nullptr) {
    frame_.exercise = ExerciseToShow(exercise, live->progress(), view.now.tip_to_target_mm, trial_);
    frame_.exercise->caption = caption_;
    const auto& next = frame_.exercise->next_step;
    if (next) view.next = exercise.checklist.steps[*next].when;
    if (exercise.hints.coach) frame_.exercise->how = HowTo(view);
  }
  // After the last step there is nothing to do.
  const bool has_ended = frame_.exercise && !frame_.exercise->steps.empty() && !view.next;
  if (exercise.hints.coach && !has_ended) frame_.coach = CoachLine(view);
}

}  // namespace acus::window
