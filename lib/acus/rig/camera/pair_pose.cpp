#include "acus/rig/camera/pair_pose.h"

#include <array>
#include <cmath>

#include "acus/base/core/error.h"

namespace acus::camera {
namespace {

/// Share of the corners that each camera uses alone, so many must fit one pose of both.
constexpr double kLeastShare = 0.75;

const DetectedMarker* OnlyOne(std::span<const DetectedMarker> markers, int id) {
  const DetectedMarker* found = nullptr;
  for (const DetectedMarker& marker : markers) {
    if (marker.id != id) continue;
    if (found != nullptr) return nullptr;  // Seen twice: only a pose shows which one it is.
    found = &marker;
  }
  return found;
}

/// From the corners that both cameras see; nothing if that is no marker.
std::optional<Eigen::Isometry3d> AbsoluteOrientation(const FacetObject& object,
                                                     std::span<const DetectedMarker> left,
                                                     std::span<const DetectedMarker> right,
                                                     const StereoPair& pair) {
  std::vector<Eigen::Vector3d> known, found;
  for (const Marker& marker : object.markers) {
    const DetectedMarker* a = OnlyOne(left, marker.id);
    const DetectedMarker* b = OnlyOne(right, marker.id);
    if (a == nullptr || b == nullptr) continue;
    const auto corners = marker.CornersInObjectMm();
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const auto point = Triangulate(pair, a->corners_px[i], b->corners_px[i]);
      if (!point) continue;
      known.push_back(corners[i]);
      found.push_back(*point);
    }
  }
  if (known.size() < 4) return std::nullopt;
  const auto columns = static_cast<Eigen::Index>(known.size());
  const Eigen::Matrix3Xd from = Eigen::Map<Eigen::Matrix3Xd>(known[0].data(), 3, columns);
  const Eigen::Matrix3Xd to = Eigen::Map<Eigen::Matrix3Xd>(found[0].data(), 3, columns);
  const Eigen::Isometry3d pose(Eigen::umeyama(from, to, false));
  if (!pose.matrix().allFinite()) return std::nullopt;
  return pose;
}

/// The left camera's pose unless only the right one's is clear.
PairPose OfOneCamera(const std::optional<ObjectPose>& left, std::optional<ObjectPose> right,
                     const StereoPair& pair, PairUse use) {
  if (left && (!right || !left->ambiguous || right->ambiguous)) return {.pose = *left, .use = use};
  const Eigen::Isometry3d left_from_right = pair.right_from_left.inverse();
  right->camera_from_object = left_from_right * right->camera_from_object;
  Eigen::Matrix<double, 6, 6> turn = Eigen::Matrix<double, 6, 6>::Zero();
  turn.topLeftCorner<3, 3>() = turn.bottomRightCorner<3, 3>() = left_from_right.linear();
  right->covariance = turn * right->covariance * turn.transpose();
  return {.pose = *right, .use = use};
}

}  // namespace

std::optional<PairPose> LocateObjectInPair(const FacetObject& object,
                                           std::span<const DetectedMarker> left,
                                           std::span<const DetectedMarker> right,
                                           const StereoPair& pair, const PoseSettings& settings,
                                           const std::optional<Eigen::Isometry3d>& previous) {
  const auto in_left = LocateObject(object, left, pair.left, settings, previous);
  std::optional<Eigen::Isometry3d> previous_in_right;
  if (previous) previous_in_right = pair.right_from_left * *previous;
  const auto in_right = LocateObject(object, right, pair.right, settings, previous_in_right);
  if (!in_left && !in_right) return std::nullopt;
  if (!in_left || !in_right) return OfOneCamera(in_left, in_right, pair, PairUse::kOne);

  PoseSettings both = settings;
  both.corner_sigma_px = std::hypot(settings.corner_sigma_px, pair.reprojection_rms_px);
  std::vector<Eigen::Isometry3d> starts;
  if (const auto start = AbsoluteOrientation(object, left, right, pair)) starts.push_back(*start);
  const std::array<ViewedMarkers, 2> views = {
      ViewedMarkers{.viewpoint = {.camera = &pair.left}, .markers = left},
      ViewedMarkers{.viewpoint = {.camera = &pair.right, .here_from_first = pair.right_from_left},
                    .markers = right}};
  auto pose = LocateObjectInViews(object, views, both, starts, previous);
  const int alone = in_left->corners_used + in_right->corners_used;
  if (!pose || pose->corners_used < kLeastShare * alone) {
    return OfOneCamera(in_left, in_right, pair, PairUse::kDisagree);
  }
  return PairPose{.pose = std::move(*pose), .use = PairUse::kBoth};
}

void PairAgreement::Count(PairUse use) noexcept {
  if (use == PairUse::kBoth) {
    ++agreed_;
    in_a_row_ = 0;
  } else if (use == PairUse::kDisagree) {
    ++disagreed_;
    ++in_a_row_;
  }
}

std::string PairAgreement::Problem() const {
  return Message("the two cameras put the facets in different places, ", disagreed_, " times of ",
                 agreed_ + disagreed_,
                 ": left and right are exchanged, the stereo file is of other cameras, a camera "
                 "was moved, or the images are not of the same moments; put that right, or "
                 "calibrate the pair again with acus-camera stereo");
}

}  // namespace acus::camera
