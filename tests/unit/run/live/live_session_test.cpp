// A whole session in this process: threads, trackers that fail, and how it ends.
#include "acus/run/live/live_session.h"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "acus/base/config/json_file.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/monotonic_time.h"
#include "acus/data/session/session_io.h"
#include "acus/data/volume/volume_io.h"
#include "acus/rig/tracking/igtl_source.h"
#include "acus/rig/tracking/pose_server.h"
#include "acus/rig/tracking/socket.h"
#include "support/facet_views.h"
#include "support/layered_folder.h"
#include "support/replay_folder.h"

namespace acus::live {
namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;
using testing::Contains;
using testing::Field;
using testing::HasSubstr;
using testing::Not;

Eigen::Isometry3d ProbeOnSkin() {
  Eigen::Isometry3d probe = Eigen::Isometry3d::Identity();
  probe.linear() << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  probe.translation() << 0.0, 20.0, 2.0;
  return probe;
}

class Session : public testing_support::ReplayFolder {
 protected:
  void SetUp() override {
    testing_support::WriteLayeredFolder(
        folder_, R"({"needle_force": {}, "probe_force": {"press_mm": 5}, "ct_slice": {}})");
  }

  /// A virtual needle and a tracked probe.
  LiveDevices Devices(int port) {
    WriteTextFile(folder_ / "devices.json",
                  Message(R"({"format": "acus-devices/1", "devices": [{"name": "right",
      "driver": "virtual_hand", "virtual_hand": {"repeats": true, "path": [
        {"time_s": 0, "translation_mm": [0, 20, -5]}, {"time_s": 1, "translation_mm": [0, 20, 20]},
        {"time_s": 2, "translation_mm": [0, 20, -5]}]}}],
      "needle": {"device": "right"},
      "trackers": [{"name": "tracker", "port": )",
                          port, R"(, "tools": [
        {"tool": "probe", "device": "ProbeToReference"}]}]})"));
    return ReadLiveDevices(folder_ / "devices.json");
  }

  /// Polls until `done`, sending the probe's pose while `sends`.
  void PollUntil(LiveSession& session, tracking::PoseServer& server,
                 const std::function<bool()>& done) {
    const std::int64_t give_up_ns = MonotonicNs() + 30'000'000'000;
    while (!done() && MonotonicNs() < give_up_ns && session.Poll()) {
      if (sends_) {
        server.SendPoses(
            std::vector<tracking::NamedPose>{
                {.name = "ProbeToReference", .reference_from_tool = pose_, .valid = true}},
            MonotonicNs());
        if (video_.width > 0) server.SendImage("Video", video_, MonotonicNs());
      }
      if (session.images().Refresh()) {
        snapshot_ = session.images().Front().snapshot;
        probe_ = session.images().Front().probe;
        width_px_ = session.images().Front().images.ct_slice.width;
        const auto& effects = session.images().Front().effects;
        if (!effects.empty()) fluoroscopy_ = effects.front().pixels.gray;
      }
      std::this_thread::sleep_for(milliseconds(10));
    }
    EXPECT_TRUE(done());
  }

  bool sends_ = true;
  Eigen::Isometry3d pose_ = ProbeOnSkin();
  LiveSnapshot snapshot_;
  std::shared_ptr<const acoustics::Probe> probe_;
  int width_px_ = 0;
  image::GrayImage fluoroscopy_;
  tracking::Image video_;  ///< What a camera sees, if there is one.
};

TEST_F(Session, SaysThatBoneStopsTheNeedle) {
  WriteTextFile(folder_ / "devices.json", R"({"format": "acus-devices/1", "devices": [
      {"name": "right", "driver": "virtual_hand", "virtual_hand": {"path": [
        {"time_s": 0, "translation_mm": [0, 20, -5]}, {"time_s": 0.7, "translation_mm": [0, 20, 90]}]}},
      {"name": "left", "driver": "virtual_hand"}],
      "needle": {"device": "right"}, "probe": {"device": "left"}})");
  LiveOptions options;
  options.session_folder = folder_ / "session";
  options.duration_s = 1.2;
  LiveSession session(scenario::ReadScenario(folder_ / "scene.json", {}),
                      ReadLiveDevices(folder_ / "devices.json"), options, context_);
  session.Start();
  EXPECT_THAT(session.Status(), Not(Contains(Field(&StatusLine::text, HasSubstr("Bone:")))));
  EXPECT_TRUE(session.HeldBy(/*needle=*/true).may_advance);
  while (session.Poll() && session.HeldBy(true).may_advance) {
    std::this_thread::sleep_for(milliseconds(5));
  }
  EXPECT_THAT(session.Status(), Contains(Field(&StatusLine::text, HasSubstr("Bone: the needle"))));
  EXPECT_TRUE(session.HeldBy(/*needle=*/false).may_advance);
  while (session.Poll()) std::this_thread::sleep_for(milliseconds(20));
  session.Stop();
}

