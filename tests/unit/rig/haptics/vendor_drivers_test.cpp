// Frames, units, the watchdog, and the ways a process can end, with the stand-in libraries.
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <thread>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "acus/rig/haptics/open_device.h"
#include "acus/rig/haptics/real_time.h"
#include "acus/rig/haptics/zero_forces.h"
#include "support/stand_in.h"

namespace acus::haptics {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;
using testing::HasSubstr;
using testing_support::StandIn;

struct Vendor {
  const char* variant;
  DriverKind driver;
  const char* stop;
};
void PrintTo(const Vendor& vendor, std::ostream* out) {
  *out << vendor.variant;
}

std::string NameOf(const testing::TestParamInfo<Vendor>& info) {
  return info.param.variant;
}

bool WaitFor(const std::function<bool()>& condition) {
  for (int i = 0; i < 10'000; ++i) {
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(3));
  }
  return false;
}

DeviceConfig VendorDriversQuick(const StandIn& library, DriverKind driver) {
  DeviceConfig config = library.Config(driver);
  config.safety.ramp_in_s = 0.02;
  config.safety.settle_s = 0.0;
  config.vendor.timeout_s = 20.0;
  return config;
}

DeviceForce PushSideways(void*, const DeviceReading&) noexcept {
  return {.force_n = {0.5, 1.0, -1.5}, .torque_nmm = {10, 20, -30}};
}

class VendorDrivers : public testing::TestWithParam<Vendor> {};

TEST_P(VendorDrivers, ReadInTheDeviceFrame) {
  const StandIn library(GetParam().variant, "");
  const auto device = OpenDevice(VendorDriversQuick(library, GetParam().driver));
  EXPECT_GT(device->info().max_force_n, 3.0);
  EXPECT_THAT(device->info().name, HasSubstr("815"));
  device->Start({.tick = [](void*, const DeviceReading&) noexcept { return DeviceForce(); },
                 .context = nullptr});
  ASSERT_TRUE(WaitFor([&] { return device->status().ticks > 200; }));
  const DeviceReading reading = device->status().reading;
  device->Stop();
  // The arm is at x = 10 + 5 sin(2 t), y = 20, z = 30 mm, and turned by 0.3 sin(t) about y.
  const Vector3d place_mm = reading.device_from_handle.translation();
  EXPECT_TRUE(reading.valid);
  EXPECT_NEAR(place_mm.y(), 20.0, 1e-4);
  EXPECT_NEAR(place_mm.z(), 30.0, 1e-4);
  const double t = 0.5 * std::asin((place_mm.x() - 10.0) / 5.0);
  EXPECT_GT(t, 0.15);
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(0.3 * std::sin(t), Vector3d::UnitY()).toRotationMatrix();
  EXPECT_LT((reading.device_from_handle.linear() - turn).norm(), 1e-4);
  EXPECT_LT((reading.velocity_mm_s - Vector3d(10.0 * std::cos(2.0 * t), 0, 0)).norm(), 1e-2);
}

TEST_P(VendorDrivers, PushInTheDeviceFrame) {
  const StandIn library(GetParam().variant, "");
  const auto device = OpenDevice(VendorDriversQuick(library, GetParam().driver));
  device->Start({.tick = &PushSideways, .context = nullptr});
  ASSERT_TRUE(WaitFor([&] { return library.Value("last_n") > 1.87; }));
  device->Stop();
  EXPECT_NEAR(library.Value("fx_n"), 0.5, 1e-6);
  EXPECT_NEAR(library.Value("fy_n"), 1.0, 1e-6);
  EXPECT_NEAR(library.Value("fz_n"), -1.5, 1e-6);
  EXPECT_NEAR(library.Value("tx_nm"), 0.010, 1e-8);
  EXPECT_NEAR(library.Value("ty_nm"), 0.020, 1e-8);
  EXPECT_NEAR(library.Value("tz_nm"), -0.030, 1e-8);
  // The arm gave way: 0.5 N against 400 N/m.
  EXPECT_GT(library.Value("place_x_mm"), 10.0);
}

