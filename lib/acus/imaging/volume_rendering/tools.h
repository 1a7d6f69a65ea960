// The needle and the probe as surfaces.
#pragma once

#include <Eigen/Dense>

#include "acus/data/image/image.h"
#include "acus/data/mesh/surface.h"
#include "acus/imaging/acoustics/probe.h"

namespace acus::volume_rendering {

/// A round tube along points, from a closed end to a closed end.
/// @param radius_mm  One for each point: a tip has 0.
/// @throws InputError for fewer than two points, another number of radii, or one that is not
///     finite.
mesh::Surface Tube(const Eigen::Matrix3Xd& points_mm, const Eigen::VectorXd& radius_mm);

/// The needle with a pointed tip. @param least_radius_mm  Drawn no thinner than that.
/// @throws InputError if it is not finite or has no length.
mesh::Surface NeedleShaft(const image::NeedleInImage& needle, double least_radius_mm);
/// Rings on the shaft at multiples of the distance from the tip, each fifth one wider; empty if
/// none fits. Same line and radius as NeedleShaft(). @pre distance_mm > 0. @throws InputError as
/// that.
mesh::Surface NeedleMarks(const image::NeedleInImage& needle, double least_radius_mm,
                          double distance_mm);
/// What the hand holds, at the end of the shaft.
mesh::Surface NeedleHub(const image::NeedleInImage& needle);

/// A probe of usual shape around the face that `probe` has, in the probe's frame.
mesh::Surface ProbeBody(const acoustics::Probe& probe);
/// The ridge on its marked side.
mesh::Surface ProbeMark(const acoustics::Probe& probe);

/// What a probe sees: a piece of its plane, in its frame. Node n shows pixel pixel_of_node.col(n).
struct ImagePlane {
  mesh::Surface surface;
  Eigen::Matrix2Xf pixel_of_node;
  Eigen::Matrix3Xd outline_mm;  ///< Closed: the last point is the first.
};
/// Without the black corners of its image.
ImagePlane PlaneOf(const acoustics::Probe& probe);

}  // namespace acus::volume_rendering