TEST_F(Session, HasTheGoalsAndStepsOfItsReport) {
  WriteTextFile(folder_ / "devices.json", R"({"format": "acus-devices/1", "devices": [
      {"name": "right", "driver": "virtual_hand", "virtual_hand": {"path": [
        {"time_s": 0, "translation_mm": [0, 20, -5]}, {"time_s": 1, "translation_mm": [0, 20, 20]},
        {"time_s": 2, "translation_mm": [0, 20, 8]}, {"time_s": 3, "translation_mm": [0, 20, 18]}]}},
      {"name": "left", "driver": "virtual_hand", "reference_from_device": {
         "translation_mm": [0, 20, -15], "quaternion_wxyz": [0.7071067811865476, 0.7071067811865476, 0, 0]}}],
      "needle": {"device": "right"}, "probe": {"device": "left"}})");
  WriteTextFile(folder_ / "target.csv", "name,x_mm,y_mm,z_mm\ntarget,0,20,18\n");
  WriteTextFile(folder_ / "exercise.json", R"({"format": "acus-exercise/1", "name": "Deep",
      "target": {"file": "target.csv", "radius_mm": 2},
      "goals": [{"metric": "tip to target at the end", "at_most": 3},
                {"metric": "tip to target, closest", "at_most": 3},
                {"metric": "needle elapsed time", "at_most": 100},
                {"metric": "needle path length", "at_most": 100},
                {"metric": "probe path length", "at_most": 100},
                {"metric": "needle time in tissue", "at_most": 100},
                {"metric": "tissue damage", "at_most": 100},
                {"metric": "attempts", "at_most": 1}, {"metric": "redirections", "at_most": 0},
                {"metric": "needle in the image plane", "at_least": 50},
                {"metric": "largest axial force", "at_most": 9},
                {"metric": "time until the target was reached", "at_most": 2},
                {"metric": "entries into what is to be spared", "at_most": 0},
                {"metric": "largest probe force", "at_most": 9}],
      "checklist": {"order": "free", "steps": [{"text": "Probe", "when": "probe_on_skin"},
                              {"text": "Needle", "when": "needle_in_tissue"},
                              {"text": "Reach", "when": "target_reached"},
                              {"text": "Out", "when": "needle_withdrawn"}]}})");
  LiveOptions options;
  options.session_folder = folder_ / "session";
  options.duration_s = 5.3;  // The rate of images is that of the last 5 s.
  options.exercise = training::ReadExercise(folder_ / "exercise.json");
  const auto scenario = scenario::ReadScenario(folder_ / "scene.json", {});
  LiveSession session(scenario, ReadLiveDevices(folder_ / "devices.json"), options, context_);
  EXPECT_TRUE(RunHeadless(session, context_));
  EXPECT_GT(session.recent_images_per_s(), 1.0);
  EXPECT_THAT(session.SummaryText(), Not(HasSubstr("could not be made")));

  replay::ReplayOptions replay;
  replay.run_folder = folder_ / "run";
  replay.exercise = folder_ / "exercise.json";
  RunContext context;
  replay::ReplaySession(scenario, folder_ / "session", replay, context);
  const auto report = config::ReadJson(folder_ / "run/training.json");
  const auto live = config::ReadJson(folder_ / "session/summary.json").at("exercise");
  ASSERT_EQ(live.at("goals").size(), report.at("goals").size());
  for (std::size_t i = 0; i < live.at("goals").size(); ++i) {
    EXPECT_EQ(live.at("goals")[i].at("metric"), report.at("goals")[i].at("metric"));
    EXPECT_EQ(live.at("goals")[i].at("value"), report.at("goals")[i].at("value"))
        << live.at("goals")[i];
    EXPECT_EQ(live.at("goals")[i].at("met"), report.at("goals")[i].at("met"));
  }
  EXPECT_EQ(live.at("checklist"), report.at("checklist"));
  EXPECT_EQ(live.at("checklist")[0].at("state"), "done") << "the probe begins on the skin";
  EXPECT_EQ(live.at("checklist")[2].at("state"), "done");
  EXPECT_EQ(live.at("checklist")[3].at("state"), "open");
}

