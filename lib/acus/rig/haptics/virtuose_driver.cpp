#include "acus/rig/haptics/virtuose_driver.h"

#include <array>
#include <atomic>

#include "acus/base/core/error.h"
#include "acus/base/core/monotonic_time.h"
#include "acus/base/core/shared_library.h"
#include "acus/rig/haptics/axes.h"
#include "acus/rig/haptics/callback_gate.h"
#include "acus/rig/haptics/virtuose_api.h"

namespace acus::haptics {
namespace {

constexpr double kMaxForceN = 30.0;
constexpr double kMaxTorqueNmm = 3000.0;
constexpr float kOwnLimitN = 30.0F;  ///< Of the device, behind ours.
constexpr float kOwnLimitNm = 3.0F;
constexpr int kTicksPerAlarm = 50;

virtuose::Context OpenAt(const virtuose::Api& api, const std::string& address) {
  virtuose::Context context = api.Open(address.c_str());
  ACUS_REQUIRE(context != nullptr, "VirtuoseAPI: no device at '", address,
               "': ", virtuose::Text(api.GetErrorCode(nullptr)),
               ". Is the device switched on, and its service running?");
  return context;
}

class Device final : public Driver {
 public:
  explicit Device(const VendorOptions& options)
      : options_(options),
        axes_(options.axes.empty() ? "+y +z +x" : options.axes, "VirtuoseAPI"),
        api_(virtuose::Load(options.library, options.timeout_s)) {}

  DeviceInfo Open() override;
  void Run(GuardedServo& servo) override;
  void Halt() noexcept override;
  void ZeroNow() noexcept override;
  std::string FaultText(int code) const override { return virtuose::Text(code); }

 private:
  void Must(int result, const char* what) const;
  /// The vendor's loop continues calling after an error, until it is stopped.
  static void OnTick(virtuose::Context, void* me) {
    auto* const device = static_cast<Device*>(me);
    device->gate_.Pass([device]() noexcept { return device->Tick(); });
  }
  bool Tick() noexcept;
  DeviceReading Read(int& error) noexcept;
  int CheckMotors() noexcept;
  int Write(const DeviceForce& force) const noexcept;
  void Keep(int result, int& error) const noexcept;

