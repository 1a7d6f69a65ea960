// What the window of a live session shows: plain values, so that whoever fills them in needs no
// window, and a window no simulation.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "acus/data/image/image.h"
#include "acus/imaging/acoustics/probe.h"
#include "acus/imaging/volume_rendering/camera.h"
#include "acus/imaging/volume_rendering/patient_view.h"
#include "acus/physics/breathing/motion_map.h"
#include "acus/run/replay/exercise_watch.h"
#include "acus/scene/simulation/effect_images.h"

namespace acus::window {

/// What the volume view shows of the patient.
struct VolumeLook {
  std::string name;  ///< "bone": in the view's title.
  volume_rendering::PatientInView patient;
};

/// All that stays the same for a session. What is empty is not shown.
struct PatientOnDisplay {
  /// Laid over the video: the CT by its layers, and surfaces.
  volume_rendering::PatientInView in_overlay;
  /// In the teaching view, in the order in which transparent ones are drawn. One named "skin" is
  /// drawn last, and tools throw their shadows on it.
  std::vector<volume_rendering::SurfaceInView> in_teaching_view;
  std::vector<VolumeLook> in_volume_view;  ///< The first is shown until another is chosen.
};

/// How something stands; colours are green, grey, amber and red.
enum class Severity { kGood, kNote, kWarning, kFault };

/// A sentence that a clinician understands: "The tracker does not see the needle. Turn it towards
/// the camera."
struct StatusLine {
  Severity severity = Severity::kNote;
  std::string text;
};

/// An image of the video camera, and where the camera was.
struct VideoImage {
  image::ColourImage image;  ///< As it came: with the lens's distortion.
  /// Pinhole part; `camera.width_px` and `height_px` are those of the image.
  volume_rendering::Camera camera;
  /// k1, k2, p1, p2, k3 of Brown's model as OpenCV has it; zeros: none.
  std::array<double, 5> distortion{};
  bool pose_valid = false;  ///< False: the patient's marker is not seen; nothing is laid over.
};

struct UltrasoundImage {
  image::GrayImage image;  ///< Empty: not shown. Geometry is ImageOf(*probe).
  /// Its name, depth, gain, focus. Null if and only if `image` is empty.
  std::shared_ptr<const acoustics::Probe> probe;
  bool frozen = false;
};

/// 0 or less: not known, not shown.
struct Latency {
  double device_to_force_ms = 0.0;
  double tracker_to_image_ms = 0.0;
  double images_per_s = 0.0;
  long missed_steps = 0;
  long late_images = 0;        ///< Moments at which an image was still in work.
  long dropped_of_camera = 0;  ///< Images of the camera that the window never showed.
};

/// Of the volume view.
struct VolumeReadout {
  double per_s = 0.0;   ///< Images; 0: not known.
  long dropped = 0;     ///< Moments that a newer one replaced before they were rendered.
  bool whole = false;   ///< Nothing moves: the image has all pixels of its place.
  std::string rays_on;  ///< Name of the graphics card that casts the rays; empty: the processor.
};

/// What the hand feels, by magnitude; nothing: that device has no motor or is not there.
struct ForceReadout {
  std::optional<double> needle_n;
  std::optional<double> probe_n;
  double limit_n = 0.0;  ///< Of the safety guard; full scale of the bar.
};

/// An exercise at one moment.
struct ExerciseOnDisplay {
  struct Goal {
    std::string name;   ///< Of the metric.
    std::string value;  ///< So far, with its unit.
    std::string limit;  ///< "at most 3 mm".
    Severity severity = Severity::kNote;
  };
  struct Step {
    std::string text;
    training::StepState state = training::StepState::kOpen;
  };
  std::string name;
  std::string caption;  ///< Below the name, such as the place in a curriculum; may be empty.
  std::string target;
  bool target_reached = false;
  std::vector<Goal> goals;
  std::vector<Step> steps;
  std::optional<std::size_t> next_step;
  std::string hint;  ///< Of the next step; may be empty.
};

/// One moment.
struct DisplayFrame {
  double session_s = 0.0;
  UltrasoundImage ultrasound;
  image::GrayImage ct_slice;  ///< Of the probe's plane and size; empty: not shown.
  std::vector<simulation::EffectImage> effects;  ///< Of the list; those that are empty not shown.
  std::optional<VideoImage> video;               ///< Nothing: not shown.
  /// As images see it, CT space; its polyline if bent. Nothing: not seen by the tracker.
  std::optional<image::NeedleInImage> needle;
  double needle_graduation_mm = 0.0;               ///< Distance of the marks on its shaft; 0: none.
  std::optional<Eigen::Isometry3d> ct_from_probe;  ///< Nothing: not seen by the tracker.
  std::optional<Eigen::Vector3d> target_in_ct_mm;
  /// The one distance that the window shows. In an exercise that of its report, of the needle as it
  /// is held; else of the needle as images see it.
  std::optional<double> tip_to_target_mm;
  /// Breath, of the field in PatientOnDisplay::in_overlay; null: at rest. Must live until Show()
  /// returns.
  const breathing::MotionMap* motion = nullptr;
  /// Tissue under the tools, after breath; null: at rest.
  std::shared_ptr<const volume_rendering::PressedTissue> pressed;
  bool breath_held = false;
  bool left_handed = false;  ///< Devices are swapped.
  ForceReadout force;
  Latency latency;
  std::optional<ExerciseOnDisplay> exercise;
  std::string coach;               ///< See CoachLine(); empty: nothing to say.
  std::vector<StatusLine> status;  ///< The worst is shown first, else in this order.
};

}  // namespace acus::window
