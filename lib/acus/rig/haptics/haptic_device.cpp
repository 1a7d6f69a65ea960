#include "acus/rig/haptics/haptic_device.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdlib>
#include <mutex>
#include <thread>
#include <utility>

#include "acus/base/core/error.h"
#include "acus/base/core/monotonic_time.h"
#include "acus/base/core/seqlock.h"
#include "acus/rig/haptics/driver.h"
#include "acus/rig/haptics/real_time.h"
#include "acus/rig/haptics/zero_forces.h"

namespace acus::haptics {
namespace {

constexpr std::int64_t kPedalNs = 300'000'000;
constexpr int kWatchdogPriority = 85;  ///< Above the servo, which may be stuck.
constexpr double kSilentS = 0.5;       ///< A servo that is not called for so long is dead.
constexpr auto kLongestPause = std::chrono::milliseconds(2000);

/// A reading and its force as plain numbers, for the lock-free exchange.
struct Snapshot {
  std::int64_t time_ns;
  std::array<double, 12> pose;  ///< Upper three rows of the matrix, column by column.
  std::array<double, 3> velocity_mm_s;
  std::array<double, 3> angular_velocity_rad_s;
  unsigned buttons;
  unsigned valid;
  std::array<double, 3> force_n;
  std::array<double, 3> torque_nmm;
};

using Row = Eigen::Map<Eigen::Vector3d>;
using ConstRow = Eigen::Map<const Eigen::Vector3d>;

Snapshot Pack(const DeviceReading& reading, const DeviceForce& force) {
  Snapshot packed{};
  packed.time_ns = reading.time_ns;
  Eigen::Map<Eigen::Matrix<double, 3, 4>>(packed.pose.data()) =
      reading.device_from_handle.matrix().topRows<3>();
  Row(packed.velocity_mm_s.data()) = reading.velocity_mm_s;
  Row(packed.angular_velocity_rad_s.data()) = reading.angular_velocity_rad_s;
  packed.buttons = reading.buttons;
  packed.valid = reading.valid ? 1 : 0;
  Row(packed.force_n.data()) = force.force_n;
  Row(packed.torque_nmm.data()) = force.torque_nmm;
  return packed;
}

void Unpack(const Snapshot& packed, DeviceReading& reading, DeviceForce& force) {
  reading.time_ns = packed.time_ns;
  const Eigen::Map<const Eigen::Matrix<double, 3, 4>> pose(packed.pose.data());
  reading.device_from_handle.setIdentity();
  reading.device_from_handle.linear() = pose.leftCols<3>();
  reading.device_from_handle.translation() = pose.col(3);
  reading.velocity_mm_s = ConstRow(packed.velocity_mm_s.data());
  reading.angular_velocity_rad_s = ConstRow(packed.angular_velocity_rad_s.data());
  reading.buttons = packed.buttons;
  reading.valid = packed.valid != 0;
  force.force_n = ConstRow(packed.force_n.data());
  force.torque_nmm = ConstRow(packed.torque_nmm.data());
}

GuardSettings WithDeviceLimits(GuardSettings settings, const DeviceInfo& info) {
  settings.Check("safety");
  settings.max_force_n = std::min(settings.max_force_n, info.max_force_n);
  settings.max_torque_nmm = std::min(settings.max_torque_nmm, info.max_torque_nmm);
  return settings;
}

std::uint64_t PackFault(DriverFault fault, int code) {
  return std::uint64_t{static_cast<std::uint8_t>(fault)} << 32 | static_cast<std::uint32_t>(code);
}

/// Open() may fail half-way.
DeviceInfo OpenOrHalt(Driver& driver) {
  try {
    return driver.Open();
  } catch (...) {
    driver.Halt();
    throw;
  }
}

}  // namespace

struct HapticDevice::Impl final : GuardedServo {
  Impl(std::unique_ptr<Driver> opened, const GuardSettings& settings)
      : driver(std::move(opened)),
        info(OpenOrHalt(*driver)),
        guard(WithDeviceLimits(settings, info)) {}

  DeviceForce Tick(const DeviceReading& reading,
                   std::int64_t (*clock)() noexcept) noexcept override;
  void Report(DriverFault fault, int code) noexcept override;
  void Notice(const std::string& notice) override;