  VendorOptions options_;
  Axes axes_;
  virtuose::Api api_;
  PatientCalls calls_;
  std::atomic<virtuose::Context> context_{nullptr};  ///< ZeroNow() may come from any thread.
  GuardedServo* servo_ = nullptr;
  float period_s_ = 0.001F;
  bool loops_ = false;
  bool was_stopped_ = false;
  int num_ticks_ = 0;
  CallbackGate gate_;
  std::atomic<bool> output_is_off_{false};
};

void Device::Must(int result, const char* what) const {
  ACUS_REQUIRE(result == 0, "VirtuoseAPI: ", what, ": ",
               virtuose::Text(api_.GetErrorCode(context_.load())));
}

DeviceInfo Device::Open() {
  const std::string address = options_.device.empty() ? "127.0.0.1#53210" : options_.device;
  const auto context = std::make_shared<virtuose::Context>(nullptr);
  calls_.Call("virtOpen of VirtuoseAPI", options_.timeout_s,
              [api = api_, address, context] { *context = OpenAt(api, address); });
  context_ = *context;
  period_s_ = static_cast<float>(1.0 / options_.rate_hz);
  std::array<float, 7> at_base = {0, 0, 0, 0, 0, 0, 1};
  Must(api_.SetIndexingMode(context_, virtuose::kNoIndexing), "virtSetIndexingMode");
  Must(api_.SetSpeedFactor(context_, 1.0F), "virtSetSpeedFactor");
  Must(api_.SetTimeStep(context_, period_s_), "virtSetTimeStep");
  Must(api_.SetBaseFrame(context_, at_base.data()), "virtSetBaseFrame");
  Must(api_.SetCommandType(context_, virtuose::kImpedance), "virtSetCommandType");
  Must(api_.SetForceFactor(context_, 1.0F), "virtSetForceFactor");
  // The device lets go if nothing is heard from this program.
  if (api_.SetTimeoutValue != nullptr) api_.SetTimeoutValue(context_, 0.1F);
  int type = 0;
  int serial = 0;
  const bool has_id =
      api_.GetDeviceId != nullptr && api_.GetDeviceId(context_, &type, &serial) == 0;
  DeviceInfo info;
  info.name = has_id ? Message("Virtuose ", serial) : "Virtuose";
  info.max_force_n = kMaxForceN;
  info.max_torque_nmm = kMaxTorqueNmm;
  info.rate_hz = options_.rate_hz;
  return info;
}

void Device::Run(GuardedServo& servo) {
  servo_ = &servo;
  gate_.Open();
  output_is_off_ = false;
  was_stopped_ = false;
  num_ticks_ = 0;
  Must(api_.SetPowerOn(context_, 1), "virtSetPowerOn");
  Must(api_.SetPeriodicFunction(context_, &Device::OnTick, &period_s_, this),
       "virtSetPeriodicFunction");
  if (api_.SaturateTorque != nullptr) api_.SaturateTorque(context_, kOwnLimitN, kOwnLimitNm);
  Must(api_.StartLoop(context_), "virtStartLoop");
  loops_ = true;
}

void Device::Keep(int result, int& error) const noexcept {
  if (result == 0) return;
  int found = api_.GetErrorCode(context_);
  if (found == 0) found = virtuose::kCommunicationFailure;  // It failed and does not say why.
  if (virtuose::KindOf(error) < virtuose::KindOf(found)) error = found;
}

/// The emergency stop, the dead-man switch of the handle, and alarms.
int Device::CheckMotors() noexcept {
  int is_stopped = 0;
  int dead_man = 1;
  int error = 0;
  Keep(api_.GetEmergencyStop(context_, &is_stopped), error);
  Keep(api_.GetDeadMan(context_, &dead_man), error);
  if (error != 0) return error;
  if (is_stopped != 0) {
    was_stopped_ = true;
    return virtuose::kOwnEmergencyStop;
  }
  if (was_stopped_) {
    was_stopped_ = false;
    api_.SetPowerOn(context_, 1);
  }
  if (dead_man == 0) return virtuose::kOwnDeadMan;
  unsigned alarm = 0;
  if (num_ticks_++ % kTicksPerAlarm != 0 || api_.GetAlarm == nullptr) return 0;
  if (api_.GetAlarm(context_, &alarm) != 0) return 0;
  if ((alarm & virtuose::kOverheat) != 0) return virtuose::kOwnOverheat;
  return (alarm & virtuose::kSaturate) != 0 ? virtuose::kOwnSaturated : 0;
}

DeviceReading Device::Read(int& error) noexcept {
  std::array<float, 7> pose{};
  std::array<float, 6> speed{};
  int pose_error = 0;
  Keep(api_.GetPosition(context_, pose.data()), pose_error);
  error = pose_error;
  Keep(api_.GetSpeed(context_, speed.data()), error);
  DeviceReading reading;
  reading.time_ns = MonotonicNs();
  for (int i = 0; i < virtuose::kNumButtons; ++i) {
    int is_held = 0;
    if (api_.GetButton(context_, i, &is_held) == 0 && is_held != 0) reading.buttons |= 1U << i;
  }
  const Eigen::Map<const Eigen::Vector3f> place_m(pose.data());
  const Eigen::Quaterniond rotation(pose[6], pose[3], pose[4], pose[5]);
  // A quaternion is no rotation unless its length is about 1; the guard refuses the zero matrix.
  const bool is_unit = std::abs(rotation.squaredNorm() - 1.0) < 0.05;
  reading.device_from_handle =
      axes_.ToDevice(is_unit ? rotation.normalized().toRotationMatrix() : Eigen::Matrix3d::Zero(),
                     1e3 * place_m.cast<double>());
  const Eigen::Map<const Eigen::Matrix<float, 3, 2>> speeds(speed.data());
  reading.velocity_mm_s = axes_.ToDevice(1e3 * speeds.col(0).cast<double>());
  reading.angular_velocity_rad_s = axes_.ToDevice(speeds.col(1).cast<double>());
  reading.valid = pose_error == 0 && virtuose::KindOf(error) < DriverFault::kReopen;
  return reading;
}

int Device::Write(const DeviceForce& force) const noexcept {
  Eigen::Matrix<float, 3, 2> wrench;
  wrench.col(0) = axes_.ToVendor(force.force_n).cast<float>();
  wrench.col(1) = (1e-3 * axes_.ToVendor(force.torque_nmm)).cast<float>();
  return api_.SetForce(context_, wrench.data());
}

bool Device::Tick() noexcept {
  if (gate_.is_last()) {
    Write(DeviceForce());
    return false;
  }
  int error = CheckMotors();
  int read_error = 0;
  DeviceReading reading = Read(read_error);
  reading.motors_on = error != virtuose::kOwnEmergencyStop && error != virtuose::kOwnDeadMan;
  if (virtuose::KindOf(error) >= DriverFault::kReopen) reading.valid = false;
  const DeviceForce force = servo_->Tick(reading, &MonotonicNs);
  if (output_is_off_.exchange(false)) api_.SetPowerOn(context_, 1);
  if (virtuose::KindOf(error) < virtuose::KindOf(read_error)) error = read_error;
  Keep(Write(force), error);
  servo_->Report(virtuose::KindOf(error), error);
  return virtuose::KindOf(error) < DriverFault::kReopen;
}

void Device::ZeroNow() noexcept {
  if (context_ == nullptr) return;
  output_is_off_ = true;
  Write(DeviceForce());
  api_.SetPowerOn(context_, 0);
  // Again: the servo may have come in between, and switched the motors on before they were off.
  output_is_off_ = true;
}

void Device::Halt() noexcept {
  if (context_ == nullptr) return;
  if (loops_) {
    if (!gate_.AwaitLastTick()) ZeroNow();
    api_.StopLoop(context_);
    gate_.AwaitNobodyInside();
    loops_ = false;
  }
  Write(DeviceForce());
  api_.SetPowerOn(context_, 0);
  api_.Close(context_);
  context_ = nullptr;
}

}  // namespace

std::unique_ptr<Driver> VirtuoseDriver(const VendorOptions& options) {
  return std::make_unique<Device>(options);
}

}  // namespace acus::haptics
