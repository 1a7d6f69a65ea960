// A recording of images, tracked: poses of the objects as streams of a session.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "acus/base/core/run_context.h"
#include "acus/rig/camera/board.h"
#include "acus/rig/camera/facet_pose.h"
#include "acus/rig/camera/marker_detector.h"

namespace acus::camera {

/// What was seen of one object.
struct TrackedObject {
  std::string name;
  std::vector<std::optional<ObjectPose>> poses;  ///< One for each image.

  int Seen() const;
  /// Distance from the mean position, RMS over the images it was seen in, mm: the jitter, if
  /// object and camera stood still.
  double JitterMm() const;
};

struct TrackingRun {
  std::vector<std::string> files;
  double rate_hz = 30.0;
  std::vector<TrackedObject> objects;  ///< In the order of the set.
};

/// @throws InputError if an image cannot be read or is not of the camera's size.
TrackingRun TrackImages(const std::vector<std::filesystem::path>& images, const CameraModel& camera,
                        const FacetSet& facets, double rate_hz, const RunContext& context);

/// For the terminal.
std::string TableText(const TrackingRun& run);
/// One <object>.csv each (time_s, x_mm, y_mm, z_mm, qw, qx, qy, qz, status; camera_from_object) and
/// provenance.json, into an existing folder.
void WriteResult(const std::filesystem::path& folder, const TrackingRun& run,
                 const RunContext& context);

/// Images to try all this with: the board from many sides in board/, and in facets/ the objects
/// swaying before the camera, with their true poses in truth/<object>.csv (as WriteResult writes
/// them) and provenance.json. `context.seed` picks the noise and the views of the board.
void WriteSamples(const std::filesystem::path& folder, const CameraModel& camera,
                  const CalibrationBoard& board, const FacetSet& facets, int count,
                  const RunContext& context);

}  // namespace acus::camera
