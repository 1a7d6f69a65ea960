// Plays the motion of tools as a tracker would send it, with images and faults.
#pragma once

#include <cstdint>
#include <functional>
#include <iosfwd>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "acus/base/core/run_context.h"
#include "acus/rig/tracking/image.h"
#include "acus/rig/tracking/pose_server.h"
#include "acus/rig/tracking/simulators/faults.h"
#include "acus/rig/tracking/simulators/tool_motion.h"

namespace acus::simulators {

/// Images of the session, such as those of a camera that looks at the mannequin. Drawn by a thread
/// of its own, so that poses never wait for one.
class ImageSource {
 public:
  virtual ~ImageSource() = default;
  /// Names on the network, one for each image of an instant: "Video".
  virtual std::vector<std::string> streams() const = 0;
  virtual double rate_hz() const = 0;
  /// The scene at a time of the motion, for each stream. `poses`: the newest of each tool, with its
  /// validity.
  virtual std::vector<tracking::Image> Draw(std::span<const tracking::NamedPose> poses,
                                            std::int64_t time_ns) = 0;
};

struct PlaybackOptions {
  tracking::PoseServerOptions server = {};
  double speed = 1.0;             ///< Of the motion; stamps are those of sending.
  std::optional<double> seconds;  ///< Ends after this; else at the motion's end, or never.
  bool wait_for_client = false;   ///< The motion begins when a client listens.
  std::vector<Fault> faults = {};
  std::function<void(int port)> on_listening = {};  ///< Called once, before the first pose.
};

struct PlaybackReport {
  double played_s = 0.0;
  std::uint64_t sent = 0;  ///< Instants that were sent, faulty ones included.
  std::uint64_t late = 0;  ///< Of these: more than 5 ms after their time.
  double worst_late_ms = 0.0;
  std::uint64_t images = 0;
  tracking::PoseServerStatus server = {};
};

/// Plays until the end or until a stop is requested (context.stop), which is no error.
/// @throws InputError if the port is taken or the speed is not in [0.01, 100].
PlaybackReport Play(const ToolMotion& motion, ImageSource* images, const PlaybackOptions& options,
                    const RunContext& context);

/// "played 12.3 s: 1230 instants, ..."
std::string Text(const PlaybackReport& report);

}  // namespace acus::simulators
