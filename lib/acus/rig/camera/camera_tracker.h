// Tools and the mannequin tracked by an ordinary camera: a source of poses.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "acus/rig/camera/facet_pose.h"
#include "acus/rig/camera/frame_source.h"
#include "acus/rig/camera/marker_detector.h"
#include "acus/rig/camera/pair_pose.h"
#include "acus/rig/camera/second_camera.h"
#include "acus/rig/tracking/pose_source.h"

namespace acus::camera {

/// A tool that is required, and which object of the facet set it is.
struct CameraTool {
  std::string tool;    ///< Our name: "probe".
  std::string object;  ///< Of the facet set: "Probe".
  /// Calibration: reference_from_tool = reference_from_object * object_from_tool.
  Eigen::Isometry3d object_from_tool = Eigen::Isometry3d::Identity();
};

struct CameraTrackerOptions {
  std::string name = "camera";  ///< For messages to the user.
  std::string place;            ///< See OpenFrameSource.
  FrameSourceOptions source;
  /// Beside the first one, whose video is shown: objects that both see are tracked by the pair.
  std::optional<SecondCameraOptions> second;
  /// The object whose frame poses are given in; empty: the camera's own frame.
  std::string reference = "Reference";
  std::vector<CameraTool> tools;
  DetectorSettings detector;
  PoseSettings pose;
  /// A reference that is hidden keeps its last pose so long: hands come between. Only for a camera
  /// and a mannequin that both stand still. 0: then no tool has a pose either.
  int hold_reference_ms = 0;
  /// All tools are published as not seen if no image came for so long.
  int lost_after_ms = 200;
  std::size_t journal_capacity = 0;  ///< Of the board.
};

/// An image with what was found in it, for an overlay that fits it exactly.
struct CameraView {
  Image image;               ///< As it came; its time is when it arrived.
  std::uint64_t number = 0;  ///< Images so far, this one included.
  std::vector<ObjectPose> objects;
  int by_pair = 0;  ///< How many of these both cameras agree on.
  std::optional<Eigen::Isometry3d> camera_from_reference;
};

/// One thread takes images, looks for markers and publishes: each tool gets one reading with each
/// image, valid or not. A camera that is unplugged is looked for again; nothing that it sends
/// ends the thread. Ambiguous poses are published as not valid. A pair whose cameras disagree for
/// some time is refused: then no tool is seen, and the status says why.
class CameraTracker final : public tracking::PoseSource {
 public:
  /// @throws InputError if the set has no such object, a tool is there twice, the place is not
  ///     understood, or the pair's left camera is another one (RequireSameCamera).
  CameraTracker(CameraModel camera, FacetSet facets, CameraTrackerOptions options);
  ~CameraTracker() override;

  std::string name() const override;
  void Start() override;
  void Stop() noexcept override;
  tracking::PoseBoard& board() noexcept override;
  /// Images count as messages, images of a wrong size as bad ones.
  tracking::SourceStatus status() const override;

  const CameraModel& camera() const;
  /// The newest image; null before the first. Takes a short lock: not for the loop that feels
  /// forces.
  std::shared_ptr<const CameraView> Latest() const;

 private:
  class Worker;
  std::unique_ptr<Worker> worker_;
};

}  // namespace acus::camera