  void Watch();
  bool WatchOnce(std::int64_t now_ns);
  void CutOverrun(std::int64_t now_ns);
  void Recover(const std::string& why);
  void Fail(const std::string& why);
  bool PauseFor(std::chrono::milliseconds time);
  void SetState(DeviceState to, const std::string& why);
  void BeginCounting();

  std::unique_ptr<Driver> driver;
  DeviceInfo info;
  ForceGuard guard;
  Servo servo;
  bool is_open = true;
  bool is_started = false;

  std::atomic<unsigned> inhibited{0};
  std::atomic<std::int64_t> pedal_until_ns{0};
  std::atomic<bool> parked{false};          ///< `servo` is not called and may be changed.
  std::atomic<bool> restarts_guard{false};  ///< At the next tick.

  // Servo thread to watchdog. Zero: not within a tick. Negative: within one that was cut.
  std::atomic<std::int64_t> tick_began_ns{0};
  std::atomic<std::int64_t> last_tick_ns{0};
  std::atomic<std::uint64_t> fault{0};
  std::atomic<int> warning_code{0};
  std::atomic<std::int64_t> num_ticks{0};
  std::atomic<std::int64_t> num_warnings{0};
  std::atomic<std::int64_t> longest_tick_ns{0};
  Seqlock<Snapshot> newest;

  // Watchdog only.
  std::thread watchdog;
  std::int64_t seen_warnings = 0;

