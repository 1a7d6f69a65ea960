#include "acus/rig/haptics/devices_file.h"

#include <filesystem>
#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "acus/base/core/random.h"
#include "acus/rig/haptics/open_device.h"

namespace acus::haptics {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

fs::path Written(const std::string& text) {
  const fs::path path = fs::path(testing::TempDir()) / "devices_file_test.json";
  std::ofstream(path) << text;
  return path;
}

std::string WithDevice(const std::string& more) {
  return R"({"format": "acus-devices/1", "devices": [{"name": "right", "driver": "virtual_hand")" +
         more + "}], \"needle\": {\"device\": \"right\"}}";
}

TEST(DevicesFile, DefaultsAreThoseOfTheSettings) {
  const DevicesFile file = ReadDevices(Written(WithDevice("")));
  const DeviceConfig& device = file.devices.at(0);
  const GuardSettings guard;
  EXPECT_EQ(device.safety.max_force_n, guard.max_force_n);
  EXPECT_EQ(device.safety.max_torque_nmm, guard.max_torque_nmm);
  EXPECT_EQ(device.safety.force_slew_n_per_s, guard.force_slew_n_per_s);
  EXPECT_EQ(device.safety.torque_slew_nmm_per_s, guard.torque_slew_nmm_per_s);
  EXPECT_EQ(device.safety.ramp_in_s, guard.ramp_in_s);
  EXPECT_EQ(device.safety.settle_s, guard.settle_s);
  EXPECT_EQ(device.safety.late_s, guard.late_s);
  EXPECT_EQ(device.safety.jump_mm, guard.jump_mm);
  EXPECT_NEAR(device.safety.jump_rad, guard.jump_rad, 1e-3);
  EXPECT_EQ(device.safety.dead_man, guard.dead_man);
  EXPECT_EQ(device.safety.dead_man_buttons, guard.dead_man_buttons);
  const VirtualHandSettings hand;
  EXPECT_EQ(device.hand.mass_kg, hand.mass_kg);
  EXPECT_EQ(device.hand.damping_n_s_per_m, hand.damping_n_s_per_m);
  EXPECT_EQ(device.hand.stiffness_n_per_m, hand.stiffness_n_per_m);
  EXPECT_EQ(device.hand.grip_damping_n_s_per_m, hand.grip_damping_n_s_per_m);
  EXPECT_EQ(device.hand.inertia_kg_mm2, hand.inertia_kg_mm2);
  EXPECT_EQ(device.hand.grip_torque_nmm_per_rad, hand.grip_torque_nmm_per_rad);
  EXPECT_EQ(device.hand.tremor_mm, hand.tremor_mm);
  EXPECT_EQ(device.hand.encoder_mm, hand.encoder_mm);
  EXPECT_EQ(device.hand.max_force_n, hand.max_force_n);
  EXPECT_EQ(device.hand.max_torque_nmm, hand.max_torque_nmm);
  EXPECT_EQ(device.hand.rate_hz, hand.rate_hz);
  EXPECT_EQ(device.vendor.timeout_s, VendorOptions().timeout_s);
}

TEST(DevicesFile, ReadsWhatItSays) {
  const DevicesFile file = ReadDevices(Written(R"({"format": "acus-devices/1", "name": "room 3",
    "devices": [
      {"name": "a", "driver": "virtuose", "library": "libX.so", "device": "10.0.0.2#1",
       "axes": "-x +y -z", "rate_hz": 2000, "timeout_s": 7,
       "safety": {"max_force_n": 2.5, "jump_deg": 90, "dead_man": "button",
                  "dead_man_buttons": [0, 2]}},
      {"name": "b", "driver": "virtual_hand", "virtual_hand": {"repeats": true, "path": [
        {"time_s": 0, "translation_mm": [1, 2, 3]},
        {"time_s": 1.5, "translation_mm": [4, 5, 6], "quaternion_wxyz": [0, 1, 0, 0]}]}}],
    "needle": {"device": "a", "translation_mm": [0, 0, 80], "quaternion_wxyz": [0, 0, 1, 0]},
    "probe": {"device": "b"}})"));
  EXPECT_EQ(file.name, "room 3");
  const DeviceConfig& a = *file.Find("a");
  EXPECT_EQ(a.driver, DriverKind::kVirtuose);
  EXPECT_EQ(a.vendor.library, "libX.so");
  EXPECT_EQ(a.vendor.device, "10.0.0.2#1");
  EXPECT_EQ(a.vendor.axes, "-x +y -z");
  EXPECT_EQ(a.vendor.rate_hz, 2000.0);
  EXPECT_EQ(a.vendor.timeout_s, 7.0);
  EXPECT_EQ(a.safety.max_force_n, 2.5);
  EXPECT_NEAR(a.safety.jump_rad, 1.5708, 1e-4);
  EXPECT_EQ(a.safety.dead_man, DeadMan::kButton);
  EXPECT_EQ(a.safety.dead_man_buttons, 0b101U);
  const GoalPath& path = file.Find("b")->hand.path;
  EXPECT_TRUE(path.repeats);
  ASSERT_EQ(path.points.size(), 2U);
  EXPECT_EQ(path.points[1].device_from_handle.translation(), Eigen::Vector3d(4, 5, 6));
  EXPECT_NEAR(path.points[1].device_from_handle.linear()(1, 1), -1.0, 1e-12);
  EXPECT_EQ(file.needle.handle_from_tool.translation().z(), 80.0);
  EXPECT_NEAR(file.needle.handle_from_tool.linear()(0, 0), -1.0, 1e-12);
}

TEST(DevicesFile, HandsAreSwappedWithoutWhatIsFixedToTheHandle) {
  const std::string text = R"({"format": "acus-devices/1", "left_handed": true, "devices": [
      {"name": "right", "driver": "virtual_hand"}, {"name": "left", "driver": "virtual_hand"}],
    "needle": {"device": "right", "translation_mm": [0, 0, 80]}, "probe": {"device": "left"}})";
  DevicesFile file = ReadDevices(Written(text));
  EXPECT_EQ(file.needle.device, "left");
  EXPECT_EQ(file.probe.device, "right");
  EXPECT_EQ(file.needle.handle_from_tool.translation().z(), 80.0);
  file.SwapHands();
  EXPECT_EQ(file.needle.device, "right");
}

