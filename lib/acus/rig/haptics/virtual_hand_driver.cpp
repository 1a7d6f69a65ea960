#include "acus/rig/haptics/virtual_hand_driver.h"

#include <utility>

#include "acus/base/core/monotonic_time.h"

namespace acus::haptics {
namespace {

const VirtualHandSettings& Checked(const VirtualHandSettings& settings) {
  settings.Check();
  return settings;
}

}  // namespace

VirtualHandDriver::VirtualHandDriver(const VirtualHandSettings& settings,
                                     std::shared_ptr<HandSteering> steering, Clock clock)
    : steering_(std::move(steering)), clock_(clock), hand_(Checked(settings), steering_.get()) {}

DeviceInfo VirtualHandDriver::Open() {
  DeviceInfo info;
  info.name = "virtual hand";
  info.max_force_n = hand_.settings().max_force_n;
  info.max_torque_nmm = hand_.settings().max_torque_nmm;
  info.rate_hz = hand_.settings().rate_hz;
  return info;
}

void VirtualHandDriver::Run(GuardedServo& servo) {
  servo_ = &servo;
  has_ticked_ = false;
  force_ = DeviceForce();
  if (clock_ == Clock::kStepped) return;
  const std::string notice = thread_.Start(
      hand_.settings().rate_hz,
      [](void* me) noexcept {
        static_cast<VirtualHandDriver*>(me)->TickAt(MonotonicNs(), &MonotonicNs);
        return true;
      },
      this);
  if (!notice.empty()) servo.Notice(notice);
}

void VirtualHandDriver::Halt() noexcept {
  thread_.Stop();
  servo_ = nullptr;
  force_ = DeviceForce();
}

void VirtualHandDriver::Step(std::int64_t time_ns) noexcept {
  if (servo_ != nullptr) TickAt(time_ns, nullptr);
}

void VirtualHandDriver::TickAt(std::int64_t time_ns, std::int64_t (*clock)() noexcept) noexcept {
  const double dt_s = has_ticked_ ? 1e-9 * static_cast<double>(time_ns - last_ns_) : 0.0;
  last_ns_ = time_ns;
  has_ticked_ = true;
  DeviceReading reading = hand_.Step(force_, dt_s);
  reading.time_ns = time_ns;
  force_ = servo_->Tick(reading, clock);
}

std::string VirtualHandDriver::FaultText(int /*code*/) const {
  return "";  // It has none.
}

}  // namespace acus::haptics
