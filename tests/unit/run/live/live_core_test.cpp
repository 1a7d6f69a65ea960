// What a live session felt is what acus-replay makes of its recording, bit for bit.
#include "acus/run/live/live_core.h"

#include <fstream>
#include <gmock/gmock.h>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/random.h"
#include "acus/base/math/rigid.h"
#include "acus/data/session/session_io.h"
#include "acus/data/volume/volume_io.h"
#include "acus/physics/breathing/motion_file.h"
#include "acus/rig/haptics/virtual_hand.h"
#include "support/layered_folder.h"
#include "support/replay_folder.h"

// Counts what Tick() takes from the heap.
#include "support/allocation_counter.h"

namespace acus::live {
namespace {

namespace fs = std::filesystem;
using haptics::DeviceReading;
using scenario::Override;
using session::CommandKind;

constexpr std::int64_t kMs = 1'000'000;
constexpr std::int64_t kOriginNs = 123'456'789'000;

/// Everything that a scene can feel, on a layered patient on disk.
class LiveReplay : public testing_support::ReplayFolder {
 protected:
  void SetUp() override {
    testing_support::WriteLayeredFolder(folder_, R"({"needle_force": {}})", 10);
    fs::create_directories(folder_ / "motion");
    WriteMotion(folder_ / "motion");
  }

  static void WriteMotion(const fs::path& folder) {
    volume::Geometry nodes;
    nodes.size = {6, 6, 6};
    nodes.spacing_mm = {40, 40, 40};
    nodes.origin_mm = {-100, -100, -60};
    breathing::MotionField field(nodes, 1);
    std::vector<float> values;
    for (int n = 0; n < 216; ++n) {
      for (const float mm : {0.5F, 1.0F + 0.01F * static_cast<float>(n % 6), 6.0F}) {
        values.push_back(mm);
      }
    }
    field.SetComponent(0, values);
    breathing::WritePatientMotion(folder,
                                  {.name = "up and down",
                                   .model = breathing::MotionModel::Sinusoid(std::move(field), 1.0),
                                   .period_s = 2.0});
  }

  /// A scene with the changes to scene.json, as a live session loads it.
  void Load(const std::vector<Override>& changes) {
    changes_ = changes;
    const auto scenario = scenario::ReadScenario(folder_ / "scene.json", changes);
    const auto plan = simulation::PlanEffects(
        scenario, {.needle_poses = true, .probe_poses = true, .breath = true});
    scene_.emplace(simulation::LoadScene(scenario, plan, context_));
    partner_.reset();
    if (scene_->breathing) {
      partner_.emplace(simulation::LoadBreathing(scenario, /*from_session=*/false, context_));
    }
  }

  /// Where the hand is: into the tissue at 20 mm/s with tremor, slightly turned, and out again.
  static DeviceReading ReadingAt(int ms) {
    DeviceReading reading;
    reading.time_ns = kOriginNs + ms * kMs + (ms % 7) * 1'003;  // No clock is even.
    const double depth_mm = ms < 1500 ? -4.003 + 0.02 * ms : 25.997 - 0.02 * (ms - 1500);
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.linear() = Eigen::AngleAxisd(0.1 + 0.02 * std::sin(0.003 * ms),
                                      Eigen::Vector3d(1.0, 0.3, 0.1).normalized())
                        .toRotationMatrix();
    pose.translation() =
        Eigen::Vector3d(0.2 * std::sin(0.05 * ms), 20.0 + 0.1 * std::cos(0.06 * ms), depth_mm);
    reading.device_from_handle = pose * Eigen::Translation3d(0.0, 0.0, -100.0);
    reading.valid = !(ms < 40 || (ms > 900 && ms < 950));
    return reading;
  }

  static Eigen::Isometry3d ProbeAt(int ms) {
    Eigen::Isometry3d probe = Eigen::Isometry3d::Identity();
    probe.linear() << 1, 0, 0, 0, 0, -1, 0, 1, 0;
    probe.translation() << 0.0, 10.0 + 1e-3 * ms, -0.5 + 4.0 * std::sin(0.004 * ms);
    return probe;
  }

