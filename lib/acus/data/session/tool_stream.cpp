#include "acus/data/session/tool_stream.h"

#include <algorithm>

#include "acus/base/core/error.h"
#include "acus/data/session/pose_csv.h"

namespace acus::session {
namespace {

constexpr double kScaleTolerance = 0.01;

bool Connects(const TimedTransforms& instant, const std::string& frame,
              const std::string& reference) {
  return instant.transforms.HasFrame(frame) && instant.transforms.Find(frame, reference);
}

/// Invalid samples before the first good one take its pose.
void FillLeadingInvalid(PoseStream& stream) {
  const auto first_good = std::ranges::find(stream, true, &PoseSample::valid);
  if (first_good == stream.end()) return;
  for (auto sample = stream.begin(); sample != first_good; ++sample) {
    sample->reference_from_tool = first_good->reference_from_tool;
  }
}

ToolStream Extract(std::span<const TimedTransforms> instants, const std::string& frame,
                   const std::string& reference, const std::string& label,
                   const RunContext& context) {
  ToolStream tool;
  tool.frame = frame;
  std::size_t num_repeated = 0;
  bool has_scale = false;
  for (std::size_t i = 0; i < instants.size(); ++i) {
    const std::int64_t time_ns = instants[i].time_ns;
    if (!tool.poses.empty() && time_ns == tool.poses.back().time_ns) {
      ++num_repeated;
      continue;
    }
    ACUS_REQUIRE(tool.poses.empty() || time_ns > tool.poses.back().time_ns, label, ": frame ", i,
                 ": time goes back from ", SecondsText(tool.poses.back().time_ns), " s to ",
                 SecondsText(time_ns),
                 " s; sort the frames, or let 'acus-import --time-goes-back' drop them or cut the "
                 "recording here");
    const auto found = instants[i].transforms.Find(frame, reference);
    PoseSample sample{time_ns, {}, found && found->valid};
    if (sample.valid) {
      const auto parts = transforms::PoseAndScale(found->to_from_from);
      ACUS_REQUIRE(
          parts, label, ": frame ", i, ": ", frame, "To", reference,
          " is not a pose: its axes are not perpendicular, have no length, or are mirrored");
      if (!has_scale) tool.scale = parts->scale;
      has_scale = true;
      const double change =
          (parts->scale.cwiseQuotient(tool.scale) - Eigen::Vector3d::Ones()).cwiseAbs().maxCoeff();
      ACUS_REQUIRE(change <= kScaleTolerance, label, ": frame ", i, ": ", frame, "To", reference,
                   " changes its scale by ", 100.0 * change,
                   " %; one calibration must hold for the ", "whole recording");
      sample.reference_from_tool = parts->pose;
    } else if (!tool.poses.empty()) {
      sample.reference_from_tool = tool.poses.back().reference_from_tool;
    }
    tool.poses.push_back(sample);
  }
  if (num_repeated > 0) {
    context.Warn(Message(label, ": ", num_repeated,
                         " frames repeat the time stamp of the one before "
                         "and are excluded from ",
                         frame));
  }
  if (!has_scale)
    context.Warn(Message(label, ": ", frame, " was never seen: all poses are invalid"));
  FillLeadingInvalid(tool.poses);
  return tool;
}

}  // namespace

std::optional<ToolStream> ExtractTool(std::span<const TimedTransforms> instants,
                                      std::span<const std::string> frames,
                                      const std::string& reference, const std::string& label,
                                      const RunContext& context) {
  for (const std::string& frame : frames) {
    const bool known = std::ranges::any_of(instants, [&](const TimedTransforms& instant) {
      return Connects(instant, frame, reference);
    });
    if (known) return Extract(instants, frame, reference, label, context);
  }
  return {};
}

}  // namespace acus::session
