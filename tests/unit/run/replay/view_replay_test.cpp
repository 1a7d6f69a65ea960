#include <gmock/gmock.h>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "acus/data/session/session_io.h"
#include "acus/data/volume/volume_io.h"
#include "acus/physics/breathing/motion_file.h"
#include "acus/run/replay/replay.h"
#include "support/layered_scene.h"
#include "support/replay_folder.h"

namespace acus::replay {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

/// A layered patient, a needle above him for a second, and a view of both, on disk.
class ViewReplay : public testing_support::ReplayFolder {
 protected:
  void SetUp() override {
    const auto scene =
        testing_support::LayeredScene(testing_support::PlanOf(true, true, true, true), true);
    volume::WriteCt(folder_ / "ct.nrrd", *scene.ct);
    volume::WriteLabelMap(folder_ / "labels.seg.nrrd", *scene.labels);
    session::Session session;
    session.name = "above";
    for (int ms = 0; ms < 1000; ++ms) {
      session::PoseSample needle{.time_ns = ms * std::int64_t{1'000'000}};
      needle.reference_from_tool = Eigen::Isometry3d(Eigen::Translation3d(0.0, 20.0, 0.03 * ms));
      session.needle.push_back(needle);
    }
    session::WriteSession(folder_ / "session", session, context_);
    WriteTextFile(folder_ / "scene.json", R"({"format": "acus-scenario/1", "name": "Layers",
      "patient": {"labels": "labels.seg.nrrd",
        "ct_from_reference": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]},
      "effects": {"view_3d": {"width_px": 96, "height_px": 64, "rate_hz": 3, "probe": false}},
      "image_rate_hz": 10})");
    setenv("ACUS_CONFIGS", (fs::path(ACUS_SOURCE_DIR) / "configs").c_str(), 1);
  }
};

TEST_F(ViewReplay, NeedsNeitherProbeNorCtAndGivesTheSameBytesOnMoreThreads) {
  const ReplayResult result = Run("one", 1);
  Run("two", 2);
  EXPECT_THAT(result.plan_text, HasSubstr("view in 3D"));
  for (const char* name : {"view_3d.mp4", "view_3d.png"}) {
    EXPECT_EQ(ReadTextFile(folder_ / "one" / name), ReadTextFile(folder_ / "two" / name)) << name;
  }
  EXPECT_THAT(ReadTextFile(folder_ / "one/report.html"), HasSubstr("view_3d.mp4"));
  EXPECT_FALSE(fs::exists(folder_ / "one/film.mp4"));
  EXPECT_FALSE(fs::exists(folder_ / "one/images.igs.mha"));
}

TEST_F(ViewReplay, ShowsTheCtIfALayerRequestsIt) {
  const std::vector<scenario::Override> bone = {
      {"/effects/view_3d/layers", nlohmann::json::array({nlohmann::json{{"preset", "bone"}}})}};
  EXPECT_THAT([&] { Run(nullptr, 1, bone); }, ThrowsMessage<InputError>(HasSubstr("/patient/ct")));
  Run("surfaces", 1);
  std::vector<scenario::Override> with_ct = bone;
  with_ct.push_back({"/patient/ct", (folder_ / "ct.nrrd").string()});
  Run("layers", 1, with_ct);
  EXPECT_NE(ReadTextFile(folder_ / "layers/view_3d.png"),
            ReadTextFile(folder_ / "surfaces/view_3d.png"));
}

TEST_F(ViewReplay, ShowsTheLargestValuesOfTheCtInAWindow) {
  std::vector<scenario::Override> maximum = {
      {"/effects/view_3d/projection", "maximum"},
      {"/effects/view_3d/surfaces", nlohmann::json::array()}};
  EXPECT_THAT([&] { Run(nullptr, 1, maximum); },
              ThrowsMessage<InputError>(HasSubstr("/patient/ct")));
  maximum.push_back({"/patient/ct", (folder_ / "ct.nrrd").string()});
  Run("bone", 1, maximum);
  Run("bone_2", 2, maximum);
  maximum.push_back({"/effects/view_3d/window_hu", {-200, 200}});
  Run("body", 1, maximum);
  const std::string bone = ReadTextFile(folder_ / "bone/view_3d.png");
  EXPECT_EQ(bone, ReadTextFile(folder_ / "bone_2/view_3d.png"));
  EXPECT_NE(bone, ReadTextFile(folder_ / "body/view_3d.png"));
}

TEST_F(ViewReplay, BreathesWithThePatientUnlessHeldAtRest) {
  volume::Geometry nodes;
  nodes.size.setConstant(2);
  nodes.spacing_mm.setConstant(200.0);
  nodes.origin_mm.setConstant(-100.0);
  breathing::MotionField field(nodes, 1);
  std::vector<float> values(3 * nodes.num_voxels(), 0.0F);
  for (std::size_t n = 2; n < values.size(); n += 3) values[n] = -20.0F;
  field.SetComponent(0, values);
  fs::create_directories(folder_ / "motion");
  breathing::WritePatientMotion(
      folder_ / "motion",
      {.name = "down", .model = breathing::MotionModel::Sinusoid(std::move(field), 1.0)});
  const auto with = [](double amplitude) {
    const nlohmann::json effect = {{"motion", "motion"}, {"amplitude", amplitude}};
    return std::vector<scenario::Override>{{"/effects/breathing", effect}};
  };
  Run("never", 1);
  const ReplayResult result = Run("moved", 1, with(1.0));
  Run("held", 1, with(0.0));
  EXPECT_THAT(result.plan_text, HasSubstr("breathing"));
  const std::string never = ReadTextFile(folder_ / "never/view_3d.mp4");
  EXPECT_NE(ReadTextFile(folder_ / "moved/view_3d.mp4"), never);
  EXPECT_EQ(ReadTextFile(folder_ / "held/view_3d.mp4"), never);
}

