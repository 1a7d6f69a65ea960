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
#include "acus/scene/simulation/effect_images.h"

namespace acus::window {

/// All that stays the same for a session. What is empty is not shown.
struct PatientOnDisplay {
  /// Laid over the video: the CT by its layers, and surfaces.
  volume_rendering::PatientInView in_overlay;
  /// In the teaching view, in the order in which transparent ones are drawn. One named "skin" is
  /// drawn last, and tools throw their shadows on it.
  std::vector<volume_rendering::SurfaceInView> in_teaching_view;
};

/// How something stands; colours are green, grey, amber and red.
enum class Severity { kGood, kNote, kWarning, kFault };

/// A sentence that a clinician understands: "The tracker does not see the needle. Turn it towards
/// the camera."
struct StatusLine {
  Severity severity = Severity::kNote;
  std::string text;
};

/// A picture of the video camera, and where the camera was.
struct VideoPicture {
  image::ColourImage picture;  ///< As it came: with the lens's distortion.
  /// Pinhole part; `camera.width_px` and `height_px` are those of the picture.
  volume_rendering::Camera camera;
  /// k1, k2, p1, p2, k3 of Brown's model as OpenCV has it; zeros: none.
  std::array<double, 5> distortion{};
  bool pose_valid = false;  ///< False: the patient's marker is not seen; nothing is laid over.
};

struct UltrasoundPicture {
  image::GrayImage picture;  ///< Empty: not shown. Geometry is PictureOf(*probe).
  /// Its name, depth, gain, focus. Null if and only if `picture` is empty.
  std::shared_ptr<const acoustics::Probe> probe;
  bool frozen = false;
};

/// 0 or less: not known, not shown.
struct Latency {
  double device_to_force_ms = 0.0;
  double tracker_to_picture_ms = 0.0;
  double pictures_per_s = 0.0;
  long missed_steps = 0;
};

/// What the hand feels, by magnitude; nothing: that device has no motor or is not there.
struct ForceReadout {
  std::optional<double> needle_n;
  std::optional<double> probe_n;
  double limit_n = 0.0;  ///< Of the safety guard; full scale of the bar.
};

/// One moment.
struct DisplayFrame {
  double session_s = 0.0;
  UltrasoundPicture ultrasound;
  image::GrayImage ct_slice;  ///< Of the probe's plane and size; empty: not shown.
  std::vector<simulation::EffectImage> effects;  ///< Of the list; those that are empty not shown.
  std::optional<VideoPicture> video;             ///< Nothing: not shown.
  /// As pictures see it, CT space; its polyline if bent. Nothing: not seen by the tracker.
  std::optional<image::NeedleInImage> needle;
  std::optional<Eigen::Isometry3d> ct_from_probe;  ///< Nothing: not seen by the tracker.
  std::optional<Eigen::Vector3d> target_in_ct_mm;
  /// Breath, of the field in PatientOnDisplay::in_overlay; null: at rest. Must live until Show()
  /// returns.
  const breathing::MotionMap* motion = nullptr;
  bool breath_held = false;
  bool left_handed = false;  ///< Devices are swapped.
  ForceReadout force;
  Latency latency;
  std::vector<StatusLine> status;  ///< The worst is shown first, else in this order.
};

}  // namespace acus::window
