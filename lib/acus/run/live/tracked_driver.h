// A tracked tool as a device without motors: its readings drive the steps of a session.
#pragma once

#include <cstdint>

#include "acus/rig/haptics/driver.h"
#include "acus/rig/haptics/real_time.h"
#include "acus/rig/tracking/pose_board.h"

namespace acus::live {

/// Polls for readings at 1 kHz and ticks once for each; without any, it ticks every 50 ms and
/// reports that the tool is not seen, so that the session continues.
class TrackedDriver final : public haptics::Driver {
 public:
  /// @param board  Must outlive this.
  TrackedDriver(const tracking::PoseBoard& board, std::size_t tool, double stale_s)
      : board_(board), tool_(tool), stale_ns_(static_cast<std::int64_t>(1e9 * stale_s)) {}

  /// A guard that does not judge poses, which the live session does: a tracker is slow and has no
  /// motor.
  static haptics::GuardSettings Guard();

  haptics::DeviceInfo Open() override;
  void Run(haptics::GuardedServo& servo) override;
  void Halt() noexcept override;
  void ZeroNow() noexcept override {}
  std::string FaultText(int code) const override;

 private:
  bool Look() noexcept;

  const tracking::PoseBoard& board_;
  std::size_t tool_;
  std::int64_t stale_ns_;
  haptics::GuardedServo* servo_ = nullptr;
  haptics::ServoThread thread_;
  std::uint64_t number_ = 0;
  std::int64_t ticked_ns_ = 0;
};

}  // namespace acus::live