TEST_P(VendorDrivers, ParkedStayOpenWithoutForceUntilTheNextServo) {
  const StandIn library(GetParam().variant, "");
  const auto device = OpenDevice(VendorDriversQuick(library, GetParam().driver));
  std::atomic<int> num_ticks{0};
  const Servo servo{.tick =
                        [](void* context, const DeviceReading& reading) noexcept {
                          ++*static_cast<std::atomic<int>*>(context);
                          return PushSideways(nullptr, reading);
                        },
                    .context = &num_ticks};
  device->Start(servo);
  ASSERT_TRUE(WaitFor([&] { return library.Value("last_n") > 1.87; }));

  device->Park();
  const int ticks_when_parked = num_ticks;
  ASSERT_TRUE(WaitFor([&] { return library.Value("last_n") == 0.0; }));
  const auto readings = device->status().ticks;
  ASSERT_TRUE(WaitFor([&] { return device->status().ticks > readings + 100; }));
  EXPECT_EQ(num_ticks, ticks_when_parked) << "the servo may be gone";
  EXPECT_EQ(library.Value("last_n"), 0.0);
  EXPECT_EQ(device->status().state, DeviceState::kRunning);

  const std::int64_t before = device->status().ticks;
  device->Start(servo);
  EXPECT_LT(device->status().ticks, before) << "counts begin anew";
  ASSERT_TRUE(WaitFor([&] { return library.Value("last_n") > 1.87; }));
  EXPECT_GT(num_ticks, ticks_when_parked);
  const DeviceStatus status = device->status();
  EXPECT_LE(std::abs(status.guard.ticks - status.ticks), 2) << "of this start only";
  EXPECT_EQ(status.num_reopened, 0);
  EXPECT_EQ(library.Value("opened"), 1.0) << "it is not opened again";
  EXPECT_THROW(device->Start(servo), InputError) << "it runs";
  device->Stop();
  EXPECT_EQ(device->status().state, DeviceState::kStopped);
}

TEST_P(VendorDrivers, ThatFailedWhileParkedAreOpenedAnew) {
  const StandIn library(GetParam().variant, "");
  const auto device = OpenDevice(VendorDriversQuick(library, GetParam().driver));
  device->Start({.tick = &PushSideways, .context = nullptr});
  ASSERT_TRUE(WaitFor([&] { return device->status().ticks > 50; }));
  device->Park();
  // The watchdog mends it, session or not.
  library.Set("unplugged", 1);
  ASSERT_TRUE(WaitFor([&] { return device->status().state == DeviceState::kRecovering; }));
  library.Set("unplugged", 1e9);
  ASSERT_TRUE(WaitFor([&] { return device->status().num_reopened >= 1; }));
  EXPECT_EQ(library.Value("last_n"), 0.0);
  device->Start({.tick = &PushSideways, .context = nullptr});
  EXPECT_TRUE(WaitFor([&] { return library.Value("last_n") > 1.87; }));
}

TEST_P(VendorDrivers, StandAnotherWayRoundIfTheFileSaysSo) {
  const StandIn library(GetParam().variant, "");
  DeviceConfig config = VendorDriversQuick(library, GetParam().driver);
  // Turned by half a turn about the vertical: right is left, to the user is away.
  config.vendor.axes = GetParam().driver == DriverKind::kOpenHaptics ? "-x +y -z" : "-y +z -x";
  const auto device = OpenDevice(config);
  device->Start({.tick = &PushSideways, .context = nullptr});
  ASSERT_TRUE(WaitFor([&] { return library.Value("last_n") > 1.87; }));
  const Vector3d place_mm = device->status().reading.device_from_handle.translation();
  device->Stop();
  EXPECT_LT(place_mm.x(), -8.0);
  EXPECT_LT(place_mm.z(), -28.0);
  EXPECT_NEAR(library.Value("fx_n"), -0.5, 1e-6);
  EXPECT_NEAR(library.Value("fy_n"), 1.0, 1e-6);
  EXPECT_NEAR(library.Value("fz_n"), 1.5, 1e-6);
}