TEST_F(Session, FollowsAnotherOnTheSameDevicesAndInTheSameScene) {
  tracking::PoseServer server({.name = "test", .host = "localhost", .port = 0});
  server.Start();
  const auto scenario = scenario::ReadScenario(folder_ / "scene.json", {});
  const auto rig = std::make_shared<Rig>(Devices(server.port()), Rig::Use::kManySessions);
  const auto scene =
      std::make_shared<const simulation::Scene>(LoadLiveScene(scenario, rig->devices(), context_));
  for (const char* name : {"first", "second"}) {
    LiveOptions options;
    options.session_folder = folder_ / name;
    LiveSession session(scenario, scene, rig, options, context_);
    session.Start();
    snapshot_ = {};
    PollUntil(session, server, [&] { return snapshot_.probe_force_n > 0.1; });
    PollUntil(session, server, [&] { return session.session_s() > 0.8; });
    session.Stop();
    EXPECT_TRUE(session.complete());
    // Between sessions the tracker goes on; nobody records it.
    for (int i = 0; i < 30; ++i) {
      server.SendPoses(
          std::vector<tracking::NamedPose>{
              {.name = "ProbeToReference", .reference_from_tool = pose_, .valid = true}},
          MonotonicNs());
      std::this_thread::sleep_for(milliseconds(5));
    }
    replay::ReplayOptions replay;
    replay.run_folder = folder_ / "run" / name;
    replay::ReplaySession(scenario, folder_ / name, replay, context_);
    EXPECT_EQ(ReadTextFile(folder_ / name / "forces.csv"),
              ReadTextFile(folder_ / "run" / name / "forces.csv"));
    EXPECT_EQ(ReadTextFile(folder_ / name / "probe_forces.csv"),
              ReadTextFile(folder_ / "run" / name / "probe_forces.csv"));
  }
  const auto tracker = [&](const char* name) {
    return config::ReadJson(folder_ / name / "summary.json").at("trackers").at(0);
  };
  EXPECT_EQ(tracker("first").at("connects"), 1);
  EXPECT_EQ(tracker("second").at("connects"), 0) << "the link stays";
  const std::string raw = ReadTextFile(folder_ / "second/tracker.csv");
  // But for what was on its way when the session ended.
  const long rows = std::ranges::count(raw, '\n') - 1;
  EXPECT_LE(std::abs(rows - tracker("second").at("readings").get<long>()), 3);
  EXPECT_EQ(raw.find("\n-"), std::string::npos) << "no reading of the time before";
}

