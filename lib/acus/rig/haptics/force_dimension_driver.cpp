#include "acus/rig/haptics/force_dimension_driver.h"

#include <array>
#include <atomic>

#include "acus/base/core/error.h"
#include "acus/base/core/monotonic_time.h"
#include "acus/base/core/number_text.h"
#include "acus/base/core/shared_library.h"
#include "acus/rig/haptics/axes.h"
#include "acus/rig/haptics/dhd_api.h"
#include "acus/rig/haptics/real_time.h"

namespace acus::haptics {
namespace {

constexpr int kNoDevice = -1;
constexpr int kTicksPerStatus = 50;
constexpr unsigned char kWatchdogTicks = 25;  ///< In the device, of 4 ms or so each.

int SerialOf(const std::string& text) {
  const auto serial = ParseNumber<int>(text);
  ACUS_REQUIRE(serial && *serial >= 0,
               "Force Dimension SDK: a device is named by its serial number, not '", text, "'");
  return *serial;
}

/// Opens one device. @throws InputError
int OpenOne(const dhd::Api& api, const std::string& name) {
  const auto fail = [&api](const std::string& what) {
    throw InputError(Message("Force Dimension SDK: ", what, ": ", dhd::Text(api.ErrorGetLast())));
  };
  if (!name.empty()) {
    const int serial = SerialOf(name);
    ACUS_REQUIRE(api.OpenSerial != nullptr,
                 "Force Dimension SDK: this version cannot open a device by its serial number");
    const int id = api.OpenSerial(serial);
    if (id < 0) fail(Message("the device with serial number ", serial, " cannot be opened"));
    return id;
  }
  const int num_devices = api.GetDeviceCount();
  ACUS_REQUIRE(
      num_devices > 0, "Force Dimension SDK: ", dhd::Text(dhd::kErrorNoDevice),
      " May this user use it? The vendor's udev rule gives USB devices 1451 (and 0403:cb48",
      " for a Falcon) to the group plugdev");
  for (int i = 0; i < num_devices; ++i) {
    const int id = api.OpenId(static_cast<dhd::Id>(i));
    if (id >= 0) return id;
  }
  fail(Message("none of ", num_devices, " devices can be opened"));
  return kNoDevice;
}

class Device final : public Driver {
 public:
  explicit Device(const VendorOptions& options)
      : options_(options),
        axes_(options.axes.empty() ? "+y +z +x" : options.axes, "Force Dimension SDK"),
        api_(dhd::Load(options.library, options.timeout_s)) {}

  DeviceInfo Open() override;
  void Run(GuardedServo& servo) override;
  void Halt() noexcept override;
  void ZeroNow() noexcept override;
  std::string FaultText(int code) const override { return dhd::Text(code); }

 private:
  bool Tick() noexcept;
  DeviceReading Read(int& error) noexcept;
  int Write(const DeviceForce& force) const noexcept;
  int CheckStatus() noexcept;
  unsigned Buttons() const noexcept;
  void Keep(int result, int& error) const noexcept;

  VendorOptions options_;
  Axes axes_;
  dhd::Api api_;
  PatientCalls calls_;
  std::atomic<int> device_{kNoDevice};  ///< ZeroNow() may come from any thread.
  dhd::Model model_{};
  GuardedServo* servo_ = nullptr;
  int num_ticks_ = 0;
  bool motors_on_ = true;
  std::atomic<bool> output_is_off_{false};
  ServoThread thread_;

