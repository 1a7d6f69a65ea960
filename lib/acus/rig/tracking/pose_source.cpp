#include "acus/rig/tracking/pose_source.h"

namespace acus::tracking {

const char* Name(SourceState state) {
  switch (state) {
    case SourceState::kStopped:
      return "stopped";
    case SourceState::kConnecting:
      return "connecting";
    case SourceState::kConnected:
      return "connected";
  }
  return "?";
}

SourceCounts SourceCounts::Since(const SourceCounts& before) const {
  return {.messages = messages - before.messages,
          .readings = readings - before.readings,
          .not_seen = not_seen - before.not_seen,
          .bad_poses = bad_poses - before.bad_poses,
          .out_of_order = out_of_order - before.out_of_order,
          .repeated = repeated - before.repeated,
          .fell_silent = fell_silent - before.fell_silent,
          .other_tools = other_tools - before.other_tools,
          .other_messages = other_messages - before.other_messages,
          .bad_messages = bad_messages - before.bad_messages,
          .skipped_bytes = skipped_bytes - before.skipped_bytes,
          .connects = connects - before.connects,
          .lost_from_journal = lost_from_journal - before.lost_from_journal};
}

}  // namespace acus::tracking
