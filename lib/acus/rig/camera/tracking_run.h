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
#include "acus/rig/camera/stereo_pair.h"

namespace acus::camera {

/// What was seen of one object.
struct TrackedObject {
  std::string name;
  std::vector<std::optional<ObjectPose>> poses;  ///< One for each image.
  int by_pair = 0;                               ///< Poses that both cameras of a pair agree on.

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

/// The same with a pair: images of the same moments, in the same order. Poses are in the left
/// camera's frame.
/// @throws InputError if the counts differ.
/// @throws NoAnswerError if the cameras disagree about most of what both see.
TrackingRun TrackPairs(const std::vector<std::filesystem::path>& left,
                       const std::vector<std::filesystem::path>& right, const StereoPair& pair,
                       const FacetSet& facets, double rate_hz, const RunContext& context);

/// For the terminal.
std::string TableText(const TrackingRun& run);
/// One <object>.csv each (time_s, x_mm, y_mm, z_mm, qw, qx, qy, qz, status; camera_from_object) and
/// provenance.json, into an existing folder.
void WriteResult(const std::filesystem::path& folder, const TrackingRun& run,
                 const RunContext& context);

/// Images to try all this with: the board from many sides in board/, and in facets/ the objects
/// swaying before the camera, with their true poses in truth/<object>.csv (as WriteResult writes
/// them) and provenance.json. With two cameras the second one's images are in board_right/ and
/// facets_right/. `context.seed` picks the noise and the views of the board.
void WriteSamples(const std::filesystem::path& folder, std::span<const Viewpoint> cameras,
                  const CalibrationBoard& board, const FacetSet& facets, int count,
                  const RunContext& context);

}  // namespace acus::camera
