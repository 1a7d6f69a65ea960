// A video camera that looks at the mannequin and the tools, for playback.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <memory>
#include <vector>

#include "acus/rig/tracking/simulators/playback.h"

namespace acus::simulators {

/// Where the camera stands and what it sees.
struct MannequinView {
  std::filesystem::path camera;  ///< Format acus-camera/1. Not read if there is a pair:
  std::filesystem::path stereo;  ///< format acus-stereo/1; empty: one camera.
  std::filesystem::path facets;  ///< Format acus-facets/1: the object Reference, and the tools.
  /// In the reference frame, whose z is up on the mannequin, mm.
  Eigen::Vector3d eye_mm = {0.0, -700.0, 550.0};
  Eigen::Vector3d looks_at_mm = {0.0, -80.0, 0.0};
  /// The mannequin is moved about, or the camera is, by this much along its x and y, each in some
  /// 10 s: so that an overlay has something to follow.
  double sway_mm = 15.0;
  double rate_hz = 30.0;
};

/// Draws the facets of the mannequin and of each tool that is seen ("ProbeToReference" is the
/// object Probe), on a plain torso. The same poses and times give the same images.
/// Stream "Video", and of a pair's right camera "VideoRight", of the same moments; their
/// reference_from_pixel is the identity: a camera has no pixels in space.
/// @throws InputError as ReadCamera, ReadStereo and ReadFacets do, if there is no object Reference,
/// or the eye
///     is less than 100 mm from what it looks at.
std::unique_ptr<ImageSource> MannequinImages(const MannequinView& view);
/// The same from where the camera stands by default.
/// @param camera_and_facets  Files or names of presets; empty: null is returned.
/// @param stereo  Likewise; empty: one camera. @throws InputError if it is alone.
std::unique_ptr<ImageSource> MannequinImages(
    const std::vector<std::filesystem::path>& camera_and_facets,
    const std::filesystem::path& stereo);

/// The (left) camera's pose at a time of the motion: what registration or a tracker must find.
Eigen::Isometry3d CameraFromReference(const MannequinView& view, std::int64_t time_ns);

}  // namespace acus::simulators
