// Transforms between named frames, as PLUS and Slicer name them: "ProbeToTracker" maps points of
// the frame Probe to the frame Tracker.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "acus/data/transforms/pose.h"

namespace acus::transforms {

/// "ProbeToTracker" in its two frames.
struct TransformName {
  std::string from;
  std::string to;
};

/// Splits "ProbeToTracker" or "ProbeToTrackerTransform". Nothing if it is not such a name: the "To"
/// stands between two names, once, and the second begins with a capital letter or a digit.
std::optional<TransformName> ParseTransformName(std::string_view name);

/// A transform that was found along a path.
struct TrackedTransform {
  Eigen::Matrix4d to_from_from = Eigen::Matrix4d::Identity();  ///< mm; affine: Image has pixels.
  bool valid = true;  ///< Every transform on the path was measured (status OK).
};

/// The transforms of one instant. Frames are few, so all searches are linear.
class TransformGraph {
 public:
  /// Adds a transform, or replaces the one between the same frames in the same direction.
  void Set(const TransformName& name, const Eigen::Matrix4d& to_from_from, bool valid);

  /// Adds the transforms of `other` between frames for which there is none yet.
  void AddMissing(const TransformGraph& other);

  /// Along the shortest path, inverting where a transform is only known the other way round. Among
  /// paths of equal length the transforms that were added first win.
  /// @returns nothing if the frames are not connected, or only by a transform that has no inverse.
  std::optional<TrackedTransform> Find(std::string_view from, std::string_view to) const;

  bool HasFrame(std::string_view frame) const;

  /// "ProbeToTracker, StylusToTracker", for messages.
  std::string Names() const;

 private:
  struct Edge {
    TransformName name;
    Eigen::Matrix4d to_from_from;
    bool valid;
  };
  std::vector<Edge> edges_;
};

/// An affine transform as rotation, translation and scale of the axes: what an image frame in
/// pixels is made of.
struct ScaledPose {
  Pose pose;                                        ///< mm.
  Eigen::Vector3d scale = Eigen::Vector3d::Ones();  ///< mm per unit of each source axis.
};

/// Nothing if an axis has no length, the axes are more than `tolerance` from perpendicular
/// (cosine), or they are left-handed.
std::optional<ScaledPose> PoseAndScale(const Eigen::Matrix4d& affine, double tolerance = 0.02);

}  // namespace acus::transforms
