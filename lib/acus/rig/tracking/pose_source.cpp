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

}  // namespace acus::tracking
