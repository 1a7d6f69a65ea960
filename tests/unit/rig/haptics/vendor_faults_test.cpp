// Every driver against its stand-in library, which is loaded for real, and breaks in every way that
// is listed in tests/support/vendor_faults.cpp.
#include "support/vendor_faults.h"

#include <chrono>
#include <fstream>
#include <functional>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <map>
#include <thread>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "acus/rig/haptics/open_device.h"
#include "support/stand_in.h"

namespace acus::haptics {
namespace {

using testing::HasSubstr;
using testing_support::Outcome;
using testing_support::StandIn;
using testing_support::VendorFault;

constexpr double kSlewNPerS = 20.0;
constexpr double kPatientS = 0.05;  ///< On a busy machine, lateness is a fault of its own.

/// Long for a loaded machine; what is waited for comes within some 0.3 s.
bool VendorFaultsWaitFor(const std::function<bool()>& condition) {
  for (int i = 0; i < 10'000; ++i) {
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(3));
  }
  return false;
}

/// Asks for 100 times the force that is allowed.
DeviceForce AskForTooMuch(void*, const DeviceReading&) noexcept {
  return {.force_n = {180, 240, 0}, .torque_nmm = {0, 0, 9000}};
}

DeviceConfig Config(const VendorFault& fault, const StandIn& library) {
  DeviceConfig config = library.Config(fault.driver);
  config.safety.ramp_in_s = 0.1;
  config.safety.settle_s = 0.02;
  config.safety.force_slew_n_per_s = kSlewNPerS;
  const bool is_about_time = fault.act == GuardAct::kReadingLate;
  config.safety.late_s = is_about_time ? GuardSettings().late_s : kPatientS;
  if (fault.needs_button) config.safety.dead_man = DeadMan::kButton;
  const bool hangs = std::string(fault.faults).find("hang") != std::string::npos;
  config.vendor.timeout_s = hangs ? 1.0 : 20.0;
  return config;
}

struct Calls {
  const char* stop;
  const char* close;
};
Calls CallsOf(DriverKind driver) {
  switch (driver) {
    case DriverKind::kOpenHaptics:
      return {"hdStopScheduler", "hdDisableDevice"};
    case DriverKind::kForceDimension:
      return {"dhdStop", "dhdClose"};
    default:
      return {"virtStopLoop", "virtClose"};
  }
}

/// Whatever happened: what the motors got, and how it ended.
void ExpectSafe(const VendorFault& fault, const StandIn& library) {
  EXPECT_EQ(library.Value("not_finite"), 0.0);
  EXPECT_LE(library.Value("max_n"), 3.0 + 1e-6);
  EXPECT_LE(library.Value("max_nm"), 0.1 + 1e-6);
  // The longest time that the guard allows between two forces.
  EXPECT_LE(library.Value("max_rise_n"), kSlewNPerS * kPatientS + 1e-6);
  EXPECT_EQ(library.Value("last_n"), 0.0);
  EXPECT_EQ(library.Value("motors_on"), 0.0);
  EXPECT_EQ(library.Value("is_open"), 0.0);
  EXPECT_EQ(library.Value("pushes_when_closed"), 0.0);
  const std::string log = library.Log();
  const Calls calls = CallsOf(fault.driver);
  if (library.Value("opened") == 0.0) return;
  const auto last_open = log.rfind("opened\n");
  const auto close = log.rfind(calls.close);
  ASSERT_NE(close, log.npos) << log;
  EXPECT_GT(close, last_open) << log;
  if (library.Value("max_n") == 0.0) return;
  // Zero (or no power at all), then the scheduler, then the device.
  const auto stop = log.rfind(calls.stop);
  const auto last_before_stop = [&](const char* call) {
    const auto found = log.rfind(call, stop);
    return found == log.npos ? 0 : found + 1;
  };
  const auto zero = std::max(last_before_stop("force zero"), last_before_stop("motors off"));
  EXPECT_GT(zero, log.rfind("force on") + 1) << log;
  EXPECT_GT(close, stop) << log;
}

/// Whether a device that was started has come to its outcome.
bool HasCome(const VendorFault& fault, const DeviceStatus& status, const StandIn& library) {
  if (fault.act && status.guard[*fault.act] == 0) return false;
  if (status.text.find(fault.says) == std::string::npos) return false;
  const bool pushes = library.Value("last_n") > 1.0;
  switch (fault.outcome) {
    case Outcome::kRunsOn: {
      // Long enough for the fault and for the ramp after it.
      return status.state == DeviceState::kRunning && pushes && library.Value("ticks") > 450.0;
    }
    case Outcome::kReopened:
      return status.state == DeviceState::kRunning && pushes && status.num_reopened >= 1;
    case Outcome::kKeepsTrying:
      return status.state == DeviceState::kRecovering &&
             status.text.find("opening it again") != std::string::npos;
    case Outcome::kEnds:
      return status.state == DeviceState::kFailed;
    case Outcome::kNoForce:
      return library.Value("ticks") > 450.0;
    case Outcome::kRefused:
      return false;
  }
  return false;
}

class VendorFaults : public testing::TestWithParam<VendorFault> {};

TEST_P(VendorFaults, EndsAsTheTableSaysAndIsAlwaysSafe) {
  const VendorFault& fault = GetParam();
  const StandIn library(fault.variant, fault.faults);
  const DeviceConfig config = Config(fault, library);
  if (fault.outcome == Outcome::kRefused) {
    EXPECT_THAT([&] { OpenDevice(config)->Start({.tick = &AskForTooMuch, .context = nullptr}); },
                testing::ThrowsMessage<InputError>(HasSubstr(fault.says)));
    EXPECT_EQ(library.Value("max_n"), 0.0);
    ExpectSafe(fault, library);
    return;
  }
  const auto device = OpenDevice(config);
  device->Start({.tick = &AskForTooMuch, .context = nullptr});
  const bool has_come =
      VendorFaultsWaitFor([&] { return HasCome(fault, device->status(), library); });
  const DeviceStatus status = device->status();
  EXPECT_TRUE(has_come) << "state " << static_cast<int>(status.state) << ", " << status.text
                        << ", force " << library.Value("last_n") << "\n"
                        << library.Log();
  if (fault.outcome == Outcome::kNoForce) {
    EXPECT_EQ(library.Value("max_n"), 0.0);
  }
  if (fault.outcome == Outcome::kKeepsTrying || fault.outcome == Outcome::kEnds) {
    EXPECT_EQ(library.Value("last_n"), 0.0);
    EXPECT_EQ(library.Value("motors_on"), 0.0);
  }
  if (fault.outcome == Outcome::kRunsOn && fault.act && *fault.act != GuardAct::kDeadManOpen) {
    EXPECT_THAT(library.Log(), HasSubstr("force on\nforce zero\nforce on"));
  }
  device->Stop();
  ExpectSafe(fault, library);
}

std::string VendorFaultsNameOf(const testing::TestParamInfo<VendorFault>& info) {
  const std::map<DriverKind, std::string> products = {{DriverKind::kOpenHaptics, "OpenHaptics"},
                                                      {DriverKind::kForceDimension, "Dhd"},
                                                      {DriverKind::kVirtuose, "Virtuose"}};
  return products.at(info.param.driver) + "_" + info.param.name;
}

INSTANTIATE_TEST_SUITE_P(All, VendorFaults, testing::ValuesIn(testing_support::VendorFaults()),
                         VendorFaultsNameOf);

TEST(VendorFaultTable, IsThatOfTheDocumentation) {
  const std::filesystem::path page =
      std::filesystem::path(ACUS_SOURCE_DIR) / "docs" / "concepts" / "haptic_devices.md";
  const std::string begin = "<!-- faults: made by tests/support/vendor_faults.cpp -->\n";
  const std::string end = "<!-- end of faults -->\n";
  std::string text = ReadTextFile(page);
  const auto first = text.find(begin);
  const auto last = text.find(end);
  ASSERT_TRUE(first != text.npos && last != text.npos);
  const std::string table = testing_support::VendorFaultTable();
  if (std::getenv("ACUS_WRITE_DOCS") != nullptr) {
    text.replace(first + begin.size(), last - first - begin.size(), table);
    std::ofstream(page) << text;
    return;
  }
  EXPECT_EQ(text.substr(first + begin.size(), last - first - begin.size()), table)
      << "run this test with ACUS_WRITE_DOCS=1";
}

}  // namespace
}  // namespace acus::haptics