  CoreSettings Settings() {
    CoreSettings settings;
    settings.origin_ns = kOriginNs;
    settings.servo.handle_from_tool = Eigen::Isometry3d(Eigen::Translation3d(0.0, 0.0, 100.0));
    settings.other = BoardTool{.board = &board_, .tool = 0, .mount = {}, .stale_s = 0.1};
    return settings;
  }

  /// The tracker of the probe: 40 Hz, silent at first and for a while later on.
  void PublishProbe(int ms) {
    if (ms % 25 != 0 || ms < 300 || (ms > 1200 && ms < 1600)) return;
    tracking::TrackedPose pose;
    pose.time_ns = pose.measured_ns = kOriginNs + ms * kMs;
    pose.reference_from_tool = ProbeAt(ms);
    if (ms == 600) {
      pose.reference_from_tool =
          Eigen::Isometry3d(Eigen::Translation3d(50.0, 0.0, 0.0) * ProbeAt(ms));
    }
    pose.valid = ms != 700;
    board_.Publish(0, pose);
  }

  /// Runs `count` ticks and leaves the session in `name`.
  void RunLive(const char* name, int count, const std::map<int, CommandKind>& orders = {}) {
    Recorder recorder(folder_ / name, name,
                      {.needle = true,
                       .probe = true,
                       .breathing = scene_->breathing.has_value(),
                       .commands = true,
                       .tracker = false},
                      *scene_, kOriginNs, {}, context_);
    LiveCore core(*scene_, Settings(), &recorder, partner_ ? &*partner_ : nullptr);
    for (int ms = 0; ms < count; ++ms) {
      PublishProbe(ms);
      const auto order = orders.find(ms);
      if (order != orders.end()) core.commands().Give(order->second);
      const haptics::DeviceForce force = core.Tick(ReadingAt(ms));
      largest_n_ = std::max(largest_n_, force.force_n.norm());
      largest_other_n_ =
          std::max(largest_other_n_, core.OtherForce(ReadingAt(ms).time_ns).force_n.norm());
      if (!ReadingAt(ms).valid) {
        ASSERT_EQ(force.force_n, Eigen::Vector3d::Zero()) << ms;
      }
    }
    recorder.Start();
    recorder.Close();
    ASSERT_EQ(recorder.status().steps_on_disk, count);
    needle_seen_ = core.statistics().needle[0];
    probe_jumps_ = core.statistics().probe[static_cast<std::size_t>(PoseVerdict::kJumped)];
  }