TEST(DevicesFile, SaysWhatIsWrong) {
  const auto says = [](const std::string& text, const std::string& what) {
    EXPECT_THAT(
        [&] { ReadDevices(Written(text)); },
        ThrowsMessage<InputError>(AllOf(HasSubstr("devices_file_test.json"), HasSubstr(what))));
  };
  says(WithDevice(R"(, "driver2": 1)"), "driver2");
  says(WithDevice(R"(, "rate_hz": 99)"), "/devices/0/rate_hz");
  says(WithDevice(R"(, "rate_hz": 4001)"), "/devices/0/rate_hz");
  says(WithDevice(R"(, "timeout_s": 0)"), "/devices/0/timeout_s");
  says(WithDevice(R"(, "axes": "+x +x +z")"), "/devices/0/axes");
  says(WithDevice(R"(, "axes": "+x +y -z")"), "mirror");
  says(WithDevice(R"(, "axes": "+x +y")"), "/devices/0/axes");
  says(WithDevice(R"(, "axes": "+x +y +z +x")"), "/devices/0/axes");
  says(WithDevice(R"(, "library": "./libHD.so")"), "/devices/0/library: is './libHD.so'");
  says(WithDevice(R"(, "library": "drivers/libHD.so")"), "allowed: an absolute path");
  says(WithDevice(R"(, "safety": {"max_force_n": 41})"), "max_force_n");
  says(WithDevice(R"(, "safety": {"max_force_n": -1})"), "max_force_n");
  says(WithDevice(R"(, "safety": {"late_s": 0.3})"), "late_s");
  says(WithDevice(R"(, "safety": {"dead_man": "foot"})"), "dead_man");
  says(WithDevice(R"(, "safety": {"dead_man_buttons": [31]})"), "dead_man_buttons");
  says(WithDevice(R"(, "virtual_hand": {"mass_kg": 0})"), "mass_kg");
  says(WithDevice(R"(, "virtual_hand": {"path": [
         {"time_s": 1, "translation_mm": [0, 0, 0]}, {"time_s": 1, "translation_mm": [0, 0, 0]}]})"),
       "/devices/0/virtual_hand/path/1/time_s");
  says(WithDevice(R"(, "virtual_hand": {"path": [
         {"time_s": 1, "translation_mm": [0, 0, 0], "quaternion_wxyz": [1, 1, 0, 0]}]})"),
       "/path/0/quaternion_wxyz");
  says(R"({"format": "acus-devices/1", "devices": [], "probe": {"device": "x"}})",
       "/probe/device: is 'x'");
  says(R"({"format": "acus-devices/1", "devices": [{"name": "x", "driver": "virtual_hand"},
         {"name": "x", "driver": "virtual_hand"}]})",
       "two devices 'x'");
  says(R"({"format": "acus-devices/1", "devices": [{"name": "x", "driver": "virtual_hand"}],
         "needle": {"device": "x"}, "probe": {"device": "x"}})",
       "holds the needle already");
}

TEST(DevicesFile, PresetsAreRead) {
  int num_files = 0;
  for (const auto& entry :
       fs::directory_iterator(fs::path(ACUS_SOURCE_DIR) / "configs" / "devices")) {
    const DevicesFile file = ReadDevices(entry.path());
    EXPECT_FALSE(file.needle.device.empty()) << entry.path();
    for (const DeviceConfig& device : file.devices) EXPECT_NO_THROW(device.safety.Check("safety"));
    ++num_files;
  }
  EXPECT_GE(num_files, 4);
}

TEST(DevicesFile, DamagedFilesAreReadOrRefused) {
  const std::string text =
      ReadTextFile(fs::path(ACUS_SOURCE_DIR) / "configs" / "devices" / "virtuose_needle.json");
  RandomStream random(3, "devices file");
  int num_refused = 0;
  for (int i = 0; i < 300; ++i) {
    std::string damaged = text.substr(0, i % 2 == 0 ? random.Next() % text.size() : text.size());
    if (i % 2 == 1)
      damaged[random.Next() % text.size()] ^= static_cast<char>(1U << random.Next() % 8);
    try {
      ReadDevices(Written(damaged));
    } catch (const InputError&) {
      ++num_refused;
    }
  }
  EXPECT_GT(num_refused, 200);
}

TEST(OpenDevice, OpensAVirtualHandAndNamesADeviceThatCannotBeOpened) {
  DeviceConfig config;
  config.name = "right";
  EXPECT_EQ(OpenDevice(config)->info().name, "virtual hand");
  for (const DriverKind driver :
       {DriverKind::kOpenHaptics, DriverKind::kForceDimension, DriverKind::kVirtuose}) {
    config.driver = driver;
    config.vendor.library = "libthere_is_none.so";
    EXPECT_THAT([&] { OpenDevice(config); },
                ThrowsMessage<InputError>(
                    AllOf(HasSubstr("device 'right'"),
                          HasSubstr("libthere_is_none.so: cannot open shared object file"),
                          HasSubstr("Install"))));
  }
}

}  // namespace
}  // namespace acus::haptics
