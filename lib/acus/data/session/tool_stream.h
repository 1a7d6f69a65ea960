// From the transforms of each instant to the pose stream of one tool.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "acus/base/core/run_context.h"
#include "acus/data/session/session.h"
#include "acus/data/transforms/transform_graph.h"

namespace acus::session {

/// All transforms at one instant.
struct TimedTransforms {
  std::int64_t time_ns = 0;
  transforms::TransformGraph transforms;
};

struct ToolStream {
  PoseStream poses;                                 ///< reference_from_tool, mm.
  std::string frame;                                ///< The tool frame that was taken.
  Eigen::Vector3d scale = Eigen::Vector3d::Ones();  ///< mm per unit of its axes.
};

/// The stream of the first of `frames` that any instant connects with `reference`.
///
/// Instants without a connection, or with one that was not measured (status), are invalid samples
/// and keep the last good pose. Repeated instants are dropped with a warning. Axes are made
/// perpendicular and of unit length; what they measured is the scale.
/// @param label  Stands for the file in messages.
/// @throws InputError at file: frame, if time goes back, or a transform mirrors, shears, or changes
///     its scale by more than 1 % in the course of the recording.
std::optional<ToolStream> ExtractTool(std::span<const TimedTransforms> instants,
                                      std::span<const std::string> frames,
                                      const std::string& reference, const std::string& label,
                                      const RunContext& context);

}  // namespace acus::session
