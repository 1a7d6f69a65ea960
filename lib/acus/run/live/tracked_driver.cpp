#include "acus/run/live/tracked_driver.h"

#include "acus/base/core/monotonic_time.h"

namespace acus::live {
namespace {

constexpr std::int64_t kSilentNs = 50'000'000;

}  // namespace

haptics::GuardSettings TrackedDriver::Guard() {
  haptics::GuardSettings settings;
  settings.max_force_n = 0.0;
  settings.max_torque_nmm = 0.0;
  settings.late_s = 0.2;
  settings.settle_s = 0.0;
  settings.ramp_in_s = 0.0;
  settings.jump_mm = 1000.0;
  settings.jump_rad = 2.9;
  return settings;
}

haptics::DeviceInfo TrackedDriver::Open() {
  haptics::DeviceInfo info;
  info.name = "tracked tool " + board_.tools()[tool_];
  info.rate_hz = 1000.0;
  return info;
}

void TrackedDriver::Run(haptics::GuardedServo& servo) {
  servo_ = &servo;
  const std::string notice = thread_.Start(
      1000.0, [](void* self) noexcept { return static_cast<TrackedDriver*>(self)->Look(); }, this);
  if (!notice.empty()) servo.Notice(notice);
}

void TrackedDriver::Halt() noexcept {
  thread_.Stop();
}

std::string TrackedDriver::FaultText(int) const {
  return {};
}

bool TrackedDriver::Look() noexcept {
  const tracking::TrackedPose latest = board_.Latest(tool_);
  const std::int64_t now_ns = MonotonicNs();
  const bool is_news = latest.number != number_;
  if (!is_news && now_ns - ticked_ns_ < kSilentNs) return true;
  number_ = latest.number;
  ticked_ns_ = now_ns;
  haptics::DeviceReading reading;
  reading.time_ns = now_ns;
  reading.device_from_handle = latest.reference_from_tool.isometry();
  reading.valid = latest.valid && latest.AgeNs(now_ns) <= stale_ns_;
  servo_->Tick(reading, &MonotonicNs);
  return true;
}

}  // namespace acus::live
