// Registration of swept points to a surface: the skin of the mannequin to that of the CT.
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

#include "acus/base/core/run_context.h"
#include "acus/data/mesh/surface.h"
#include "acus/patient/registration/weighted_registration.h"

namespace acus::registration {

struct SurfaceSettings {
  double keep = 0.9;        ///< In (0, 1]. Share of the points, the nearest ones, that count.
  int num_starts = 24;      ///< >= 1. Poses around the start, or over all orientations without one.
  double start_mm = 30.0;   ///< >= 0. How far off the start may be ...
  double start_deg = 20.0;  ///< >= 0. ... and how much turned.
  /// > 0. A motion of the points that moves them by 1 mm RMS must move them off the surface by at
  /// least this much RMS (mm), or the surface does not determine the pose.
  double least_hold = 0.05;
};

/// A motion that slides the points along the surface.
struct FreeMotion {
  Eigen::Vector3d turn_deg;  ///< About the points' centroid, for 1 mm RMS of motion.
  Eigen::Vector3d shift_mm;  ///< Of the centroid.
  double hold = 0.0;         ///< mm off the surface, RMS, per mm of motion, RMS.
  std::string text;          ///< "sliding along (0.00, 0.00, 1.00)".
};

struct SurfaceFit {
  Eigen::Isometry3d ct_from_reference = Eigen::Isometry3d::Identity();
  Eigen::VectorXd distance_mm;      ///< Per point, signed: outside the surface is positive.
  std::vector<bool> used;           ///< Per point.
  double rms_mm = 0.0;              ///< Of the used points' distances.
  PoseError error;                  ///< From the scatter of the distances.
  std::vector<FreeMotion> motions;  ///< The six principal ones, least held first.
  int num_iterations = 0;
  /// Another pose that fits about as well (RMS within 20 % of this one): how far it puts the
  /// points.
  std::optional<double> rival_mm;
};

/// Iterative closest points (Besl & McKay 1992), point to plane (Chen & Medioni 1992), trimmed
/// (Chetverikov et al. 2005), from several starts; the best is refined.
///
/// Determinacy after Gelfand et al. 2003: with J the derivative of the distances by a motion, the
/// eigenvalues of J^T J / n in units in which each motion moves the points by 1 mm RMS.
///
/// @param start  ct_from_reference, roughly; without it all orientations are tried about the
/// centroids.
/// @throws InputError if there are fewer than 12 points, or a setting is out of its range.
/// @throws NoAnswerError naming the motions, if the surface does not determine the pose (a
/// cylinder,
///     a ball, a plane), or if the best start does not converge.
SurfaceFit RegisterToSurface(const transforms::Markers& points_mm, const mesh::Surface& surface_ct,
                             const std::optional<Eigen::Isometry3d>& start,
                             const SurfaceSettings& settings, const RunContext& context);

}  // namespace acus::registration