TEST_F(Session, OutlivesItsTrackerAndReplaysToTheSameForces) {
  tracking::PoseServer server({.name = "test", .host = "localhost", .port = 0});
  server.Start();
  LiveOptions options;
  options.session_folder = folder_ / "s";
  LiveSession session(scenario::ReadScenario(folder_ / "scene.json", {}), Devices(server.port()),
                      options, context_);
  session.Start();
  const auto feels = [&] { return snapshot_.probe_force_n > 0.1; };
  PollUntil(session, server, feels);

  // Depth and gain are those of the images from now on; what makes no sense is held back.
  session.commands().Give(session::CommandKind::kDepth, 55.0);
  session.commands().Give(session::CommandKind::kGain, 1e9);
  PollUntil(session, server, [&] { return probe_ && probe_->depth_mm == 55.0; });
  PollUntil(session, server, [&] { return probe_->gain_db == 60.0; });
  EXPECT_GT(width_px_, 0);

  // A virtual hand holds the needle, and nobody the tracked probe.
  EXPECT_NE(session.HeldBy(/*needle=*/true).hand, nullptr);
  EXPECT_EQ(session.HeldBy(/*needle=*/false).hand, nullptr);
  EXPECT_EQ(session.force_limits().needle_n, 3.0);
  EXPECT_EQ(session.force_limits().probe_n, 0.0);
  EXPECT_EQ(session.video(), nullptr);

  // Silent: not seen, no force, and the screen says so.
  sends_ = false;
  PollUntil(session, server, [&] { return !snapshot_.moment.probe_valid; });
  EXPECT_EQ(snapshot_.probe_force_n, 0.0);
  EXPECT_THAT(session.Status(), Contains(Field(&StatusLine::text, HasSubstr("does not see"))));
  sends_ = true;
  PollUntil(session, server, feels);

  // A jump of 50 mm is not used; a probe that stays there is believed again.
  pose_.translation().x() += 50.0;
  PollUntil(session, server, [&] { return !snapshot_.moment.probe_valid; });
  EXPECT_EQ(snapshot_.probe_force_n, 0.0);
  pose_.translation().x() -= 50.0;
  PollUntil(session, server, feels);

  // Rubbish, then gone and back.
  const std::vector<std::uint8_t> rubbish(5000, 0xA7);
  server.SendRaw(rubbish);
  PollUntil(session, server, feels);
  server.Stop();
  sends_ = false;
  PollUntil(session, server, [&] { return !snapshot_.moment.probe_valid; });
  EXPECT_THAT(
      session.Status(),
      Contains(Field(&StatusLine::text, HasSubstr("The tracker tracker is not connected: "))));
  server.Start();
  sends_ = true;
  PollUntil(session, server, feels);

  session.Stop();
  EXPECT_EQ(session.end(), SessionEnd::kStopped);
  const auto summary = nlohmann::json::parse(ReadTextFile(folder_ / "s/summary.json"));
  EXPECT_EQ(summary.at("recording").at("steps_lost"), 0);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  // Sanitizers make a step take up to ten times as long.
  EXPECT_EQ(summary.at("steps").at("missed_by_computation"), 0);
#endif
  EXPECT_GE(summary.at("trackers").at(0).at("connects"), 2);
  EXPECT_GT(summary.at("steps").at("probe_readings").at("jumped"), 0);
  // What each stage did, and how often the probe was not there for it.
  for (const auto& stage : summary.at("effect_plan")) {
    if (stage.at("stage") == "probe force") {
      EXPECT_EQ(stage.at("runs"), session.statistics().steps.load());
      EXPECT_GT(stage.at("asleep_because").at("the tracker does not see the probe"), 0);
      EXPECT_GT(stage.at("seconds"), 0.0);
    }
    if (stage.at("stage") == "CT slice") {
      EXPECT_EQ(stage.at("runs"), session.image_statistics().images.load());
    }
  }

  replay::ReplayOptions replay;
  replay.run_folder = folder_ / "r";
  replay::ReplaySession(scenario::ReadScenario(folder_ / "scene.json", {}), folder_ / "s", replay,
                        context_);
  for (const char* file : {"forces.csv", "probe_forces.csv"}) {
    EXPECT_TRUE(ReadTextFile(folder_ / "s" / file) == ReadTextFile(folder_ / "r" / file)) << file;
  }
}

TEST_F(Session, ATrackedNeedleMakesTheSteps) {
  tracking::PoseServer server({.name = "test", .host = "localhost", .port = 0});
  server.Start();
  WriteTextFile(folder_ / "devices.json",
                Message(R"({"format": "acus-devices/1", "devices": [], "trackers": [
      {"port": )",
                        server.port(), R"(, "tools": [
        {"tool": "needle", "device": "ProbeToReference"}]}]})"));
  const std::vector<scenario::Override> changes = {{"/effects/probe_force", nullptr},
                                                   {"/effects/ct_slice", nullptr}};
  LiveOptions options;
  options.session_folder = folder_ / "s";
  LiveSession session(scenario::ReadScenario(folder_ / "scene.json", changes),
                      ReadLiveDevices(folder_ / "devices.json"), options, context_);
  session.Start();
  pose_ = Eigen::Isometry3d(Eigen::Translation3d(0.0, 20.0, -5.0));
  PollUntil(session, server, [&] {
    pose_.translation().z() = std::min(20.0, pose_.translation().z() + 0.2);
    return snapshot_.needle_force_n > 0.1;
  });
  sends_ = false;
  PollUntil(session, server, [&] { return !snapshot_.needle_valid; });
  EXPECT_EQ(snapshot_.needle_force_n, 0.0);
  session.Stop();
  EXPECT_GT(session.statistics().steps, 20);
  replay::ReplayOptions replay;
  replay.run_folder = folder_ / "r";
  replay::ReplaySession(scenario::ReadScenario(folder_ / "scene.json", changes), folder_ / "s",
                        replay, context_);
  EXPECT_TRUE(ReadTextFile(folder_ / "s/forces.csv") == ReadTextFile(folder_ / "r/forces.csv"));
}

