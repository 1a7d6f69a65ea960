#include "acus/rig/camera/facet_pose.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/calib3d.hpp>

#include "acus/base/math/rigid.h"
#include "acus/rig/camera/pose_refinement.h"

namespace acus::camera {
namespace {

/// Residuals beyond this many standard deviations are outliers, to the search.
constexpr double kOutlierSigmas = 6.0;
constexpr std::size_t kRefined = 6;  ///< Best candidates that are refined.
constexpr double kSameAngleRad = 0.02;
constexpr double kLargestRatio = 1e6;

/// A marker of the object and one place where its number was seen.
struct Match {
  const Marker* marker;
  const DetectedMarker* seen;
  std::size_t view;  ///< In which of the images.
};

std::vector<Match> Matches(const FacetObject& object, std::span<const ViewedMarkers> views) {
  std::vector<Match> matches;
  for (std::size_t view = 0; view < views.size(); ++view) {
    for (const Marker& marker : object.markers) {
      for (const DetectedMarker& detected : views[view].markers) {
        if (detected.id == marker.id) matches.push_back({&marker, &detected, view});
      }
    }
  }
  return matches;
}

void AddPoints(const Match& match, double least_sigma_px, std::vector<SeenPoint>& points) {
  const auto corners = match.marker->CornersInObjectMm();
  for (std::size_t i = 0; i < 4; ++i) {
    points.push_back({corners[i], match.seen->corners_px[i],
                      std::hypot(match.seen->sigma_px[i], least_sigma_px), match.view});
  }
}

/// Both poses from which a flat square looks as seen: Collins & Bartoli 2014.
std::vector<Eigen::Isometry3d> FromOneMarker(const Match& match, const Viewpoint& viewpoint) {
  const double h = 0.5 * match.marker->side_mm;
  const std::vector<cv::Point3d> corners = {{-h, h, 0}, {h, h, 0}, {h, -h, 0}, {-h, -h, 0}};
  std::vector<cv::Point2d> slopes;
  for (const Eigen::Vector2d& pixel : match.seen->corners_px) {
    const auto ray = viewpoint.camera->Ray(pixel);
    if (!ray) return {};
    slopes.emplace_back((*ray)[0], (*ray)[1]);
  }
  std::vector<cv::Mat> turns, shifts;
  std::vector<Eigen::Isometry3d> poses;
  try {
    cv::solvePnPGeneric(corners, slopes, cv::Mat::eye(3, 3, CV_64F), cv::noArray(), turns, shifts,
                        false, cv::SOLVEPNP_IPPE_SQUARE);
  } catch (const cv::Exception&) {
    return {};  // Corners on a line.
  }
  for (std::size_t i = 0; i < turns.size(); ++i) {
    Eigen::Vector3d turn, shift;
    for (int k = 0; k < 3; ++k) {
      turn[k] = turns[i].at<double>(k);
      shift[k] = shifts[i].at<double>(k);
    }
    if (!turn.allFinite() || !shift.allFinite()) continue;
    Eigen::Isometry3d camera_from_marker = Eigen::Isometry3d::Identity();
    if (turn.norm() > 0.0) {
      camera_from_marker.linear() =
          Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
    }
    camera_from_marker.translation() = shift;
    poses.push_back(viewpoint.here_from_first.inverse() * camera_from_marker *
                    match.marker->object_from_marker.inverse());
  }
  return poses;
}

double CostOfMatch(const Match& match, const Eigen::Isometry3d& pose,
                   std::span<const Viewpoint> viewpoints, double least_sigma_px) {
  std::vector<SeenPoint> points;
  AddPoints(match, least_sigma_px, points);
  double cost = 0.0;
  for (const SeenPoint& point : points) {
    cost += SquaredResidual(point, pose, viewpoints, kOutlierSigmas * kOutlierSigmas);
  }
  return cost;
}

bool SameSheet(const Match& a, const Match& b) {
  return a.marker == b.marker && a.view == b.view;
}

/// The corners that a pose speaks for: of a number that was seen twice, the better one.
std::vector<SeenPoint> PointsFor(const Eigen::Isometry3d& pose, std::span<const Match> matches,
                                 std::span<const Viewpoint> viewpoints, double least_sigma_px,
                                 double* cost) {
  std::vector<SeenPoint> points;
  *cost = 0.0;
  for (std::size_t i = 0; i < matches.size();) {
    std::size_t best = i;
    double best_cost = CostOfMatch(matches[i], pose, viewpoints, least_sigma_px);
    std::size_t next = i + 1;
    for (; next < matches.size() && SameSheet(matches[next], matches[i]); ++next) {
      const double other = CostOfMatch(matches[next], pose, viewpoints, least_sigma_px);
      if (other < best_cost) {
        best = next;
        best_cost = other;
      }
    }
    AddPoints(matches[best], least_sigma_px, points);
    *cost += best_cost;
    i = next;
  }
  return points;
}

struct Candidate {
  Eigen::Isometry3d pose;
  std::vector<SeenPoint> points;
  double cost;
};

bool Cheaper(const Candidate& a, const Candidate& b) {
  return a.cost < b.cost;
}

/// Refined poses, best first, each only once.
std::vector<Candidate> Search(std::span<const Match> matches, std::span<const Viewpoint> viewpoints,
                              const PoseSettings& settings,
                              std::span<const Eigen::Isometry3d> starts,
                              const std::optional<Eigen::Isometry3d>& previous) {
  std::vector<Candidate> candidates;
  const auto consider = [&](const Eigen::Isometry3d& pose) {
    Candidate candidate{.pose = pose, .points = {}, .cost = 0.0};
    candidate.points =
        PointsFor(pose, matches, viewpoints, settings.corner_sigma_px, &candidate.cost);
    candidates.push_back(std::move(candidate));
  };
  for (const Match& match : matches) {
    for (const Eigen::Isometry3d& pose : FromOneMarker(match, viewpoints[match.view])) {
      consider(pose);
    }
  }
  for (const Eigen::Isometry3d& start : starts) consider(start);
  if (previous) consider(*previous);
  std::stable_sort(candidates.begin(), candidates.end(), Cheaper);
  if (candidates.size() > kRefined) candidates.resize(kRefined);
  std::vector<Candidate> refined;
  for (Candidate& candidate : candidates) {
    const RefinedPose pose =
        RefinePose(candidate.points, candidate.pose, viewpoints, kOutlierSigmas);
    candidate.pose = pose.camera_from_object;
    candidate.cost = pose.cost;
    const auto same = [&](const Candidate& other) {
      return math::AngleBetweenRad(other.pose, candidate.pose) < kSameAngleRad;
    };
    const auto found = std::find_if(refined.begin(), refined.end(), same);
    if (found == refined.end()) {
      refined.push_back(candidate);
    } else if (candidate.cost < found->cost) {
      *found = candidate;
    }
  }
  std::stable_sort(refined.begin(), refined.end(), Cheaper);
  return refined;
}

/// Omits what does not fit, refines with the rest and says how good it is.
std::optional<ObjectPose> Finish(const Candidate& candidate, std::span<const Viewpoint> viewpoints,
                                 const PoseSettings& settings) {
  ObjectPose out;
  const double largest2 = settings.largest_residual_px * settings.largest_residual_px;
  std::vector<SeenPoint> used;
  for (const SeenPoint& point : candidate.points) {
    const double off = SquaredResidual(point, candidate.pose, viewpoints, 1e12);
    const bool fits = off < kOutlierSigmas * kOutlierSigmas * 4.0 &&
                      off * point.sigma_px * point.sigma_px < largest2;
    if (fits) used.push_back(point);
  }
  out.corners_used = static_cast<int>(used.size());
  out.corners_rejected = static_cast<int>(candidate.points.size() - used.size());
  // Most corners must agree: otherwise the sheets are not where the file says.
  if (out.corners_used < 4 || out.corners_used < out.corners_rejected) return std::nullopt;
  const RefinedPose refined = RefinePose(used, candidate.pose, viewpoints, kOutlierSigmas);
  out.camera_from_object = refined.camera_from_object;
  double sum_px2 = 0.0;
  double chi2 = 0.0;
  for (const SeenPoint& point : used) {
    const double off = SquaredResidual(point, refined.camera_from_object, viewpoints, 1e12);
    chi2 += off;
    sum_px2 += off * point.sigma_px * point.sigma_px;
  }
  out.rms_px = std::sqrt(sum_px2 / out.corners_used);
  const double freedom = std::max(1.0, 2.0 * out.corners_used - 6.0);
  out.covariance = refined.covariance * std::max(1.0, chi2 / freedom);
  if (!out.covariance.allFinite()) return std::nullopt;
  return out;
}

}  // namespace

double ObjectPose::PositionSigmaMm() const {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(covariance.topLeftCorner<3, 3>());
  return std::sqrt(std::max(0.0, eigen.eigenvalues()[2]));
}

double ObjectPose::AngleSigmaDeg() const {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(covariance.bottomRightCorner<3, 3>());
  return std::sqrt(std::max(0.0, eigen.eigenvalues()[2])) * 180.0 / std::numbers::pi;
}

std::optional<ObjectPose> LocateObject(const FacetObject& object,
                                       std::span<const DetectedMarker> markers,
                                       const CameraModel& camera, const PoseSettings& settings,
                                       const std::optional<Eigen::Isometry3d>& previous) {
  const ViewedMarkers view{.viewpoint = {.camera = &camera}, .markers = markers};
  return LocateObjectInViews(object, {&view, 1}, settings, {}, previous);
}

std::optional<ObjectPose> LocateObjectInViews(const FacetObject& object,
                                              std::span<const ViewedMarkers> views,
                                              const PoseSettings& settings,
                                              std::span<const Eigen::Isometry3d> starts,
                                              const std::optional<Eigen::Isometry3d>& previous) {
  const std::vector<Match> matches = Matches(object, views);
  if (matches.empty()) return std::nullopt;
  std::vector<Viewpoint> viewpoints;
  for (const ViewedMarkers& view : views) viewpoints.push_back(view.viewpoint);
  std::vector<Candidate> candidates = Search(matches, viewpoints, settings, starts, previous);
  if (candidates.empty()) return std::nullopt;
  double ratio = kLargestRatio;
  bool ambiguous = false;
  if (candidates.size() > 1) {
    // As many residuals as there are are expected: without them, perfect corners divide by zero.
    const double expected = 2.0 * static_cast<double>(candidates[0].points.size());
    ratio =
        std::min(kLargestRatio, (candidates[1].cost + expected) / (candidates[0].cost + expected));
    ambiguous = ratio < settings.smallest_ambiguity_ratio;
  }
  if (ambiguous && previous) {
    const double first = math::AngleBetweenRad(candidates[0].pose, *previous);
    const double second = math::AngleBetweenRad(candidates[1].pose, *previous);
    if (second < first) std::swap(candidates[0], candidates[1]);
    // A pose that is as near to both decides nothing.
    ambiguous = std::min(first, second) > 0.5 * std::max(first, second);
  }
  std::optional<ObjectPose> pose = Finish(candidates[0], viewpoints, settings);
  if (!pose) return std::nullopt;
  pose->name = object.name;
  pose->ambiguity_ratio = ratio;
  pose->ambiguous = ambiguous;
  return pose;
}

}  // namespace acus::camera
