// Haptic devices that fail during a session, as stand-in libraries of a vendor make them.
#include <dlfcn.h>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/monotonic_time.h"
#include "acus/data/volume/volume_io.h"
#include "acus/run/live/live_session.h"
#include "support/layered_folder.h"
#include "support/replay_folder.h"
#include "support/stand_in.h"

namespace acus::live {
namespace {

namespace fs = std::filesystem;
using haptics::GuardAct;

/// What becomes of a fault at the 300th reading, in a session of 2.5 s.
struct DeviceFault {
  const char* name;
  const char* faults;  ///< See tests/stand_ins/simulated_arm.h.
  const char* status;  ///< Part of what the screen says meanwhile; empty: nothing is needed.
  GuardAct act;        ///< Counted by the guard.
  int least_reopened;
  bool goes_on;  ///< Steps are made after the fault.
};

void PrintTo(const DeviceFault& fault, std::ostream* out) {
  *out << fault.faults;
}

class FaultOfTheDevice : public testing_support::ReplayFolder,
                         public testing::WithParamInterface<DeviceFault> {
 protected:
  void SetUp() override { testing_support::WriteLayeredFolder(folder_, R"({"needle_force": {}})"); }
};

TEST_P(FaultOfTheDevice, EndsNoSessionAndSpoilsNoRecording) {
  const DeviceFault& fault = GetParam();
  const testing_support::StandIn library("dhd", fault.faults);
  // The arm moves the needle from side to side, 10 mm under the skin.
  WriteTextFile(folder_ / "devices.json",
                Message(R"({"format": "acus-devices/1", "devices": [{"name": "right",
      "driver": "force_dimension", "library": )",
                        library.path(), R"(,
      "reference_from_device": {"translation_mm": [0, 0, -20]}}],
      "needle": {"device": "right"}})"));
  LiveOptions options;
  options.session_folder = folder_ / "s";
  options.duration_s = 2.5;
  LiveSession session(scenario::ReadScenario(folder_ / "scene.json", {}),
                      ReadLiveDevices(folder_ / "devices.json"), options, context_);
  session.Start();
  std::string said;
  while (session.Poll()) {
    for (const StatusLine& line : session.Status()) said += line.text + '\n';
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  EXPECT_EQ(session.end(), SessionEnd::kDuration);
  session.Stop();
  EXPECT_THAT(said, testing::HasSubstr(fault.status));
  const auto summary = nlohmann::json::parse(ReadTextFile(folder_ / "s/summary.json"));
  const auto& device = summary.at("devices").at(0);
  EXPECT_GT(device.at("guard").at(haptics::Words(fault.act)), 0);
  EXPECT_GE(device.at("reopened"), fault.least_reopened);
  EXPECT_EQ(summary.at("recording").at("steps_lost"), 0);
  EXPECT_EQ(session.statistics().steps > 600, fault.goes_on) << session.statistics().steps;

  replay::ReplayOptions replay;
  replay.run_folder = folder_ / "r";
  replay::ReplaySession(scenario::ReadScenario(folder_ / "scene.json", {}), folder_ / "s", replay,
                        context_);
  EXPECT_TRUE(ReadTextFile(folder_ / "s/forces.csv") == ReadTextFile(folder_ / "r/forces.csv"));
}

INSTANTIATE_TEST_SUITE_P(
    Session, FaultOfTheDevice,
    testing::Values(DeviceFault{"NanPose", "nan_pose=300", "", GuardAct::kReadingNotFinite, 0,
                                true},
                    DeviceFault{"Jump", "jump=300", "", GuardAct::kReadingJumped, 0, true},
                    DeviceFault{"CommError", "error_at=300,error=2", "communication",
                                GuardAct::kRampIn, 1, true},
                    DeviceFault{"Unplugged", "unplugged=300", "", GuardAct::kRampIn, 0, false}),
    [](const auto& fault) { return fault.param.name; });

}  // namespace
}  // namespace acus::live
