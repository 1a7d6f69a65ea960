// Which places of the probe's plane an image covers, and how far they are from the face.
#pragma once

#include <Eigen/Core>

#include "acus/imaging/acoustics/probe.h"

namespace acus::acoustics {

/// Distance of a place of the probe's plane (x, y, mm) from the face, mm: along y for a linear
/// probe, else along the line of the fan through the place. Negative behind the face.
double DepthBelowFaceMm(const Probe& probe, const Eigen::Vector2d& place_mm);

/// True between the outermost lines of the probe, from the face to its depth. Lines that a display
/// steers beyond these are not counted.
bool IsInFieldOfView(const Probe& probe, const Eigen::Vector2d& place_mm);

}  // namespace acus::acoustics
