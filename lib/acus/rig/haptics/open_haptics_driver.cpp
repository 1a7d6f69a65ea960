// Order of calls: docs/concepts/haptic_devices.md. Forces leave only from a frame within a callback
// of the vendor's scheduler, which is the servo thread.
#include "acus/rig/haptics/open_haptics_driver.h"

#include <array>
#include <atomic>
#include <cmath>
#include <mutex>

#include "acus/base/core/error.h"
#include "acus/base/core/monotonic_time.h"
#include "acus/base/core/shared_library.h"
#include "acus/rig/haptics/axes.h"
#include "acus/rig/haptics/callback_gate.h"
#include "acus/rig/haptics/hd_api.h"
#include "acus/rig/haptics/hd_errors.h"

namespace acus::haptics {
namespace {

using hd::kNoDevice;

constexpr double kSafeForceN = 3.3;  ///< Of the weakest device, if one does not say.
constexpr double kMostTorqueNmm = 188.0;

/// The vendor's scheduler, one for all devices.
class Scheduler {
 public:
  void Start(const hd::Api& api) {
    const std::lock_guard lock(mutex_);
    if (num_running_++ == 0) api.StartScheduler();
  }
  void Stop(const hd::Api& api) {
    const std::lock_guard lock(mutex_);
    if (--num_running_ == 0) api.StopScheduler();
  }

 private:
  std::mutex mutex_;
  int num_running_ = 0;
};

Scheduler& TheScheduler() {
  static Scheduler* scheduler = new Scheduler;  // Devices may outlive static objects.
  return *scheduler;
}

class Device final : public Driver {
 public:
  explicit Device(const VendorOptions& options)
      : options_(options),
        axes_(options.axes.empty() ? "+x +y +z" : options.axes, "OpenHaptics"),
        api_(hd::Load(options.library, options.timeout_s)) {}

  DeviceInfo Open() override;
  void Run(GuardedServo& servo) override;
  void Halt() noexcept override;
  void ZeroNow() noexcept override;
  std::string FaultText(int code) const override {
    return hd::Text(api_, static_cast<unsigned>(code));
  }

 private:
  void Calibrate() const;
  DeviceInfo Describe() const;
  static unsigned OnTick(void* me) {
    auto* const device = static_cast<Device*>(me);
    const bool goes_on = device->gate_.Pass([device]() noexcept { return device->Tick(); });
    return goes_on ? hd::kContinue : hd::kDone;
  }
  bool Tick() noexcept;
  DeviceReading Read() const noexcept;
  void Write(const DeviceForce& force) noexcept;

