// Corners of a marker from its four edges.
#pragma once

#include "acus/rig/camera/camera_model.h"
#include "acus/rig/camera/marker_detector.h"

namespace acus::camera {

/// Corners to start from, good to about 1.5 px, to where lines along the four edges meet.
/// @param modules  Black and white squares along a side, with the border.
/// @param camera   If given, the lines are straight in its rays. May be null.
/// An edge that cannot be made out keeps its place, and its corners a standard deviation of 0.7 px.
void RefineCorners(const Image& grey, int modules, double search_px, const CameraModel* camera,
                   DetectedMarker& marker);

}  // namespace acus::camera