TEST_P(VendorDrivers, AStepThatDoesNotComeBackIsCutOff) {
  const StandIn library(GetParam().variant, "");
  const auto device = OpenDevice(VendorDriversQuick(library, GetParam().driver));
  struct Stuck {
    std::atomic<int> num_ticks{0};
    std::atomic<bool> lets_go{false};
  } stuck;
  device->Start({.tick =
                     [](void* context, const DeviceReading& reading) noexcept {
                       auto& me = *static_cast<Stuck*>(context);
                       if (++me.num_ticks == 150) {
                         while (!me.lets_go) {
                           std::this_thread::sleep_for(std::chrono::milliseconds(1));
                         }
                       }
                       return PushSideways(nullptr, reading);
                     },
                 .context = &stuck});
  ASSERT_TRUE(WaitFor([&] { return stuck.num_ticks >= 150; }));
  // The servo thread is stuck, and yet the motors are off.
  EXPECT_TRUE(WaitFor([&] { return library.Value("motors_on") == 0.0; }));
  EXPECT_EQ(library.Value("last_n"), 0.0);
  EXPECT_TRUE(WaitFor([&] { return device->status().num_overruns >= 1; }));
  stuck.lets_go = true;
  EXPECT_TRUE(WaitFor([&] { return library.Value("last_n") > 1.8; }));
  EXPECT_THAT(device->status().text, HasSubstr("took longer than 10 ms"));
  EXPECT_GE(device->status().guard[GuardAct::kStepLate], 1);
  device->Stop();
}

TEST_P(VendorDrivers, ATrackerThatIsLostSwitchesForcesOff) {
  const StandIn library(GetParam().variant, "");
  const auto device = OpenDevice(VendorDriversQuick(library, GetParam().driver));
  device->Start({.tick = &PushSideways, .context = nullptr});
  ASSERT_TRUE(WaitFor([&] { return library.Value("last_n") > 1.8; }));
  device->SetInhibited(Inhibit::kTrackerLost, true);
  EXPECT_TRUE(WaitFor([&] { return library.Value("last_n") == 0.0; }));
  EXPECT_TRUE(device->status().guard.IsActing(GuardAct::kInhibited));
  device->SetInhibited(Inhibit::kTrackerLost, false);
  EXPECT_TRUE(WaitFor([&] { return library.Value("last_n") > 1.8; }));
  device->Stop();
}

TEST_P(VendorDrivers, AreStoppedByTheirDestructorAlsoWhenAnExceptionPasses) {
  const StandIn library(GetParam().variant, "");
  try {
    const auto device = OpenDevice(VendorDriversQuick(library, GetParam().driver));
    device->Start({.tick = &PushSideways, .context = nullptr});
    EXPECT_TRUE(WaitFor([&] { return library.Value("last_n") > 1.8; }));
    throw InputError("something else is wrong");
  } catch (const InputError&) {
  }
  EXPECT_EQ(library.Value("last_n"), 0.0);
  EXPECT_EQ(library.Value("is_open"), 0.0);
  EXPECT_THAT(library.Log(), HasSubstr(GetParam().stop));
}

TEST_P(VendorDrivers, MayBeStartedAgain) {
  const StandIn library(GetParam().variant, "");
  const auto device = OpenDevice(VendorDriversQuick(library, GetParam().driver));
  for (int run = 1; run <= 3; ++run) {
    device->Start({.tick = &PushSideways, .context = nullptr});
    EXPECT_TRUE(WaitFor([&] { return library.Value("last_n") > 1.8; })) << run;
    device->Stop();
    EXPECT_EQ(library.Value("opened"), run);
    EXPECT_EQ(library.Value("closed"), run);
  }
}

