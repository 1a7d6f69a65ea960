// Transforms and recorded transform sequences of a 3D Slicer scene.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "acus/data/session/tool_stream.h"
#include "acus/data/transforms/transform_graph.h"

namespace acus::session {

/// One entry of a recorded sequence.
struct TimedMatrix {
  std::int64_t time_ns = 0;
  Eigen::Matrix4d to_from_from = Eigen::Matrix4d::Identity();  ///< RAS, to parent, mm.
};

struct SlicerScene {
  /// Transforms that do not change, by their names, e.g. NeedleTipToNeedle.
  transforms::TransformGraph fixed;
  /// Recorded transforms by name, e.g. "NeedleToReference", in order of time.
  std::map<std::string, std::vector<TimedMatrix>> sequences;
};

/// Reads an .mrml scene with the files beside it, or an .mrb bundle that holds such a scene.
/// Only linear transforms with names like AToB are taken; all else in the scene is skipped.
/// @throws InputError if a file is missing or damaged, or there is no transform at all.
SlicerScene ReadSlicerScene(const std::filesystem::path& path);

/// The transforms at the instants at which `frame` was recorded against `reference`: those of the
/// one sequence of the chain, or of all sequences together if the chain has several.
std::vector<TimedTransforms> InstantsFor(const SlicerScene& scene, const std::string& frame,
                                         const std::string& reference);

/// Names of all transforms, for messages.
std::string TransformNames(const SlicerScene& scene);

}  // namespace acus::session
