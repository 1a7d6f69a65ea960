// Carries out what the user does at the window: orders to the session, movements of virtual hands.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "acus/run/live/live_image.h"
#include "acus/run/live/live_session.h"
#include "acus/window/command.h"
#include "acus/window/orders.h"
#include "acus/window/undo.h"

namespace acus::window {

class SessionOperation {
 public:
  /// A slow window moves a tool by at most this time of a held key in each of its images: it delays
  /// the tool, rather than carrying it too far.
  static constexpr double kLongestHeldS = 0.1;

  /// @param session  Must outlive this.
  explicit SessionOperation(live::LiveSession& session);

  /// False: the user ends the session. Orders reach the session in its next step.
  /// @param image  The newest one.  @param now_s  Any clock, as for Move().
  bool Obey(std::span<const Command> commands, const live::LiveImage& image, double now_s);

  /// Moves the tool that keys move.
  /// @param tip_to_target_mm  As shown: keys become slower towards the target.
  void Move(const HandInput& input, const std::optional<double>& tip_to_target_mm, double now_s);

  bool steers_probe() const { return !steers_needle_; }
  /// Why the last command had no effect; empty: none of the last seconds.
  std::string NoticeAt(double now_s) const;

 private:
  MovementHistory& History() { return steers_needle_ ? of_needle_ : of_probe_; }

  live::LiveSession& session_;
  SessionAbilities abilities_;
  OrderedSettings ordered_;
  bool steers_needle_ = true;
  MovementHistory of_needle_;
  MovementHistory of_probe_;
  std::string notice_;
  double notice_until_s_ = 0.0;
  std::optional<double> moved_s_;
};

}  // namespace acus::window