// What 3D Slicer gets to see: the tools, and each image where its probe was.
TEST_F(Session, SendsPosesAndImagesOut) {
  tracking::PoseServer server({.name = "test", .host = "localhost", .port = 0});
  server.Start();
  const int port = tracking::PortOf(tracking::ListenTcp("127.0.0.1", 0));
  LiveDevices devices = Devices(server.port());
  devices.send_out = {.host = "localhost", .port = port};
  const std::vector<scenario::Override> b_mode = {{"/effects/ultrasound", nlohmann::json::object()},
                                                  {"/effects/ct_slice", nullptr}};
  LiveOptions options;
  options.session_folder = folder_ / "s";
  LiveSession session(scenario::ReadScenario(folder_ / "scene.json", b_mode), std::move(devices),
                      options, context_);
  session.Start();
  tracking::IgtlOptions watcher_options{.port = port,
                                        .tools = {{.tool = "needle", .device = "NeedleToReference"},
                                                  {.tool = "probe", .device = "ProbeToReference"}},
                                        .keep_images = true};
  tracking::IgtlSource watcher(watcher_options);
  watcher.Start();
  const auto image = [&] { return watcher.Image("Ultrasound"); };
  PollUntil(session, server, [&] {
    const auto& board = watcher.board();
    return probe_ && image() && board.Latest(0).valid && board.Latest(1).valid;
  });
  EXPECT_TRUE(
      watcher.board().Latest(1).reference_from_tool.isometry().isApprox(ProbeOnSkin(), 1e-6));
  EXPECT_NEAR(watcher.board().Latest(0).reference_from_tool.translation().y(), 20.0, 5.0);

  // A deeper image has larger pixels; its first row stays at the face. Images of before may
  // still be on the way.
  const auto expected = [&]() -> Eigen::Matrix4d {
    return ProbeOnSkin().matrix() * acoustics::ImageOf(*probe_).probe_from_image().matrix();
  };
  const auto is_in_place = [&] {
    return image()->image.reference_from_pixel.isApprox(expected(), 1e-5);
  };
  const auto expect_in_place = [&] {
    PollUntil(session, server, is_in_place);
    const auto sent = image();
    EXPECT_EQ(sent->image.width, probe_->image_width_px);
    EXPECT_EQ(sent->image.height, probe_->image_height_px);
    const auto [darkest, brightest] = std::ranges::minmax(sent->image.pixels);
    EXPECT_GT(brightest - darkest, 50);
    EXPECT_TRUE(is_in_place()) << sent->image.reference_from_pixel << "\n" << expected();
  };
  expect_in_place();
  session.commands().Give(session::CommandKind::kDepth, 90.0);
  PollUntil(session, server, [&] { return probe_->depth_mm == 90.0; });
  expect_in_place();
  session.Stop();
}

