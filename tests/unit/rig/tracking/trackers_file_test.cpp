#include "acus/rig/tracking/trackers_file.h"

#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "acus/base/core/error.h"
#include "support/temporary_folder.h"

namespace acus::tracking {
namespace {

using testing::HasSubstr;

class TrackersFile : public testing::Test {
 protected:
  std::vector<IgtlOptions> Read(const std::string& trackers) {
    std::ofstream(folder_ / "devices.json")
        << R"({"format": "acus-devices/1", "devices": [], "trackers": )" << trackers << "}";
    return ReadTrackers(folder_ / "devices.json");
  }
  std::string Error(const std::string& trackers) {
    try {
      Read(trackers);
    } catch (const InputError& error) {
      return error.what();
    }
    return "none";
  }
  testing_support::TemporaryFolder folder_;
};

TEST_F(TrackersFile, ReadsWhatItSays) {
  const auto trackers = Read(R"([
    {"tools": [{"tool": "probe", "device": "ProbeToReference"}]},
    {"name": "NDI", "host": "10.0.0.5", "port": 18945, "listen": true, "request_interval_ms": 10,
     "check_crc": false, "lost_after_ms": 50, "silence_ms": 1000,
     "tools": [{"tool": "needle", "device": "NeedleToTracker", "relative_to": "ReferenceToTracker",
                "translation_mm": [1, 2, 3], "quaternion_wxyz": [0, 1, 0, 0]}]}])");
  ASSERT_EQ(trackers.size(), 2u);
  EXPECT_EQ(trackers[0].host, "localhost");
  EXPECT_EQ(trackers[0].port, 18944);
  EXPECT_EQ(trackers[0].tdata_interval_ms, -1);
  EXPECT_EQ(trackers[0].tools[0].device, "ProbeToReference");
  const IgtlOptions& ndi = trackers[1];
  EXPECT_EQ(ndi.name, "NDI");
  EXPECT_EQ(ndi.port, 18945);
  EXPECT_TRUE(ndi.listen);
  EXPECT_FALSE(ndi.check_crc);
  EXPECT_EQ(ndi.tdata_interval_ms, 10);
  EXPECT_EQ(ndi.lost_after_ms, 50);
  EXPECT_EQ(ndi.silence_ms, 1000);
  EXPECT_EQ(ndi.tools[0].relative_to, "ReferenceToTracker");
  const Eigen::Vector3d point = ndi.tools[0].marker_from_tool * Eigen::Vector3d(0, 1, 0);
  EXPECT_LT((point - Eigen::Vector3d(1, 1, 3)).norm(), 1e-12);
  for (const IgtlOptions& tracker : trackers) IgtlSource{tracker};
}

TEST_F(TrackersFile, SaysWhatIsWrongAndWhere) {
  EXPECT_THAT(Error(R"([{"tools": []}])"), HasSubstr("/trackers/0/tools"));
  EXPECT_THAT(Error(R"([{"port": 0, "tools": [{"tool": "a", "device": "b"}]}])"),
              HasSubstr("/trackers/0/port"));
  EXPECT_THAT(Error(R"([{"tools": [{"tool": "a", "device": "b", "relative_to": "b"}]}])"),
              HasSubstr("/trackers/0/tools/0/relative_to"));
  EXPECT_THAT(
      Error(R"([{"tools": [{"tool": "a", "device": "b", "quaternion_wxyz": [1, 1, 0, 0]}]}])"),
      HasSubstr("/trackers/0/tools/0/quaternion_wxyz: has length 1.41421356"));
  EXPECT_THAT(Error(R"([{"tools": [{"tool": "a", "device": "b"}]},
                        {"tools": [{"tool": "a", "device": "c"}]}])"),
              HasSubstr("/trackers/1/tools/0/tool: there are two 'a'"));
}

TEST_F(TrackersFile, ThePresetsCanBeUsed) {
  const std::filesystem::path folder = ACUS_SOURCE_DIR "/configs/devices";
  EXPECT_EQ(ReadTrackers(folder / "tracked_probe.json").size(), 1u);
  EXPECT_TRUE(ReadTrackers(folder / "virtual.json").empty());
}

}  // namespace
}  // namespace acus::tracking