TEST_F(ViewReplay, EveryEventHasAStillInTheReport) {
  const std::vector<scenario::Override> force = {
      {"/effects/needle_force", nlohmann::json::object()}};
  Run("force", 1, force);
  const std::string events = ReadTextFile(folder_ / "force/events.csv");
  ASSERT_THAT(events, HasSubstr("puncture"));
  ASSERT_TRUE(fs::exists(folder_ / "force/view_3d_event_01.png"));
  EXPECT_THAT(ReadTextFile(folder_ / "force/report.html"),
              HasSubstr("three dimensions: puncture at"));
  std::vector<scenario::Override> without = force;
  without.push_back({"/effects/view_3d/event_stills", false});
  Run("without", 1, without);
  EXPECT_FALSE(fs::exists(folder_ / "without/view_3d_event_01.png"));
  EXPECT_EQ(ReadTextFile(folder_ / "without/view_3d.mp4"),
            ReadTextFile(folder_ / "force/view_3d.mp4"));
}

TEST_F(ViewReplay, TheCameraFollowsItsPathAndRestIsBeside) {
  Run("still", 1);
  const std::vector<scenario::Override> path = {
      {"/effects/view_3d/camera_path", "camera_paths/turntable.json"}};
  Run("turned", 1, path);
  Run("turned_2", 2, path);
  const std::string turned = ReadTextFile(folder_ / "turned/view_3d.mp4");
  EXPECT_NE(turned, ReadTextFile(folder_ / "still/view_3d.mp4"));
  EXPECT_EQ(turned, ReadTextFile(folder_ / "turned_2/view_3d.mp4"));
  EXPECT_THAT(ReadTextFile(folder_ / "turned/provenance.json"), HasSubstr("turntable.json"));
  Run("beside", 1, {{"/effects/view_3d/beside", "rest"}});
  EXPECT_NE(ReadTextFile(folder_ / "beside/view_3d.png"),
            ReadTextFile(folder_ / "still/view_3d.png"));
  EXPECT_THAT(
      [&] {
        Run(nullptr, 1, {{"/effects/view_3d/camera_path", "none.json"}});
      },
      ThrowsMessage<InputError>(HasSubstr("none.json")));
}

TEST_F(ViewReplay, SaysWhatDoesNotFit) {
  const auto with = [this](const char* place, const nlohmann::json& value) {
    return [this, place, value] {
      const std::vector<scenario::Override> change = {{place, value}};
      Run(nullptr, 1, change);
    };
  };
  const auto tissue = [](const char* name) {
    return nlohmann::json::array({nlohmann::json{{"tissue", name}}});
  };
  EXPECT_THAT(with("/effects/view_3d/probe", true),
              ThrowsMessage<InputError>(HasSubstr("no probe stream")));
  EXPECT_THAT(with("/effects/view_3d/surfaces", tissue("livr")),
              ThrowsMessage<InputError>(HasSubstr("did you mean 'liver'")));
  EXPECT_THAT(with("/effects/view_3d/surfaces", tissue("heart")),
              ThrowsMessage<InputError>(HasSubstr("none of the tissues")));
  EXPECT_THAT(with("/effects/view_3d/surfaces", nlohmann::json::array()),
              ThrowsMessage<InputError>(HasSubstr("nothing to show")));
  EXPECT_THAT(with("/effects/view_3d/camera/eye_mm", nlohmann::json::array({0, 0, 0})),
              ThrowsMessage<InputError>(HasSubstr("go together")));
  EXPECT_THAT(
      with("/effects/view_3d/window_hu", {1000, 100}),
      ThrowsMessage<InputError>(AllOf(HasSubstr("/effects/view_3d/window_hu: from 1000 to 100 HU"),
                                      HasSubstr("the first must be below the second"))));
  EXPECT_THAT(with("/effects/view_3d/window_hu", {300, 300}),
              ThrowsMessage<InputError>(HasSubstr("below the second")));
  EXPECT_THAT(with("/effects/view_3d/window_hu", {0, 5000}),
              ThrowsMessage<InputError>(HasSubstr("3071")));
  EXPECT_THAT(with("/effects/view_3d/projection", "mean"),
              ThrowsMessage<InputError>(AllOf(HasSubstr("emission"), HasSubstr("maximum"))));
  EXPECT_THAT(with("/effects/view_3d/supersampling", 3),
              ThrowsMessage<InputError>(HasSubstr("supersampling")));
}

}  // namespace
}  // namespace acus::replay