TEST(Virtuose, TheEmergencyStopAndTheDeadManSwitchForcesOffAndTheyComeBackSlowly) {
  const StandIn library("virtuose", "");
  DeviceConfig config = VendorDriversQuick(library, DriverKind::kVirtuose);
  config.safety.ramp_in_s = 0.1;
  const auto device = OpenDevice(config);
  device->Start({.tick = &PushSideways, .context = nullptr});
  const std::vector<std::pair<const char*, const char*>> switches = {
      {"emergency_stop", "the emergency stop is pressed"},
      {"dead_man_open", "the dead-man switch of the handle is open"}};
  for (const auto& [fault, words] : switches) {
    ASSERT_TRUE(WaitFor([&] { return library.Value("last_n") > 1.8; }));
    const std::int64_t ramped = device->status().guard[GuardAct::kRampIn];
    library.Set(fault, 1.0);
    EXPECT_TRUE(WaitFor([&] { return library.Value("last_n") == 0.0; })) << fault;
    EXPECT_TRUE(WaitFor([&] { return device->status().text.find(words) != std::string::npos; }))
        << device->status().text;
    EXPECT_TRUE(device->status().reading.valid);  // The pose is as good as ever.
    library.Set(fault, 0.0);
    EXPECT_TRUE(WaitFor([&] { return library.Value("last_n") > 1.8; })) << fault;
    EXPECT_GT(device->status().guard[GuardAct::kRampIn], ramped) << fault;
  }
  device->Stop();
}

TEST(OpenHaptics, TwoDevicesShareTheSchedulerWhichIsStoppedWithTheLast) {
  const StandIn library("hd", "");
  DeviceConfig config = VendorDriversQuick(library, DriverKind::kOpenHaptics);
  config.vendor.device = "Right Device";
  const auto needle = OpenDevice(config);
  config.vendor.device = "Left Device";
  const auto probe = OpenDevice(config);
  for (HapticDevice* device : {needle.get(), probe.get()}) {
    device->Start({.tick = &PushSideways, .context = nullptr});
  }
  ASSERT_TRUE(WaitFor([&] { return needle->status().force.force_n.norm() > 1.8; }));
  ASSERT_TRUE(WaitFor([&] { return probe->status().force.force_n.norm() > 1.8; }));
  needle->Stop();
  EXPECT_THAT(library.Log(), testing::Not(HasSubstr("hdStopScheduler")));
  const std::int64_t ticks = probe->status().ticks;
  EXPECT_TRUE(WaitFor([&] { return probe->status().ticks > ticks + 50; }));
  probe->Stop();
  EXPECT_THAT(library.Log(), HasSubstr("hdStopScheduler\nmotors off\nhdDisableDevice"));
  EXPECT_EQ(library.Value("is_open"), 0.0);
}

TEST(RealTime, WhatIsNotPermittedIsSaidWithTheCure) {
  std::string notice;
  std::thread([&] { notice = RequestRealTime(80); }).join();
  if (!notice.empty()) {
    EXPECT_THAT(notice, HasSubstr("/etc/security/limits.d/haptics.conf"));
  }
  std::string refused;
  std::thread([&] { refused = RequestRealTime(1000); }).join();  // There is no such priority.
  EXPECT_THAT(refused, HasSubstr("no real-time priority (Invalid argument)"));
  EXPECT_THAT(refused, HasSubstr("rtprio 90"));
}

TEST(ForceDimension, OpensTheDeviceWithTheSerialNumber) {
  const StandIn library("dhd", "");
  DeviceConfig config = VendorDriversQuick(library, DriverKind::kForceDimension);
  config.vendor.device = "815";
  EXPECT_NO_THROW(OpenDevice(config));
  config.vendor.device = "816";
  EXPECT_THAT([&] { OpenDevice(config); },
              testing::ThrowsMessage<InputError>(HasSubstr("serial number 816")));
  config.vendor.device = "left";
  EXPECT_THAT([&] { OpenDevice(config); },
              testing::ThrowsMessage<InputError>(HasSubstr("not 'left'")));
}

TEST(ForceDimension, AFalconHasNoTorqueAndTheLimitsOfAFalcon) {
  const StandIn library("dhd", "type=60");
  const auto device = OpenDevice(VendorDriversQuick(library, DriverKind::kForceDimension));
  EXPECT_EQ(device->info().max_force_n, 8.0);
  EXPECT_EQ(device->info().max_torque_nmm, 0.0);
  device->Start({.tick = &PushSideways, .context = nullptr});
  EXPECT_TRUE(WaitFor([&] { return library.Value("last_n") > 1.8; }));
  device->Stop();
  EXPECT_EQ(library.Value("max_nm"), 0.0);
}