  VendorOptions options_;
  Axes axes_;
  hd::Api api_;
  PatientCalls calls_;
  std::atomic<unsigned> device_{kNoDevice};  ///< ZeroNow() may come from any thread.
  bool has_torque_ = false;
  GuardedServo* servo_ = nullptr;
  unsigned long callback_ = 0;
  bool is_scheduled_ = false;
  bool uses_scheduler_ = false;
  CallbackGate gate_;
  std::atomic<bool> output_is_off_{false};  ///< By ZeroNow().
};

void Device::Calibrate() const {
  unsigned state = api_.CheckCalibration();
  const unsigned style = api_.CheckCalibrationStyle != nullptr ? api_.CheckCalibrationStyle() : 2;
  if (state == hd::kNeedsUpdate) {
    api_.UpdateCalibration(style);
    state = api_.CheckCalibration();
  }
  ACUS_REQUIRE(state != hd::kNeedsHand && state != hd::kNeedsUpdate,
               "OpenHaptics: the device must be calibrated: ",
               (style & hd::kInkwellStyle) != 0 ? "put the stylus into its inkwell"
                                                : "run the vendor's diagnostic program",
               ", and start again");
}

DeviceInfo Device::Describe() const {
  DeviceInfo info;
  const char* model = api_.GetString != nullptr ? api_.GetString(hd::kDeviceModel) : nullptr;
  const char* serial = api_.GetString != nullptr ? api_.GetString(hd::kSerialNumber) : nullptr;
  info.name = model != nullptr ? model : "OpenHaptics device";
  if (serial != nullptr) info.name += Message(" ", serial);
  double force_n = 0.0;
  api_.GetDoublev(hd::kMaxForce, &force_n);
  info.max_force_n = std::isfinite(force_n) && force_n > 0.0 ? force_n : kSafeForceN;
  info.max_torque_nmm = has_torque_ ? kMostTorqueNmm : 0.0;
  std::array<double, 6> box{};
  api_.GetDoublev(hd::kUsableWorkspace, box.data());
  const Eigen::Vector3d low = axes_.ToDevice(Eigen::Vector3d(box[0], box[1], box[2]));
  const Eigen::Vector3d high = axes_.ToDevice(Eigen::Vector3d(box[3], box[4], box[5]));
  if (low.allFinite() && high.allFinite()) {
    info.workspace_mm = Eigen::AlignedBox3d(low.cwiseMin(high), low.cwiseMax(high));
  }
  return info;
}

DeviceInfo Device::Open() {
  const auto device = std::make_shared<unsigned>(kNoDevice);
  calls_.Call(
      "hdInitDevice of OpenHaptics", options_.timeout_s,
      [api = api_, name = options_.device, device] { *device = hd::OpenDevice(api, name); });
  device_ = *device;
  api_.MakeCurrentDevice(device_);
  Calibrate();
  int output_dof = 3;
  api_.GetIntegerv(hd::kOutputDof, &output_dof);
  has_torque_ = output_dof >= 6;
  const DeviceInfo info = Describe();
  hd::DrainErrors(api_);  // Of values that this device does not have.
  return info;
}

void Device::Run(GuardedServo& servo) {
  servo_ = &servo;
  gate_.Open();
  output_is_off_ = false;
  api_.MakeCurrentDevice(device_);
  // The device's own limits are a second line behind ours.
  for (const unsigned capability :
       {hd::kForceOutput, hd::kForceClamping, hd::kSoftwareForceLimit, hd::kForceRamping}) {
    api_.Enable(capability);
  }
  hd::DrainErrors(api_);
  callback_ = api_.ScheduleAsynchronous(&Device::OnTick, this, hd::kMostPriority);
  const unsigned error = hd::DrainErrors(api_);
  if (hd::KindOf(error) >= DriverFault::kReopen || callback_ == 0) {
    gate_.Shut();
    throw InputError("OpenHaptics: " + hd::Text(api_, error != 0 ? error : hd::kNoCallback));
  }
  is_scheduled_ = true;
  TheScheduler().Start(api_);
  uses_scheduler_ = true;
}

DeviceReading Device::Read() const noexcept {
  std::array<double, 16> transform{};
  std::array<double, 3> velocity{};
  std::array<double, 3> spin{};
  int buttons = 0;
  api_.GetDoublev(hd::kCurrentTransform, transform.data());
  api_.GetDoublev(hd::kCurrentVelocity, velocity.data());
  api_.GetDoublev(hd::kCurrentAngularVelocity, spin.data());
  api_.GetIntegerv(hd::kCurrentButtons, &buttons);
  const Eigen::Map<const Eigen::Matrix4d> matrix(transform.data());
  DeviceReading reading;
  reading.time_ns = MonotonicNs();
  reading.device_from_handle =
      axes_.ToDevice(Eigen::Matrix3d(matrix.topLeftCorner<3, 3>()), matrix.topRightCorner<3, 1>());
  reading.velocity_mm_s = axes_.ToDevice(Eigen::Map<const Eigen::Vector3d>(velocity.data()));
  reading.angular_velocity_rad_s = axes_.ToDevice(Eigen::Map<const Eigen::Vector3d>(spin.data()));
  reading.buttons = static_cast<unsigned>(buttons);
  reading.valid = true;
  return reading;
}

void Device::Write(const DeviceForce& force) noexcept {
  const Eigen::Vector3d force_n = axes_.ToVendor(force.force_n);
  api_.SetDoublev(hd::kCurrentForce, force_n.data());
  if (!has_torque_) return;
  const Eigen::Vector3d torque_nmm = axes_.ToVendor(force.torque_nmm);
  api_.SetDoublev(hd::kCurrentTorque, torque_nmm.data());
}

/// One frame. False if the device is not to be called again.
bool Device::Tick() noexcept {
  api_.MakeCurrentDevice(device_);
  api_.BeginFrame(device_);
  DeviceReading reading = Read();
  // The numbers of a frame with an error are not to be trusted; a warning is no such error.
  unsigned error = hd::DrainErrors(api_);
  reading.valid = hd::KindOf(error) < DriverFault::kReopen;
  if (gate_.is_last()) {
    Write(DeviceForce());
    api_.EndFrame(device_);
    return false;
  }
  const DeviceForce force = servo_->Tick(reading, &MonotonicNs);
  if (output_is_off_.exchange(false, std::memory_order_acq_rel)) api_.Enable(hd::kForceOutput);
  Write(force);
  api_.EndFrame(device_);
  const unsigned late_error = hd::DrainErrors(api_);
  if (hd::KindOf(error) < hd::KindOf(late_error)) error = late_error;
  servo_->Report(hd::KindOf(error), static_cast<int>(error));
  return hd::KindOf(error) < DriverFault::kReopen;
}

void Device::ZeroNow() noexcept {
  const unsigned device = device_;
  if (device == kNoDevice) return;
  output_is_off_.store(true, std::memory_order_release);
  api_.MakeCurrentDevice(device);
  api_.Disable(hd::kForceOutput);
  // Again: the servo may have come in between, and switched the motors on before they were off.
  output_is_off_.store(true, std::memory_order_release);
}

void Device::Halt() noexcept {
  if (device_ == kNoDevice) return;
  if (is_scheduled_) {
    // The callback sends a last zero and ends by itself, if it is still called.
    if (!gate_.AwaitLastTick()) ZeroNow();
    api_.Unschedule(callback_);
    gate_.AwaitNobodyInside();
    is_scheduled_ = false;
  }
  if (uses_scheduler_) TheScheduler().Stop(api_);
  uses_scheduler_ = false;
  api_.MakeCurrentDevice(device_);
  api_.Disable(hd::kForceOutput);
  api_.DisableDevice(device_);
  hd::DrainErrors(api_);
  device_ = kNoDevice;
}

}  // namespace

std::unique_ptr<Driver> OpenHapticsDriver(const VendorOptions& options) {
  return std::make_unique<Device>(options);
}

}  // namespace acus::haptics
