// The content of the window of a live session: plain values, so that their producer needs no
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

/// One way to show the patient in the volume view.
struct VolumeLook {
  std::string name;  ///< "bone": in the view's title.
  volume_rendering::PatientInView patient;
};

/// The constant content of a session. Empty members are not shown.
struct PatientOnDisplay {
  /// Overlaid on the video: the CT by its layers, and surfaces.
  volume_rendering::PatientInView in_overlay;
  /// For the teaching view, in the order in which transparent ones are drawn. One named "skin" is
  /// drawn last, and shows the shadows of tools.
  std::vector<volume_rendering::SurfaceInView> in_teaching_view;
  std::vector<VolumeLook> in_volume_view;  ///< The first is shown until another is chosen.
};

/// The state of an item; the colours are green, grey, amber and red.
enum class Severity { kGood, kNote, kWarning, kFault };

/// A sentence for a clinician: "The tracker does not see the needle. Turn it towards the camera."
struct StatusLine {
  Severity severity = Severity::kNote;
  std::string text;
};

/// An image of the video camera, and the camera's pose.
struct VideoImage {
  image::ColourImage image;  ///< As received: with the lens's distortion.
  /// Pinhole part; `camera.width_px` and `height_px` are those of the image.
  volume_rendering::Camera camera;
  /// k1, k2, p1, p2, k3 of Brown's model in the convention of OpenCV; zeros: none.
  std::array<double, 5> distortion{};
  bool pose_valid = false;  ///< False: the patient's marker is not seen; there is no overlay.
};

struct UltrasoundImage {
  image::GrayImage image;  ///< Empty: not shown. Geometry is ImageOf(*probe).
  /// The probe with its name, depth, gain, focus. Null if and only if `image` is empty.
  std::shared_ptr<const acoustics::Probe> probe;
  bool frozen = false;
};

/// 0 or less: unknown, not shown.
struct Latency {
  double device_to_force_ms = 0.0;
  double tracker_to_image_ms = 0.0;
  double images_per_s = 0.0;
  long missed_steps = 0;
  long late_images = 0;        ///< Number of times at which an image was still being rendered.
  long dropped_of_camera = 0;  ///< Images of the camera that the window did not show.
};

/// State of the volume view.
struct VolumeReadout {
  double per_s = 0.0;   ///< Images per second; 0: unknown.
  long dropped = 0;     ///< Frames that a newer one replaced before they were rendered.
  bool whole = false;   ///< Nothing moves: the image has full resolution.
  std::string rays_on;  ///< Name of the graphics card that casts the rays; empty: the processor.
};

/// Magnitude of the force on the hand; nothing: that device has no motor or does not exist.
struct ForceReadout {
  std::optional<double> needle_n;
  std::optional<double> probe_n;
  double limit_n = 0.0;  ///< Limit of the safety guard; full scale of the bar.
  /// Force of the thumb on the plunger; nothing: there is no syringe. Takes the place of the
  /// probe's bar.
  std::optional<double> plunger_n = std::nullopt;
};

/// State of an exercise at one time.
struct ExerciseOnDisplay {
  struct Goal {
    std::string name;   ///< Name of the metric.
    std::string value;  ///< Current value, with its unit.
    std::string limit;  ///< "at most 3 mm".
    Severity severity = Severity::kNote;
  };
  struct Step {
    std::string text;
    training::StepState state = training::StepState::kOpen;
  };
  std::string name;
  std::string caption;  ///< Below the name, such as the position in a curriculum; may be empty.
  std::string target;
  bool target_reached = false;
  std::vector<Goal> goals;
  std::vector<Step> steps;
  std::optional<std::size_t> next_step;
  std::string hint;  ///< Hint for the next step; may be empty.
  std::string how;   ///< HowTo() do the next step; may be empty.
};

/// The content of the window at one time.
struct DisplayFrame {
  double session_s = 0.0;
  UltrasoundImage ultrasound;
  image::GrayImage ct_slice;  ///< In the probe's plane and size; empty: not shown.
  std::vector<simulation::EffectImage> effects;  ///< Effects of the list; empty ones are not shown.
  std::optional<VideoImage> video;               ///< Nothing: not shown.
  /// As images show it, CT space; its polyline if bent. Nothing: not seen by the tracker.
  std::optional<image::NeedleInImage> needle;
  double needle_graduation_mm = 0.0;               ///< Distance of the marks on its shaft; 0: none.
  std::optional<Eigen::Isometry3d> ct_from_probe;  ///< Nothing: not seen by the tracker.
  std::optional<Eigen::Vector3d> target_in_ct_mm;
  /// The one distance that the window shows. In an exercise that of its report, of the needle in
  /// the hand; otherwise of the needle as images show it.
  std::optional<double> tip_to_target_mm;
  /// Motion by breath, for PatientOnDisplay::in_overlay; null: at rest. Must live until Show()
  /// returns.
  const breathing::MotionMap* motion = nullptr;
  /// Deformation of the tissue under the tools, after breath; null: at rest.
  std::shared_ptr<const volume_rendering::PressedTissue> pressed;
  bool breath_held = false;
  bool left_handed = false;  ///< Devices are swapped.
  ForceReadout force;
  Latency latency;
  std::optional<ExerciseOnDisplay> exercise;
  std::string coach;               ///< See CoachLine(); empty: no hint.
  std::vector<StatusLine> status;  ///< The worst is shown first, else in this order.
};

}  // namespace acus::window
