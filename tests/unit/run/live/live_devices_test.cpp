#include "acus/run/live/live_devices.h"

#include <gmock/gmock.h>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "acus/data/transforms/transform_file.h"
#include "support/fuzz.h"
#include "support/temporary_folder.h"

namespace acus::live {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;
using testing_support::TemporaryFolder;

constexpr const char* kAll = R"({"format": "acus-devices/1", "name": "all",
  "devices": [{"name": "right", "driver": "virtual_hand",
               "reference_from_device": {"translation_mm": [1, 2, 3]}},
              {"name": "left", "driver": "virtual_hand",
               "reference_from_device_file": "left.tfm"}],
  "needle": {"device": "right"},
  "trackers": [{"name": "polaris", "port": 1234, "tools": [
      {"tool": "probe", "device": "ProbeToTracker", "relative_to": "ReferenceToTracker",
       "translation_mm": [0, 0, 7]},
      {"tool": "belt", "device": "BeltToReference"}]}],
  "camera": {"place": "device:0", "model": "cameras/webcam_720p.json",
             "facets": "facets/training.json", "tools": [{"tool": "pointer", "object": "Pointer"}]},
  "breath": {"tool": "belt", "axis": [0, 0.6, 0.8], "inspiration_mm": 12},
  "send_out": {}})";

class LiveDevicesFile : public testing::Test {
 protected:
  LiveDevicesFile() {
    setenv("ACUS_CONFIGS", (std::filesystem::path(ACUS_SOURCE_DIR) / "configs").c_str(), 1);
    Eigen::Isometry3d place = Eigen::Isometry3d::Identity();
    place.linear() = Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitY()).toRotationMatrix();
    transforms::WriteTransform(folder_ / "left.tfm", place, "test");
  }
  LiveDevices Read(const std::string& text) {
    WriteTextFile(folder_ / "d.json", text);
    return ReadLiveDevices(folder_ / "d.json");
  }
  std::string Changed(const std::string& from, const std::string& to) {
    std::string text = kAll;
    EXPECT_NE(text.find(from), std::string::npos);
    return text.replace(text.find(from), from.size(), to);
  }
  void ExpectFails(const std::string& text, const std::string& why) {
    EXPECT_THAT([&] { Read(text); }, ThrowsMessage<InputError>(HasSubstr(why)));
  }
  TemporaryFolder folder_;
};

TEST_F(LiveDevicesFile, IsReadWhole) {
  const LiveDevices devices = Read(kAll);
  EXPECT_EQ(devices.reference_from_device.at("right").translation(), Eigen::Vector3d(1, 2, 3));
  EXPECT_NEAR(devices.reference_from_device.at("left").linear()(0, 2), std::sin(0.3), 1e-12);
  ASSERT_EQ(devices.trackers.size(), 1U);
  EXPECT_EQ(devices.trackers[0].options.port, 1234);
  EXPECT_EQ(devices.trackers[0].options.tools[0].relative_to, "ReferenceToTracker");
  EXPECT_EQ(devices.trackers[0].options.tools[0].marker_from_tool.translation().z(), 7.0);
  EXPECT_EQ(devices.FindTracked("belt")->tool, 1U);
  EXPECT_FALSE(devices.FindTracked("needle"));
  EXPECT_EQ(devices.FindTracked("pointer")->tracker, 1U);  // The camera comes last.
  EXPECT_EQ(devices.camera->options.tools[0].object, "Pointer");
  EXPECT_TRUE(devices.has_needle());
  EXPECT_TRUE(devices.has_probe());
  EXPECT_NEAR(devices.belt->axis.norm(), 1.0, 1e-15);
  EXPECT_EQ(devices.belt->expiration_mm, 0.0);
  EXPECT_TRUE(devices.send_out);
}

TEST_F(LiveDevicesFile, TheSecondCameraIsRead) {
  const LiveDevices devices =
      Read(Changed(R"("place": "device:0", "model": "cameras/webcam_720p.json")",
                   R"("place": "device:0", "model": "cameras/micron_tracker_2010.json",
                      "second": {"place": "device:1", "stereo": "cameras/micron_pair_2010.json"})"));
  ASSERT_TRUE(devices.camera->options.second);
  EXPECT_EQ(devices.camera->options.second->place, "device:1");
  EXPECT_EQ(devices.camera->options.second->apart_ms, 12);
  EXPECT_NEAR(devices.camera->options.second->pair.BaselineMm(), 120.0, 1e-9);
  EXPECT_FALSE(Read(kAll).camera->options.second);
}

TEST_F(LiveDevicesFile, SaysWhatContradictsItself) {
  ExpectFails(Changed(R"("needle": {"device": "right"},)",
                      R"("needle": {"device": "right"}, "probe": {"device": "left"},)"),
              "the probe is on the device \"left\" and tracked as well");
  ExpectFails(Changed(R"("tool": "belt", "device")", R"("tool": "probe", "device")"),
              "there are two 'probe'");
  ExpectFails(Changed(R"("tool": "pointer")", R"("tool": "probe")"),
              "/camera/tools: tool \"probe\" is tracked twice");
  ExpectFails(Changed(R"({"tool": "belt", "axis")", R"({"tool": "vest", "axis")"),
              "no tracker has a tool \"vest\"");
  ExpectFails(Changed("[0, 0.6, 0.8]", "[0, 0, 0]"), "/breath/axis: has no length");
  ExpectFails(Changed(R"("inspiration_mm": 12)", R"("inspiration_mm": 0.05)"),
              "must be at least 0.1 mm apart");
  ExpectFails(Changed("left.tfm", "right.tfm"), "right.tfm");
  ExpectFails(R"({"format": "acus-devices/1", "devices": []})",
              "neither needle nor probe is on a device or tracked");
}

TEST_F(LiveDevicesFile, DamagedIsReadOrRefused) {
  const int refused = testing_support::ReadDamagedCopies(
      kAll, folder_ / "d.json", 300, [&] { ReadLiveDevices(folder_ / "d.json"); });
  EXPECT_GT(refused, 100);
}

}  // namespace
}  // namespace acus::live