  // Watchdog, Start, Stop and status(); never the servo thread.
  mutable std::mutex mutex;
  std::condition_variable wake;
  bool stopping = false;
  DeviceState state = DeviceState::kStopped;
  std::string text;
  std::vector<std::string> notices;
  std::int64_t num_reopened = 0;
  std::int64_t num_overruns = 0;
  // Counts that Start() found.
  std::int64_t ticks_before = 0;
  std::int64_t warnings_before = 0;
  GuardCounts guard_before;
};

DeviceForce HapticDevice::Impl::Tick(const DeviceReading& reading,
                                     std::int64_t (*clock)() noexcept) noexcept {
  const std::int64_t begin_ns = MonotonicNs();
  // In one order with Park(): either it sees this tick, or the tick sees that the device is parked.
  tick_began_ns.store(begin_ns, std::memory_order_seq_cst);
  const bool is_parked = parked.load(std::memory_order_seq_cst);
  if (restarts_guard.exchange(false, std::memory_order_acq_rel)) {
    guard.Restart();
    longest_tick_ns.store(0, std::memory_order_relaxed);
  }
  const std::uint64_t pending = fault.load(std::memory_order_acquire);
  const GuardConditions conditions{
      .inhibited = is_parked || inhibited.load(std::memory_order_acquire) != 0 || ForcesAreCut() ||
                   pending != 0,
      .pedal_held = begin_ns < pedal_until_ns.load(std::memory_order_acquire)};
  const DeviceReading admitted = guard.Admit(reading, conditions);
  DeviceForce wanted;
  // A servo sees times that increase.
  if (!is_parked && servo.tick != nullptr && !guard.TimeWentBack()) {
    wanted = servo.tick(servo.context, admitted);
  }
  const DeviceForce force = guard.Limit(wanted, clock != nullptr ? clock() : reading.time_ns);
  newest.Store(Pack(admitted, force));
  const std::int64_t end_ns = MonotonicNs();
  num_ticks.store(num_ticks.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
  longest_tick_ns.store(
      std::max(longest_tick_ns.load(std::memory_order_relaxed), end_ns - begin_ns),
      std::memory_order_relaxed);
  last_tick_ns.store(end_ns, std::memory_order_release);
  // A step that is held up after the guard has looked at the clock is cut by the watchdog alone.
  // Its force would be there at once; the next reading is late, so that the guard begins again.
  const bool is_cut = tick_began_ns.exchange(0, std::memory_order_acq_rel) != begin_ns;
  // The process may have begun to end while the servo was at work.
  return is_cut || ForcesAreCut() ? DeviceForce() : force;
}

void HapticDevice::Impl::Report(DriverFault kind, int code) noexcept {
  if (kind == DriverFault::kNone) return;
  if (kind == DriverFault::kWarning) {
    warning_code.store(code, std::memory_order_relaxed);
    num_warnings.fetch_add(1, std::memory_order_release);
    return;
  }
  // The first one has the reason; a fatal one comes after nothing.
  std::uint64_t none = 0;
  fault.compare_exchange_strong(none, PackFault(kind, code), std::memory_order_acq_rel);
}

void HapticDevice::Impl::Notice(const std::string& notice) {
  const std::lock_guard lock(mutex);
  if (std::ranges::find(notices, notice) == notices.end()) notices.push_back(notice);
}

void HapticDevice::Impl::SetState(DeviceState to, const std::string& why) {
  const std::lock_guard lock(mutex);
  state = to;
  if (!why.empty()) text = why;
}

/// False if Stop() was called meanwhile.
bool HapticDevice::Impl::PauseFor(std::chrono::milliseconds time) {
  std::unique_lock lock(mutex);
  return !wake.wait_for(lock, time, [this] { return stopping; });
}

void HapticDevice::Impl::CutOverrun(std::int64_t now_ns) {
  std::int64_t began_ns = tick_began_ns.load(std::memory_order_acquire);
  if (began_ns <= 0) return;
  if (1e-9 * static_cast<double>(now_ns - began_ns) <= guard.settings().late_s) return;
  if (!tick_began_ns.compare_exchange_strong(began_ns, -began_ns, std::memory_order_acq_rel))
    return;
  driver->ZeroNow();
  const std::lock_guard lock(mutex);
  ++num_overruns;
  text = Message(info.name, ": a step took longer than ", guard.settings().late_s * 1e3,
                 " ms; its force was cut to zero and comes back slowly. If this happens often, ",
                 "call for fewer effects or give the program real-time priority");
}

void HapticDevice::Impl::Fail(const std::string& why) {
  driver->ZeroNow();
  driver->Halt();
  SetState(DeviceState::kFailed, why);
}

void HapticDevice::Impl::Recover(const std::string& why) {
  SetState(DeviceState::kRecovering, why);
  driver->ZeroNow();
  driver->Halt();
  auto pause = std::chrono::milliseconds(50);
  while (PauseFor(pause)) {
    pause = std::min(2 * pause, kLongestPause);
    try {
      driver->Open();
      guard.Restart();
      fault.store(0, std::memory_order_release);
      tick_began_ns.store(0, std::memory_order_release);
      last_tick_ns.store(MonotonicNs(), std::memory_order_release);
      driver->Run(*this);
    } catch (const std::exception& error) {
      driver->Halt();
      SetState(DeviceState::kRecovering, why + "; opening it again: " + error.what());
      continue;
    }
    const std::lock_guard lock(mutex);
    ++num_reopened;
    state = DeviceState::kRunning;
    text = why + "; it was opened again and runs";
    return;
  }
}

/// False when there is nothing left to watch.
bool HapticDevice::Impl::WatchOnce(std::int64_t now_ns) {
  CutOverrun(now_ns);
  const std::int64_t warnings = num_warnings.load(std::memory_order_acquire);
  if (warnings != seen_warnings) {
    seen_warnings = warnings;
    SetState(DeviceState::kRunning, info.name + ": " + driver->FaultText(warning_code.load()));
  }
  const std::uint64_t pending = fault.load(std::memory_order_acquire);
  if (pending != 0) {
    const auto code = static_cast<int>(static_cast<std::uint32_t>(pending));
    const std::string why = info.name + ": " + driver->FaultText(code);
    if (static_cast<DriverFault>(pending >> 32) == DriverFault::kFatal) {
      Fail(why);
      return false;
    }
    Recover(why);
    return true;
  }
  const double silent_s =
      1e-9 * static_cast<double>(now_ns - last_tick_ns.load(std::memory_order_acquire));
  if (silent_s > kSilentS && tick_began_ns.load(std::memory_order_acquire) == 0) {
    Recover(info.name + ": the device has stopped answering");
  }
  return true;
}

void HapticDevice::Impl::Watch() {
  const std::string notice = RequestRealTime(kWatchdogPriority);
  if (!notice.empty()) Notice(notice);
  const auto period = std::chrono::milliseconds(
      std::clamp(static_cast<int>(guard.settings().late_s * 500.0), 1, 10));
  while (PauseFor(period)) {
    if (!WatchOnce(MonotonicNs())) return;
  }
}

HapticDevice::HapticDevice(std::unique_ptr<Driver> driver, const GuardSettings& settings)
    : impl_(std::make_unique<Impl>(std::move(driver), settings)) {}

HapticDevice::~HapticDevice() {
  Stop();
  impl_->driver->Halt();  // Opened, but never started.
}

const DeviceInfo& HapticDevice::info() const noexcept {
  return impl_->info;
}

void HapticDevice::Impl::BeginCounting() {
  ticks_before = num_ticks.load(std::memory_order_relaxed);
  warnings_before = num_warnings.load(std::memory_order_relaxed);
  guard_before = guard.counts();
  const std::lock_guard lock(mutex);
  num_reopened = 0;
  num_overruns = 0;
  text.clear();
}

void HapticDevice::Start(Servo servo) {
  Impl& me = *impl_;
  const bool is_parked = me.parked.load() && status().state != DeviceState::kFailed;
  if (me.parked.load() && !is_parked) Stop();
  ACUS_REQUIRE(!me.is_started || is_parked, me.info.name, ": is running already");
  me.servo = servo;
  me.BeginCounting();
  if (is_parked) {
    me.restarts_guard.store(true);
    me.parked.store(false);
    return;
  }
  if (!me.is_open) {
    OpenOrHalt(*me.driver);
    me.is_open = true;
  }
  me.guard.Restart();
  me.fault.store(0);
  me.tick_began_ns.store(0);
  me.last_tick_ns.store(MonotonicNs());
  me.stopping = false;
  RegisterForZero(me.driver.get());
  try {
    me.SetState(DeviceState::kRunning, "");
    me.driver->Run(me);
    me.is_started = true;
    if (!me.driver->IsStepped()) me.watchdog = std::thread([&me] { me.Watch(); });
  } catch (...) {
    me.is_started = true;
    Stop();
    throw;
  }
}

void HapticDevice::Park() noexcept {
  Impl& me = *impl_;
  if (!me.is_started || me.parked.exchange(true, std::memory_order_seq_cst)) return;
  const std::int64_t under_way_ns = me.tick_began_ns.load(std::memory_order_seq_cst);
  const auto is_under_way = [&] {
    return std::abs(me.tick_began_ns.load(std::memory_order_seq_cst)) == std::abs(under_way_ns);
  };
  while (under_way_ns != 0 && is_under_way()) {
    std::this_thread::sleep_for(std::chrono::microseconds(100));
  }
}

void HapticDevice::Stop() noexcept {
  Impl& me = *impl_;
  if (!me.is_started) return;
  {
    const std::lock_guard lock(me.mutex);
    me.stopping = true;
  }
  me.wake.notify_all();
  if (me.watchdog.joinable()) me.watchdog.join();
  me.driver->Halt();
  UnregisterForZero(me.driver.get());
  me.is_open = false;
  me.is_started = false;
  me.parked = false;
  const std::lock_guard lock(me.mutex);
  if (me.state != DeviceState::kFailed) me.state = DeviceState::kStopped;
}

DeviceStatus HapticDevice::status() const {
  const Impl& me = *impl_;
  DeviceStatus status;
  {
    const std::lock_guard lock(me.mutex);
    status.state = me.state;
    status.text = me.text;
    status.notices = me.notices;
    status.num_reopened = me.num_reopened;
    status.num_overruns = me.num_overruns;
  }
  status.ticks = me.num_ticks.load(std::memory_order_relaxed) - me.ticks_before;
  status.num_warnings = me.num_warnings.load(std::memory_order_relaxed) - me.warnings_before;
  status.longest_tick_ms =
      1e-6 * static_cast<double>(me.longest_tick_ns.load(std::memory_order_relaxed));
  status.guard = me.guard.counts();
  status.guard.ticks -= me.guard_before.ticks;
  for (std::size_t act = 0; act < kNumGuardActs; ++act) {
    status.guard.of[act] -= me.guard_before.of[act];
  }
  if (me.newest.num_stored() > 0) Unpack(me.newest.Load(), status.reading, status.force);
  return status;
}

void HapticDevice::SetInhibited(Inhibit reason, bool on) noexcept {
  const auto bit = static_cast<unsigned>(reason);
  if (on) {
    impl_->inhibited.fetch_or(bit, std::memory_order_acq_rel);
  } else {
    impl_->inhibited.fetch_and(~bit, std::memory_order_acq_rel);
  }
}

void HapticDevice::HoldPedal() noexcept {
  impl_->pedal_until_ns.store(MonotonicNs() + kPedalNs, std::memory_order_release);
}

}  // namespace acus::haptics
