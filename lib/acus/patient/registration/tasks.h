// What acus-register does: reads files, calls a model, writes a folder, and says what came out.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "acus/base/core/run_context.h"
#include "acus/patient/registration/landmark_registration.h"
#include "acus/patient/registration/probe_calibration.h"
#include "acus/patient/registration/surface_registration.h"
#include "acus/patient/registration/surface_warp.h"
#include "acus/patient/registration/temporal.h"
#include "acus/patient/registration/touches.h"

namespace acus::registration {

/// Landmarks in two files to a transform.
struct LandmarkTask {
  std::filesystem::path from = {};
  std::filesystem::path to = {};
  std::filesystem::path target = {};  ///< May be empty.
  std::vector<std::string> leave_out = {};
  RegistrationSettings settings = {};
};

/// A tool in a recording: a pose CSV, a session folder (tools "needle" and "probe"), or a sequence
/// of PLUS or Slicer, in which transforms connect the tool with the reference.
struct LogTool {
  std::filesystem::path log = {};
  std::string tool = "Stylus";
  std::string reference = "Reference";
};

struct PivotTask {
  std::vector<std::filesystem::path> poses = {};  ///< See registration::ReadPoses; or recordings.
  LogTool tool = {};                              ///< Names, for recordings.
  bool robust = false;
  double limit_mm = 5.0;  ///< Largest RMS length of the residuals that is accepted.
  bool as_it_is = false;  ///< A tip that seems to be in another unit is not refused.
};

/// Points touched with a pointer, found in its recording, to those of a file.
struct TouchTask {
  LogTool pointer = {};
  std::vector<double> tip_mm = {};   ///< Three numbers; or empty:
  std::filesystem::path pivot = {};  ///< registration.json of a pivot calibration.
  std::filesystem::path known = {};
  std::filesystem::path target = {};
  TouchSettings touches = {};
  RegistrationSettings settings = {};
};

/// Two recordings of one body: a haptic device's handle, and the marker on it.
struct HandEyeTask {
  LogTool device = {};
  LogTool tracker = {};
  double limit_mm = 5.0;  ///< Largest RMS of the residuals that is accepted.
  double delay_s = 0.0;   ///< What the tracker's clock is behind the device's.
};

/// Two recordings of one motion: what their clocks differ by.
struct TemporalTask {
  LogTool tracker = {};
  LogTool other = {};
  std::filesystem::path video = {};  ///< In place of `other`: a sequence with images of a line.
  double delay_s = 0.0;              ///< Added to the other's times before the search.
  TemporalSettings settings = {};
};

/// Poses of facets on an object, to the places of their points in CT.
struct FacetTask {
  std::filesystem::path points = {};  ///< CSV: facet, name, x_mm, y_mm, z_mm in the facet's frame.
  std::filesystem::path poses = {};   ///< CSV: time_s, facet, pose, status.
  std::filesystem::path ct = {};      ///< CSV: facet, name, x_mm, y_mm, z_mm in CT.
  std::filesystem::path target = {};
  RegistrationSettings settings = {};
};

/// Points seen in images of a tracked probe, to the place of the images on its marker.
struct ProbeTask {
  /// CSV: time_s, u_px, v_px and wire, or tip_x_mm, tip_y_mm, tip_z_mm in the reference frame; with
  /// the pose of the probe's marker (x_mm .. qz) where there is no recording.
  std::filesystem::path points = {};
  std::filesystem::path phantom = {};  ///< ReadWirePhantom; empty: points of a stylus.
  /// reference_from_phantom; empty: PhantomToReference of the phantom's file, else the identity.
  std::filesystem::path phantom_pose = {};
  LogTool probe = {.log = {}, .tool = "Probe", .reference = "Reference"};
  std::vector<double> image_px = {};  ///< Columns and rows; may be empty.
  ProbeCalibrationSettings settings = {};
};

/// Jitter of the tools in a recording; accuracy over places of known layout.
struct TrackerTask {
  std::filesystem::path log = {};       ///< Empty: no jitter is requested.
  std::vector<std::string> tools = {};  ///< Empty: all.
  std::string reference = "Tracker";
  double still_mm = 1.0;
  std::filesystem::path measured = {};  ///< Landmarks as measured; with `known`, accuracy.
  std::filesystem::path known = {};
};

/// Points swept over the skin, to the CT's skin.
struct SurfaceTask {
  std::filesystem::path points = {};  ///< Landmarks, or a recording of the pointer.
  LogTool pointer = {};               ///< Names, for a recording.
  std::vector<double> tip_mm = {};
  double spacing_mm = 2.0;
  std::filesystem::path surface = {};
  std::filesystem::path start = {};  ///< A rough transform; may be empty.
  std::filesystem::path target = {};
  SurfaceSettings settings = {};
};

/// CT and labels in the shape of a mannequin.
struct WarpTask {
  std::filesystem::path ct = {};
  std::filesystem::path labels = {};
  std::filesystem::path skin = {};       ///< Of the CT.
  std::filesystem::path mannequin = {};  ///< Its surface, or points on it, in its own frame.
  std::filesystem::path transform = {};  ///< ct_from_reference; empty: none.
  WarpSettings settings = {};
};

/// Each makes `folder` (whole or not at all) and returns a text for the terminal.
/// @throws InputError, NoAnswerError as the models do.
std::string Run(const LandmarkTask& task, const std::filesystem::path& folder, RunContext& context);
std::string Run(const PivotTask& task, const std::filesystem::path& folder, RunContext& context);
std::string Run(const TouchTask& task, const std::filesystem::path& folder, RunContext& context);
std::string Run(const HandEyeTask& task, const std::filesystem::path& folder, RunContext& context);
std::string Run(const TemporalTask& task, const std::filesystem::path& folder, RunContext& context);
std::string Run(const FacetTask& task, const std::filesystem::path& folder, RunContext& context);
std::string Run(const ProbeTask& task, const std::filesystem::path& folder, RunContext& context);
std::string Run(const TrackerTask& task, const std::filesystem::path& folder, RunContext& context);
std::string Run(const SurfaceTask& task, const std::filesystem::path& folder, RunContext& context);
std::string Run(const WarpTask& task, const std::filesystem::path& folder, RunContext& context);

}  // namespace acus::registration