INSTANTIATE_TEST_SUITE_P(All, VendorDrivers,
                         testing::Values(Vendor{"hd", DriverKind::kOpenHaptics, "hdStopScheduler"},
                                         Vendor{"dhd", DriverKind::kForceDimension, "dhdStop"},
                                         Vendor{"virtuose", DriverKind::kVirtuose, "virtStopLoop"}),
                         NameOf);

/// What a process that is gone had told its motors.
class ProcessEnds : public testing::TestWithParam<Vendor> {
 protected:
  ProcessEnds() {
    GTEST_FLAG_SET(death_test_style, "threadsafe");
    log_ = fs::path(testing::TempDir()) / (std::string("process_ends_") + GetParam().variant);
    setenv("ACUS_STAND_IN_LOG", log_.c_str(), 1);
  }
  ~ProcessEnds() override {
    unsetenv("ACUS_STAND_IN_LOG");
    fs::remove(log_);
  }

  /// In the child: starts a device, waits until it pushes, and ends the process by `end`.
  void PushAnd(void (*end)()) const {
    const StandIn library(GetParam().variant, "");
    const auto device = OpenDevice(VendorDriversQuick(library, GetParam().driver));
    ZeroForcesOnSignals();
    device->Start({.tick = &PushSideways, .context = nullptr});
    WaitFor([&] { return library.Value("last_n") > 1.8; });
    fs::remove_all(library.path().parent_path());  // The destructor will not run.
    end();
  }
  void ExpectZero() const {
    const std::string log = ReadTextFile(log_);
    const auto push = log.rfind("force on");
    ASSERT_NE(push, log.npos) << log;
    EXPECT_NE(log.find("force zero", push), log.npos) << log;
    EXPECT_NE(log.find("motors off", push), log.npos) << log;
    fs::remove(log_);
  }

  fs::path log_;
};

// A test each: the child runs its test from the beginning.
TEST_P(ProcessEnds, ByATerminationSignal) {
  EXPECT_EXIT(PushAnd([] { std::raise(SIGTERM); }), testing::KilledBySignal(SIGTERM), "");
  ExpectZero();
}
TEST_P(ProcessEnds, ByAbort) {
  EXPECT_EXIT(PushAnd([] { std::abort(); }), testing::KilledBySignal(SIGABRT), "");
  ExpectZero();
}
TEST_P(ProcessEnds, ByAnUncaughtException) {
  EXPECT_EXIT(PushAnd([] { std::terminate(); }), testing::KilledBySignal(SIGABRT), "");
  ExpectZero();
}
TEST_P(ProcessEnds, ByASegmentationFault) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "the sanitizer wants this signal for itself";
#endif
  EXPECT_EXIT(PushAnd([] { std::raise(SIGSEGV); }), testing::KilledBySignal(SIGSEGV), "");
  ExpectZero();
}
TEST_P(ProcessEnds, ByExitWithDevicesRunning) {
  EXPECT_EXIT(PushAnd([] { std::exit(5); }), testing::ExitedWithCode(5), "");
  ExpectZero();
}

INSTANTIATE_TEST_SUITE_P(All, ProcessEnds,
                         testing::Values(Vendor{"hd", DriverKind::kOpenHaptics, ""},
                                         Vendor{"dhd", DriverKind::kForceDimension, ""},
                                         Vendor{"virtuose", DriverKind::kVirtuose, ""}),
                         NameOf);

TEST(EndOfProcess, AHandlerOfTheProgramIsCalledAfterwards) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(
      {
        std::signal(SIGTERM, [](int) { _exit(ForcesAreCut() ? 7 : 8); });
        ZeroForcesOnSignals();
        std::raise(SIGTERM);
      },
      testing::ExitedWithCode(7), "");
}

// nohup: the session outlives its terminal, and goes on pushing.
TEST(EndOfProcess, WhatIsIgnoredCutsNoForce) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(
      {
        std::signal(SIGHUP, SIG_IGN);
        ZeroForcesOnSignals();
        std::raise(SIGHUP);
        _exit(ForcesAreCut() ? 8 : 7);
      },
      testing::ExitedWithCode(7), "");
}

}  // namespace
}  // namespace acus::haptics