  /// Replays session `name`, and holds what it felt against what was felt live.
  void ExpectReplaySame(const char* name, const char* file) {
    RunContext context;
    replay::ReplayOptions options;
    options.run_folder = folder_ / (std::string(name) + "_run");
    context.overwrite = true;
    replay::ReplaySession(scenario::ReadScenario(folder_ / "scene.json", changes_), folder_ / name,
                          options, context);
    const std::string live = ReadTextFile(folder_ / name / file);
    EXPECT_GT(live.size(), 100'000U);
    EXPECT_TRUE(live == ReadTextFile(options.run_folder / file)) << name << ": " << file;
  }

  tracking::PoseBoard board_{{"probe"}};
  std::vector<Override> changes_;
  std::optional<simulation::Scene> scene_;
  std::optional<simulation::Breathing> partner_;
  double largest_n_ = 0.0;
  double largest_other_n_ = 0.0;
  std::int64_t needle_seen_ = 0;
  std::int64_t probe_jumps_ = 0;
};

TEST_F(LiveReplay, ARigidNeedleFeelsTheSame) {
  Load({});
  RunLive("rigid", 3000);
  EXPECT_GT(largest_n_, 0.5);
  EXPECT_EQ(needle_seen_, 3000 - 40 - 49);
  ExpectReplaySame("rigid", "forces.csv");
}

// As when Page Down is held, 30 mm/s for 8 s, by a hand that has no sense: through bone and beyond
// the hub the needle does not go, whatever limits the device's force.
TEST_F(LiveReplay, ANeedleOfAVirtualHandStopsAtBoneAndAtItsHub) {
  struct Case {
    const char* name;
    double y_mm;
    const char* needle;
    double deepest_mm;  ///< Bone begins at 60 mm; the short needle's hub is at 38 mm.
    StopKind by;
  };
  WriteTextFile(folder_ / "short.json", R"({"format": "acus-needle/1", "name": "short", "gauge": 22,
      "outer_diameter_mm": 0.7, "length_mm": 38, "tip": "quincke"})");
  for (const Case& c : {Case{"bone", 20.0, "needles/spinal_22g.json", 62.0, StopKind::kBone},
                        Case{"hub", 5.0, "short.json", 38.0, StopKind::kHub}}) {
    Load({{"/needle", c.needle}});
    Recorder recorder(folder_ / c.name, c.name, {.needle = true, .commands = true}, *scene_,
                      kOriginNs, {}, context_);
    CoreSettings settings;
    settings.origin_ns = kOriginNs;
    settings.servo.by_virtual_hand = true;
    LiveCore core(*scene_, settings, &recorder, nullptr);
    haptics::HandSteering steering;
    Eigen::Isometry3d goal(Eigen::Translation3d(0.0, c.y_mm, -5.0));
    steering.SetGoal(goal);
    haptics::VirtualHand hand({}, &steering);
    haptics::DeviceForce force;
    double deepest_mm = 0.0;
    for (int ms = 0; ms < 8000; ++ms) {
      if (ms % 10 == 0) steering.Nudge({0.0, 0.0, 0.3}, Eigen::Vector3d::Zero());
      DeviceReading reading = hand.Step(force, 1e-3);
      reading.time_ns = kOriginNs + (ms + 1) * kMs;
      force = core.Tick(reading);
      // As a guard limits it.
      if (force.force_n.norm() > 3.0) force.force_n *= 3.0 / force.force_n.norm();
      if (core.snapshots().Refresh()) {
        deepest_mm =
            std::max(deepest_mm, core.snapshots().Front().moment.ct_from_needle->translation().z());
      }
    }
    EXPECT_LE(deepest_mm, c.deepest_mm) << c.name;
    EXPECT_GE(deepest_mm, c.deepest_mm - 2.5) << c.name;
    EXPECT_EQ(core.stopped_by(), c.by) << c.name;
    recorder.Start();
    recorder.Close();
    ExpectReplaySame(c.name, "forces.csv");
  }
}

TEST_F(LiveReplay, ABendableNeedleFeelsTheSame) {
  Load({{"/effects/needle", {{"model", "bendable"}}}});
  RunLive("bendable", 2500);
  EXPECT_GT(largest_n_, 0.5);
  ExpectReplaySame("bendable", "forces.csv");
}

TEST_F(LiveReplay, TissueThatTheNeedleDeformsFeelsTheSame) {
  Load({{"/effects/needle_force", {{"model", "tissue"}}},
        {"/effects/tissue", {{"model", "springs"}}}});
  RunLive("springs", 2500);
  EXPECT_GT(largest_n_, 0.2);
  ExpectReplaySame("springs", "forces.csv");
}

TEST_F(LiveReplay, AProbeFeelsTheSame) {
  Load({{"/effects/probe_force", {{"press_mm", 3.0}}}});
  RunLive("probe", 3000);
  EXPECT_GT(largest_other_n_, 0.5);
  EXPECT_GT(probe_jumps_, 20);
  ExpectReplaySame("probe", "forces.csv");
  ExpectReplaySame("probe", "probe_forces.csv");
}

TEST_F(LiveReplay, APatientWhoBreathesAndHoldsHisBreathFeelsTheSame) {
  Load({{"/effects/breathing", {{"motion", "motion"}}}});
  RunLive("breath", 3000, {{800, CommandKind::kHoldBreath}, {2000, CommandKind::kBreatheOn}});
  EXPECT_GT(largest_n_, 0.5);
  ExpectReplaySame("breath", "forces.csv");
  const session::Session session = session::ReadSession(folder_ / "breath", context_);
  EXPECT_EQ(session.breath[1500].status, session::BreathStatus::kHeld);
  EXPECT_EQ(session.breath[1500].level, session.breath[1900].level);
  EXPECT_EQ(session.commands.size(), 2U);
}

TEST_F(LiveReplay, EverythingTogetherWithHandsSwappedFeelsTheSame) {
  Load({{"/effects/needle", {{"model", "bendable"}}},
        {"/effects/probe_force", {{"press_mm", 3.0}}},
        {"/effects/breathing", {{"motion", "motion"}}}});
  RunLive("all", 2500, {{1000, CommandKind::kSwapHands}, {1200, CommandKind::kSwapHands}});
  ExpectReplaySame("all", "forces.csv");
  ExpectReplaySame("all", "probe_forces.csv");
}

TEST_F(LiveReplay, ASessionThatWasCutOffReplaysToTheSameForcesAsFarAsItGoes) {
  Load({{"/effects/probe_force", {{"press_mm", 3.0}}}});
  RunLive("whole", 2500);
  fs::copy(folder_ / "whole", folder_ / "cut");
  const std::string needle = ReadTextFile(folder_ / "cut/needle.csv");
  WriteTextFile(folder_ / "cut/needle.csv", needle.substr(0, needle.size() / 2));
  replay::ReplayOptions options;
  options.run_folder = folder_ / "cut_again";
  RunContext context;
  replay::ReplaySession(scenario::ReadScenario(folder_ / "scene.json", changes_), folder_ / "cut",
                        options, context);
  const std::string replayed = ReadTextFile(folder_ / "cut_again/probe_forces.csv");
  EXPECT_GT(replayed.size(), 20'000U);
  EXPECT_TRUE(ReadTextFile(folder_ / "whole/probe_forces.csv").starts_with(replayed));
}

TEST_F(LiveReplay, AStepTakesNothingFromTheHeap) {
  Load({{"/effects/needle", {{"model", "bendable"}}},
        {"/effects/probe_force", {{"press_mm", 3.0}}},
        {"/effects/breathing", {{"motion", "motion"}}}});
  Recorder recorder(
      folder_ / "heap", "heap",
      {.needle = true, .probe = true, .breathing = true, .commands = true, .tracker = false},
      *scene_, kOriginNs, {}, context_);
  LiveCore core(*scene_, Settings(), &recorder, &*partner_);
  std::vector<DeviceReading> readings;
  for (int ms = 0; ms < 2000; ++ms) readings.push_back(ReadingAt(ms));
  for (int i = 0; i < 4; ++i) core.commands().Give(CommandKind::kMarkTarget);
  core.Tick(readings[0]);
  const long before = testing_support::num_allocations;
  for (int ms = 1; ms < 2000; ++ms) {
    PublishProbe(ms);
    core.Tick(readings[static_cast<std::size_t>(ms)]);
  }
  EXPECT_EQ(testing_support::num_allocations - before, 0);
  EXPECT_EQ(core.statistics().steps, 2000);
  EXPECT_EQ(core.statistics().step_cpu.count(), 2000);
}

TEST_F(LiveReplay, ForcesAreInTheFrameOfTheDeviceAndAboutItsHandle) {
  Load({});
  CoreSettings settings = Settings();
  settings.other.reset();
  LiveCore straight(*scene_, settings, nullptr, nullptr);
  // The same tool path, on a device that stands askew and holds the tool otherwise.
  Eigen::Isometry3d askew = Eigen::Isometry3d::Identity();
  askew.linear() =
      Eigen::AngleAxisd(1.3, Eigen::Vector3d(1, -2, 0.5).normalized()).toRotationMatrix();
  askew.translation() << 30, -500, 12;
  Eigen::Isometry3d grip = Eigen::Isometry3d::Identity();
  grip.linear() = Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitX()).toRotationMatrix();
  grip.translation() << 5, 6, 70;
  const Eigen::Isometry3d old_grip = settings.servo.handle_from_tool;
  settings.servo = {.reference_from_device = askew, .handle_from_tool = grip};
  LiveCore turned(*scene_, settings, nullptr, nullptr);
  double largest_n = 0.0;
  for (int ms = 0; ms < 1500; ++ms) {
    const DeviceReading reading = ReadingAt(ms);
    DeviceReading other = reading;
    other.device_from_handle =
        askew.inverse() * reading.device_from_handle * old_grip * grip.inverse();
    const haptics::DeviceForce a = straight.Tick(reading);
    const haptics::DeviceForce b = turned.Tick(other);
    ASSERT_LT((askew.linear() * b.force_n - a.force_n).norm(), 1e-6) << ms;
    // The same wrench: torques about the tips agree.
    const auto about_tip = [](const haptics::DeviceForce& force, const DeviceReading& at,
                              const Eigen::Isometry3d& tool) -> Eigen::Vector3d {
      const Eigen::Vector3d arm = at.device_from_handle.linear() * tool.translation();
      return force.torque_nmm - arm.cross(force.force_n);
    };
    ASSERT_LT((askew.linear() * about_tip(b, other, grip) - about_tip(a, reading, old_grip)).norm(),
              1e-4)
        << ms;
    largest_n = std::max(largest_n, a.force_n.norm());
  }
  EXPECT_GT(largest_n, 0.5);
}

TEST_F(LiveReplay, AReadingThatIsNotLaterMakesNoStepAndPausedForcesAreNone) {
  Load({{"/effects/needle_force/table", "forces/bovine_2021.json"}});  // Without relaxation.
  CoreSettings settings = Settings();
  LiveCore core(*scene_, settings, nullptr, nullptr);
  haptics::DeviceForce force;
  for (int ms = 0; ms < 1000; ++ms) force = core.Tick(ReadingAt(ms < 900 ? ms : ms + 60));
  EXPECT_GT(force.force_n.norm(), 0.1);
  // A hand that moves evenly feels next to no buzzing; membranes give way, hence some.
  EXPECT_GT(core.statistics().needle_chatter_n, 0.0);
  EXPECT_LT(core.statistics().needle_chatter_n, 0.2 * force.force_n.norm());
  EXPECT_EQ(core.Tick(ReadingAt(500)).force_n, Eigen::Vector3d::Zero());
  EXPECT_EQ(core.statistics().time_back, 1);
  EXPECT_EQ(core.statistics().steps, 1000);
  DeviceReading rubbish = ReadingAt(1080);
  rubbish.device_from_handle.linear()(1, 1) = std::nan("");
  EXPECT_EQ(core.Tick(rubbish).force_n, Eigen::Vector3d::Zero());
  rubbish = ReadingAt(1081);
  rubbish.device_from_handle.linear().setZero();
  EXPECT_EQ(core.Tick(rubbish).force_n, Eigen::Vector3d::Zero());
  EXPECT_EQ(core.statistics().needle[static_cast<std::size_t>(PoseVerdict::kNotFinite)], 2);
  core.commands().Give(CommandKind::kPauseForces);
  EXPECT_EQ(core.Tick(ReadingAt(1100)).force_n, Eigen::Vector3d::Zero());
  core.commands().Give(CommandKind::kResumeForces);
  EXPECT_GT(core.Tick(ReadingAt(1101)).force_n.norm(), 0.1);
  // 60 ms at 900, 1059 to 1100: readings that did not come.
  EXPECT_NEAR(static_cast<double>(core.statistics().missed_by_machine), 60 + 40, 2.0);
}

}  // namespace
}  // namespace acus::live
