// Objects that bear several tracked facets (flat groups of markers): one pose from all that are
// seen.
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "acus/patient/registration/rigid_registration.h"

namespace acus::registration {

struct Facet {
  std::string name;
  std::vector<std::string> point_names;
  transforms::Markers points_mm;  ///< At least 3, not on a line, in the facet's own frame.
};

/// Poses of all facets at one moment; nothing where one is not seen.
using FacetPoses = std::vector<std::optional<Eigen::Isometry3d>>;

/// An object with its facets; its frame is that of its first facet.
struct FacetModel {
  std::vector<Facet> facets;
  std::vector<Eigen::Isometry3d> object_from_facet;
  std::vector<double> facet_rms_mm;   ///< Noise of each facet's points about the fused pose, RMS.
  std::vector<std::size_t> num_seen;  ///< Moments in which each was seen beside another one.
  std::size_t num_moments = 0;        ///< With at least two facets.
  std::size_t num_rejected = 0;       ///< Readings that did not fit (a flat facet seen flipped).

  /// The points of one facet in the object's frame.
  transforms::Markers PointsInObjectMm(std::size_t facet) const {
    return object_from_facet[facet] * facets[facet].points_mm;
  }
};

/// Finds how the facets lie on their object, from moments in which several were seen together,
/// while the object may move: poses of the object and places of the facets in turn by least squares
/// over their points (generalised Procrustes analysis, Gower 1975) until they change by less than
/// 1e-6 mm. Readings more than 5 times the median residual off are omitted.
/// @throws InputError if a facet has too few points, or names that are not unique.
/// @throws NoAnswerError naming the facets that were never seen together with the others.
FacetModel CalibrateFacets(const std::vector<Facet>& facets, std::span<const FacetPoses> moments);

struct FusedPose {
  Eigen::Isometry3d tracker_from_object = Eigen::Isometry3d::Identity();
  double rms_mm = 0.0;           ///< Of the used facets' points.
  std::vector<bool> used;        ///< Per facet.
  bool facets_disagree = false;  ///< Two facets that contradict each other: none can be preferred.
};

/// The pose of the object from the facets that are seen, each weighted by its noise. With three or
/// more, those that do not fit the others (5 times the noise) are omitted. Nothing if none is
/// seen.
std::optional<FusedPose> FuseFacets(const FacetModel& model, const FacetPoses& seen);

/// Facets whose points do not fit the others in CT (moved since the scan): each facet is omitted
/// in turn and judged as LeaveEachOut() judges single markers, corrected for the number of facets.
struct MovedFacet {
  std::string name;
  double moved_mm = 0.0;  ///< RMS of its points from where the other facets put them.
  double p_value = 1.0;
};
/// @param facet_of  The facet of each marker, numbers from 0.
std::vector<MovedFacet> FindMovedFacets(const transforms::Markers& object_mm,
                                        const transforms::Markers& ct_mm,
                                        const std::vector<std::size_t>& facet_of,
                                        const std::vector<std::string>& facet_names,
                                        double significance = 0.01);

}  // namespace acus::registration
