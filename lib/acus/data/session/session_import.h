// Sessions from other programs' recordings: PLUS sequence files and 3D Slicer scenes.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "acus/base/core/run_context.h"
#include "acus/data/session/session.h"

namespace acus::session {

/// How the frames of a recording become needle and probe. Frames are named as PLUS names them.
struct ImportOptions {
  /// The first one that the recording connects with the reference frame is taken.
  std::vector<std::string> needle_frames = {"NeedleTip", "StylusTip", "Needle", "Stylus"};
  std::vector<std::string> probe_frames = {"TransducerOrigin", "TransducerOriginPixel", "Probe",
                                           "Image"};
  std::string reference_frame = "Reference";

  /// Fixed transforms that are not in the recording, e.g. "ImageToProbe" (pixels to mm, as PLUS's
  /// calibration gives it), "StylusTipToStylus". One of the same name in the recording wins.
  std::map<std::string, Eigen::Matrix4d> calibrations = {};

  /// If the probe's frame is an image (pixels): the pixel (column, row) at the middle of the
  /// transducer face, which becomes the origin of the probe's pose. Without it the image's corner
  /// stays the origin.
  std::optional<Eigen::Vector2d> face_px = {};
};

struct ImportedSession {
  Session session;
  std::string needle_frame;  ///< Empty if there is none.
  std::string probe_frame;   ///< Empty if there is none.
  /// mm per pixel along the image's columns and rows, if the probe's frame is an image.
  std::optional<Eigen::Vector2d> probe_mm_per_px;
};

/// Reads a PLUS sequence file (.igs.mha, .igs.mhd, .igs.nrrd). Poses are found through the
/// transforms of each frame: ProbeToTracker and ReferenceToTracker give reference_from_probe. A
/// frame in which any transform of the chain has another status than OK is an invalid sample.
/// @throws InputError if the file is not readable, a frame has no time stamp, time goes back, or
///     neither needle nor probe is connected with the reference (naming the transforms there are).
ImportedSession ReadPlusSession(const std::filesystem::path& path, const ImportOptions& options,
                                const RunContext& context);

/// Reads a 3D Slicer scene with recorded transform sequences: an .mrml file, the folder that holds
/// one, or an .mrb bundle of it. Poses are those that Slicer shows (RAS), in mm.
/// @throws InputError as above.
ImportedSession ReadSlicerSession(const std::filesystem::path& path, const ImportOptions& options,
                                  const RunContext& context);

/// Reads whatever `path` is: a session folder, a PLUS sequence file, or a Slicer scene.
/// @throws InputError naming what was expected, if it is none of these.
ImportedSession ReadAnySession(const std::filesystem::path& path, const ImportOptions& options,
                               const RunContext& context);

}  // namespace acus::session
