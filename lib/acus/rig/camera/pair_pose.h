// Where an object with facets is, from the images of a calibrated pair of cameras.
#pragma once

#include "acus/rig/camera/facet_pose.h"
#include "acus/rig/camera/stereo_pair.h"

namespace acus::camera {

/// How the two images bear on a pose.
enum class PairUse {
  kOne,       ///< Only one camera sees the object.
  kBoth,      ///< One pose fits the corners of both.
  kDisagree,  ///< No pose fits both: it is that of one camera alone.
};

struct PairPose {
  ObjectPose pose;  ///< In the left camera's frame.
  PairUse use = PairUse::kOne;
};

/// Corners that both cameras see are triangulated, and the object's corners laid over them
/// (absolute orientation, Umeyama 1991, doi:10.1109/34.88573); from there, and from the poses of
/// each marker, all corners of both images are fitted with both lenses (bundle adjustment, the
/// cameras held). Corners count with the standard deviation of the pair's calibration added.
/// Nothing if neither camera sees the object.
/// @param previous  Its pose in the image before, in the left camera's frame.
std::optional<PairPose> LocateObjectInPair(const FacetObject& object,
                                           std::span<const DetectedMarker> left,
                                           std::span<const DetectedMarker> right,
                                           const StereoPair& pair, const PoseSettings& settings,
                                           const std::optional<Eigen::Isometry3d>& previous);

/// Whether a pair's file is right, from what its cameras see: a pair that has not agreed on
/// anything for a while is refused, until it agrees again.
class PairAgreement {
 public:
  void Count(PairUse use) noexcept;
  bool refused() const noexcept { return in_a_row_ >= kLimit; }
  int agreed() const noexcept { return agreed_; }
  int disagreed() const noexcept { return disagreed_; }
  /// What is wrong and what to do, for people.
  std::string Problem() const;

 private:
  static constexpr int kLimit = 15;  ///< Disagreements in a row.
  int in_a_row_ = 0, agreed_ = 0, disagreed_ = 0;
};

}  // namespace acus::camera