// One camera for a tool and for the overlay; its cable is pulled and put back.
TEST_F(Session, AProbeIsTrackedByACamera) {
  const camera::CameraModel model =
      camera::ReadCamera(testing_support::ConfigPath("cameras/micron_tracker_2010.json"));
  const camera::FacetSet set =
      camera::ReadFacets(testing_support::ConfigPath("facets/training.json"));
  const Eigen::Isometry3d mannequin = testing_support::FacingPose({0, -140, 900}, 20, 0, 0);
  const Eigen::Isometry3d object = testing_support::FacingPose({0, -60, 600}, 15, 20, 10) *
                                   Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX()) *
                                   Eigen::Translation3d(0, 110, 0);
  camera::Image seen;
  camera::MannequinCamera(model, set, {}, {.colour = false})
      .Render(std::vector<camera::ObjectInView>{{"Reference", mannequin}, {"Probe", object}}, 0,
              seen);
  video_ = {.width = seen.width_px, .height = seen.height_px, .channels = 1, .pixels = seen.pixels};
  tracking::PoseServer server({.name = "test", .host = "localhost", .port = 0});
  server.Start();
  // The calibration puts the probe's face where the patient is.
  const transforms::Pose from_object = (mannequin.inverse() * object).inverse() * ProbeOnSkin();
  const Eigen::Vector3d t = from_object.isometry().translation();
  const Eigen::Quaterniond& q = from_object.quaternion();
  WriteTextFile(folder_ / "devices.json",
                Message(R"({"format": "acus-devices/1", "devices": [],
      "camera": {"place": "igtl:localhost:)",
                        server.port(), R"(/Video", "model": "cameras/micron_tracker_2010.json",
        "facets": "facets/training.json", "tools": [{"tool": "probe", "object": "Probe",
        "translation_mm": [)",
                        t.x(), ",", t.y(), ",", t.z(), R"(], "quaternion_wxyz": [)", q.w(), ",",
                        q.x(), ",", q.y(), ",", q.z(), "]}]}}"));
  const std::vector<scenario::Override> without_needle = {{"/effects/needle_force", nullptr},
                                                          {"/effects/ct_slice/needle", false}};
  LiveOptions options;
  options.session_folder = folder_ / "s";
  LiveSession session(scenario::ReadScenario(folder_ / "scene.json", without_needle),
                      ReadLiveDevices(folder_ / "devices.json"), options, context_);
  session.Start();
  PollUntil(session, server, [&] { return snapshot_.moment.probe_valid && width_px_ > 0; });
  EXPECT_NE(session.video(), nullptr);
  const auto error = testing_support::ErrorOf(snapshot_.moment.ct_from_probe, ProbeOnSkin());
  EXPECT_LT(error.position_mm, 0.5);
  EXPECT_LT(error.angle_deg, 0.5);
  sends_ = false;
  PollUntil(session, server, [&] { return !snapshot_.moment.probe_valid; });
  EXPECT_THAT(session.Status(), Contains(Field(&StatusLine::text, HasSubstr("does not see"))));
  sends_ = true;
  PollUntil(session, server, [&] { return snapshot_.moment.probe_valid; });
  session.Stop();
  EXPECT_EQ(nlohmann::json::parse(ReadTextFile(folder_ / "s/summary.json"))
                .at("recording")
                .at("steps_lost"),
            0);
}

TEST_F(Session, FluoroscopyFollowsTheNeedle) {
  tracking::PoseServer server({.name = "test", .host = "localhost", .port = 0});
  server.Start();
  const std::vector<scenario::Override> c_arm = {{"/effects/fluoroscopy", nlohmann::json::object()},
                                                 {"/effects/probe_force", nullptr}};
  LiveOptions options;
  options.session_folder = folder_ / "s";
  LiveSession session(scenario::ReadScenario(folder_ / "scene.json", c_arm), Devices(server.port()),
                      options, context_);
  session.Start();
  PollUntil(session, server, [&] { return !fluoroscopy_.pixels.empty(); });
  const image::GrayImage first = fluoroscopy_;
  PollUntil(session, server, [&] { return fluoroscopy_.pixels != first.pixels; });
  // Only the needle moves: most of the image stays.
  int changed = 0;
  for (std::size_t i = 0; i < first.pixels.size(); ++i) {
    changed += first.pixels[i] != fluoroscopy_.pixels[i] ? 1 : 0;
  }
  EXPECT_LT(changed, static_cast<int>(first.pixels.size()) / 10);
  session.Stop();
}

TEST_F(Session, ThatCannotBeginLeavesNothingRunning) {
  LiveOptions options;
  options.session_folder = folder_ / "s";
  WriteTextFile(folder_ / "s", "a file is in the way");
  LiveSession session(scenario::ReadScenario(folder_ / "scene.json", {}), Devices(1), options,
                      context_);
  EXPECT_THROW(session.Start(), InputError);
  EXPECT_EQ(ReadTextFile(folder_ / "s"), "a file is in the way");
}

}  // namespace
}  // namespace acus::live
