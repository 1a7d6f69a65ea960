// Where the needle of a scene is to end: a structure of the label map, or a point.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "acus/patient/phantom/anatomy/patient_field.h"
#include "acus/patient/phantom/planning/body_frame.h"
#include "acus/patient/phantom/planning/spinal_level.h"

namespace acus::phantom {

struct TargetPoint {
  Eigen::Vector3d point_ct_mm;
  double depth_mm;  ///< Inside the structure; 0 for a point that was given.
};

struct SceneTarget {
  std::string structure;            ///< The name of the tissue at the points, without the side.
  std::string name;                 ///< As requested, for people.
  std::vector<TargetPoint> points;  ///< The deepest first, 10 mm from each other or more.
  /// Tissues that a path may meet though others avoid them: that of the structure, and of the organ
  /// that it lies in.
  std::vector<volume::Label> passable;
};

/// The names of the structures of `labels` that a needle can be sent to, in alphabetical order.
std::vector<std::string> TargetNames(const volume::LabelMap& labels);

/// The same names, with commas, for messages.
std::string TargetList(const volume::LabelMap& labels);

/// @param request  A structure, where `_left` and `_right` take its voxels on one side of the
/// middle,
///     or a point.
/// @throws InputError if the structure is not in the map (naming those that are) or cannot be a
///     target, or if the point lies outside the body, in bone or in gas.
SceneTarget FindSceneTarget(const volume::LabelMap& labels, const PatientField& field,
                            const BodyFrame& frame, const std::string& request, int num_threads);

/// The spinal canal between two vertebrae; points 3 mm from each other or more.
/// @param name  For people, such as "L3-L4".
/// @throws InputError if the map has no canal there.
SceneTarget FindLevelTarget(const volume::LabelMap& labels, const BodyFrame& frame,
                            const std::string& name, const SpinalLevel& level, int num_threads);

/// Puts points at the named levels of LumbarPunctureLevels() before the others of a spinal canal.
void PutLumbarFirst(const volume::LabelMap& labels, const BodyFrame& frame,
                    std::span<const NamedLevel> levels, int num_threads, SceneTarget& target);

}  // namespace acus::phantom