  dhd::Id id() const noexcept { return static_cast<dhd::Id>(device_.load()); }
};

DeviceInfo Device::Open() {
  const auto device = std::make_shared<int>(kNoDevice);
  calls_.Call("dhdOpen of Force Dimension", options_.timeout_s,
              [api = api_, name = options_.device, device] { *device = OpenOne(api, name); });
  device_ = *device;
  model_ = dhd::ModelOf(api_.GetSystemType(id()));
  unsigned short serial = 0;
  const bool has_serial =
      api_.GetSerialNumber != nullptr && api_.GetSerialNumber(&serial, id()) >= 0;
  if (api_.SetGravityCompensation != nullptr) api_.SetGravityCompensation(1, id());
  // A second line behind our own limits: the device lets go if this program is gone.
  if (api_.SetMaxForce != nullptr) api_.SetMaxForce(model_.max_force_n, id());
  if (api_.SetWatchdog != nullptr) api_.SetWatchdog(kWatchdogTicks, id());
  DeviceInfo info;
  info.name = has_serial ? Message(model_.name, " ", serial) : model_.name;
  info.max_force_n = model_.max_force_n;
  info.max_torque_nmm = api_.SetForceAndTorque != nullptr ? model_.max_torque_nmm : 0.0;
  info.rate_hz = options_.rate_hz;
  if (model_.has_wrist && api_.GetOrientationFrame == nullptr) {
    info.notices.push_back(info.name + ": this version of the SDK gives no orientation");
  }
  return info;
}

void Device::Run(GuardedServo& servo) {
  servo_ = &servo;
  num_ticks_ = 0;
  motors_on_ = true;
  output_is_off_ = false;
  ACUS_REQUIRE(
      api_.EnableForce(1, id()) >= 0,
      "Force Dimension SDK: forces cannot be switched on: ", dhd::Text(api_.ErrorGetLast()));
  const std::string notice = thread_.Start(
      options_.rate_hz, [](void* me) noexcept { return static_cast<Device*>(me)->Tick(); }, this);
  if (!notice.empty()) servo.Notice(notice);
}

/// Takes the error of a call, if it has one that matters more.
void Device::Keep(int result, int& error) const noexcept {
  int found = 0;
  if (result < 0) found = api_.ErrorGetLast();
  if (result < 0 && found == 0) found = dhd::kErrorCom;  // It failed and does not say why.
  if (result == dhd::kMotorSaturated) found = dhd::kOwnSaturated;
  if (dhd::KindOf(error) < dhd::KindOf(found)) error = found;
}

unsigned Device::Buttons() const noexcept {
  if (api_.GetButtonMask != nullptr) return api_.GetButtonMask(id());
  return api_.GetButton(0, id()) == 1 ? 1U : 0U;
}

DeviceReading Device::Read(int& error) noexcept {
  Eigen::Vector3d place_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d spin_rad_s = Eigen::Vector3d::Zero();
  std::array<double[3], 3> rows = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  int pose_error = 0;
  Keep(api_.GetPosition(&place_m.x(), &place_m.y(), &place_m.z(), id()), pose_error);
  if (model_.has_wrist && api_.GetOrientationFrame != nullptr) {
    Keep(api_.GetOrientationFrame(rows.data(), id()), pose_error);
  }
  error = pose_error;
  Keep(api_.GetLinearVelocity(&velocity_m_s.x(), &velocity_m_s.y(), &velocity_m_s.z(), id()),
       error);
  if (model_.has_wrist && api_.GetAngularVelocityRad != nullptr) {
    Keep(api_.GetAngularVelocityRad(&spin_rad_s.x(), &spin_rad_s.y(), &spin_rad_s.z(), id()),
         error);
  }
  const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> rotation(&rows[0][0]);
  DeviceReading reading;
  reading.time_ns = MonotonicNs();
  reading.device_from_handle = axes_.ToDevice(Eigen::Matrix3d(rotation), 1e3 * place_m);
  reading.velocity_mm_s = axes_.ToDevice(1e3 * velocity_m_s);
  reading.angular_velocity_rad_s = axes_.ToDevice(spin_rad_s);
  reading.buttons = Buttons();
  reading.motors_on = motors_on_;
  // A pose that could not be computed, or an error of communication in any call.
  reading.valid = pose_error != dhd::kErrorGeometry && dhd::KindOf(error) < DriverFault::kReopen;
  return reading;
}

int Device::Write(const DeviceForce& force) const noexcept {
  const Eigen::Vector3d f = axes_.ToVendor(force.force_n);
  if (model_.max_torque_nmm <= 0.0 || api_.SetForceAndTorque == nullptr) {
    return api_.SetForce(f.x(), f.y(), f.z(), id());
  }
  const Eigen::Vector3d t = 1e-3 * axes_.ToVendor(force.torque_nmm);
  return api_.SetForceAndTorque(f.x(), f.y(), f.z(), t.x(), t.y(), t.z(), id());
}

/// The device may have switched its motors off by itself.
int Device::CheckStatus() noexcept {
  std::array<int, dhd::kNumStatus> status{};
  if (api_.GetStatus == nullptr || api_.GetStatus(status.data(), id()) < 0) return 0;
  if (status[dhd::kStatusError] != 0) return dhd::kOwnStatusError;
  motors_on_ = status[dhd::kStatusForce] != 0;
  if (motors_on_) return 0;
  const int cause = status[dhd::kStatusForceOffCause];
  // What a person switched off, a person switches on. The guard ramps in when they are on again.
  if (cause != 1 && cause != 6) api_.EnableForce(1, id());
  return dhd::kOwnForceOff + cause;
}

bool Device::Tick() noexcept {
  int error = 0;
  if (num_ticks_++ % kTicksPerStatus == 0) error = CheckStatus();
  int read_error = 0;
  const DeviceReading reading = Read(read_error);
  const DeviceForce force = servo_->Tick(reading, &MonotonicNs);
  if (output_is_off_.exchange(false)) api_.EnableForce(1, id());
  Keep(Write(force), error);
  if (dhd::KindOf(error) < dhd::KindOf(read_error)) error = read_error;
  servo_->Report(dhd::KindOf(error), error);
  return dhd::KindOf(error) < DriverFault::kReopen;
}

void Device::ZeroNow() noexcept {
  if (device_ == kNoDevice) return;
  output_is_off_ = true;
  Write(DeviceForce());
  api_.EnableForce(0, id());
  // Again: the servo may have come in between, and switched the motors on before they were off.
  output_is_off_ = true;
}

void Device::Halt() noexcept {
  if (device_ == kNoDevice) return;
  thread_.Stop();
  Write(DeviceForce());
  api_.EnableForce(0, id());
  api_.Stop(id());
  api_.Close(id());
  device_ = kNoDevice;
}

}  // namespace

std::unique_ptr<Driver> ForceDimensionDriver(const VendorOptions& options) {
  return std::make_unique<Device>(options);
}

}  // namespace acus::haptics
