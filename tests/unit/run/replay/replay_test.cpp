#include "acus/run/replay/replay.h"

#include <gmock/gmock.h>
#include <set>

#include "acus/base/config/json_file.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/csv.h"
#include "acus/base/core/error.h"
#include "acus/base/math/rigid.h"
#include "acus/data/session/sequence_file.h"
#include "acus/data/session/session_io.h"
#include "acus/data/transforms/landmarks.h"
#include "acus/data/volume/volume_io.h"
#include "acus/run/replay/markups.h"
#include "support/layered_folder.h"
#include "support/replay_folder.h"

namespace acus::replay {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

/// A layered patient, a scripted session of three seconds and a scenario, on disk.
class Replay : public testing_support::ReplayFolder {
 protected:
  void SetUp() override {
    testing_support::WriteLayeredFolder(
        folder_, R"({"needle_force": {}, "ultrasound": {}, "ct_slice": {}})", 10);
    session::WriteSession(folder_ / "session", InsertionToBone(), context_);
  }

  /// In at 25 mm/s to 2 mm into bone at 61 mm, half a second there, out again.
  static session::Session InsertionToBone() {
    session::Session session;
    session.name = "to bone";
    for (int ms = 0; ms < 6000; ++ms) {
      const double z_mm = ms < 2720   ? -5.0 + 0.025 * ms
                          : ms < 3200 ? 63.0
                                      : 63.0 - 0.025 * (ms - 3200);
      session::PoseSample needle{.time_ns = ms * std::int64_t{1'000'000}};
      needle.reference_from_tool = Eigen::Isometry3d(Eigen::Translation3d(0.0, 20.0, z_mm));
      session.needle.push_back(needle);
      if (ms % 20 != 0) continue;
      Eigen::Isometry3d probe = Eigen::Isometry3d::Identity();
      probe.linear() << 1, 0, 0, 0, 0, -1, 0, 1, 0;
      probe.translation() << 0.0, 20.0 + 1e-3 * ms, -0.5;
      session.probe.push_back({needle.time_ns, probe, true});
    }
    return session;
  }
};

TEST_F(Replay, EvidenceInTheScenarioChangesNoByteButIsHeldAgainstWhatIsMeasured) {
  const std::vector<scenario::Override> evidence = {scenario::ParseOverride(
      R"(/evidence={"asked": "--budget force=1ms", "machine": "another one",)"
      R"( "measured": {"step_us_median": 1, "image_ms_median": 5, "image_ms_p95": 8}})")};
  Run("without", 2);
  const replay::ReplayResult with = Run("with", 2, evidence);
  int compared = 0;
  for (const auto& entry : fs::directory_iterator(folder_ / "without")) {
    const fs::path name = entry.path().filename();
    if (name == "run.json" || name == "report.html") continue;
    EXPECT_EQ(ReadTextFile(entry.path()), ReadTextFile(folder_ / "with" / name)) << name;
    ++compared;
  }
  EXPECT_GE(compared, 6);
  EXPECT_THAT(with.summary, AllOf(HasSubstr("--budget force=1ms, predicted on another one"),
                                  HasSubstr("image, median: "), HasSubstr("another machine")));
  EXPECT_THAT(ReadTextFile(folder_ / "with" / "report.html"), HasSubstr("predicted 5 ms"));
  const auto run = config::ReadJson(folder_ / "with" / "run.json");
  const auto& check = run.at("cost_check");
  EXPECT_EQ(check.at("predicted").at("image_ms_p95"), 8);
  EXPECT_GT(check.at("measured").at("step_us_median"), 0.0);
  EXPECT_GT(check.at("measured").at("image_ms_median"), 0.0);
  EXPECT_FALSE(config::ReadJson(folder_ / "without" / "run.json").contains("cost_check"));
}

TEST_F(Replay, GivesTheSameBytesAgainAndWithMoreThreads) {
  Run("one", 1);
  Run("again", 1);
  Run("two", 2);
  int compared = 0;
  for (const auto& entry : fs::directory_iterator(folder_ / "one")) {
    const fs::path name = entry.path().filename();
    // Timings are in these two; provenance names the run's own folder nowhere.
    if (name == "run.json" || name == "report.html") continue;
    const std::string first = ReadTextFile(entry.path());
    EXPECT_EQ(first, ReadTextFile(folder_ / "again" / name)) << name;
    EXPECT_EQ(first, ReadTextFile(folder_ / "two" / name)) << name;
    ++compared;
  }
  EXPECT_GE(compared, 6);
}

TEST_F(Replay, ThatFailsLeavesTheCallersWarningsAsTheyWere) {
  std::vector<std::string> heard;
  RunContext context;
  context.on_warning = [&heard](std::string_view text) { heard.emplace_back(text); };
  const auto scenario = scenario::ReadScenario(
      folder_ / "scene.json", std::vector<scenario::Override>{{"/patient/ct", nullptr}});
  EXPECT_THROW(ReplaySession(scenario, folder_ / "session", {}, context), InputError);
  heard.clear();
  context.Warn("after");
  EXPECT_EQ(heard, std::vector<std::string>{"after"});
}

TEST_F(Replay, RefusesASessionInAnotherFrameWithoutRegistration) {
  const auto replays = [this](const std::vector<scenario::Override>& changes) {
    context_.overwrite = true;
    ReplayOptions options;
    options.run_folder = folder_ / "run";
    ReplaySession(scenario::ReadScenario(folder_ / "scene.json", changes), folder_ / "session",
                  options, context_);
  };
  std::vector<scenario::Override> changes = {{"/effects/ultrasound", nullptr},
                                             {"/patient/ct_from_reference", nullptr}};
  EXPECT_THAT([&] { replays(changes); },
              testing::ThrowsMessage<InputError>(
                  testing::AllOf(HasSubstr("in the frame Reference"), HasSubstr("--transform FILE"),
                                 HasSubstr("--transform identity"))));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "run"));
  // It may be stated that the frames are one, as --transform identity does.
  changes.push_back({"/patient/ct_from_reference_file", "identity"});
  EXPECT_NO_THROW(replays(changes));
  EXPECT_TRUE(config::ReadJson(folder_ / "run/run.json").at("warnings").empty());
}

TEST_F(Replay, LogsAndDrawsANeedleThatBends) {
  Run("plain", 2);
  const CsvTable plain(folder_ / "plain/forces.csv");
  EXPECT_FALSE(plain.Has("deflection_mm"));
  const std::string about = "Shape of the needle";
  EXPECT_EQ(ReadTextFile(folder_ / "plain/report.html").find(about), std::string::npos);

  WriteTextFile(folder_ / "bevel.json", R"({"format": "acus-needle/1", "name": "bevel",
    "gauge": 22, "outer_diameter_mm": 0.72, "inner_diameter_mm": 0.41, "length_mm": 90,
    "bevel_curvature_per_mm": 0.004})");
  const std::vector<scenario::Override> bends = {{"/effects/needle", {{"model", "bendable"}}},
                                                 {"/needle", "bevel.json"}};
  const ReplayResult result = Run("bent", 2, bends);
  EXPECT_THAT(result.plan_text, HasSubstr("needle shape"));
  const CsvTable bent(folder_ / "bent/forces.csv");
  const auto depth_mm = bent.Numbers("depth_mm");
  const auto deflection_mm = bent.Numbers("deflection_mm");
  const auto tip_x_mm = bent.Numbers("tip_x_mm");
  const auto tip_z_mm = bent.Numbers("tip_z_mm");
  EXPECT_EQ(deflection_mm[0], 0.0);
  EXPECT_EQ(tip_z_mm[0], -5.0);
  const double largest_mm = *std::ranges::max_element(deflection_mm);
  // The circle of the bevel at the greatest depth, from which the tissue holds it back a little.
  const double deepest_mm = *std::ranges::max_element(depth_mm);
  const double aside_mm = 250.0 * (1.0 - std::cos(deepest_mm / 250.0));
  EXPECT_GT(aside_mm, 5.0);
  EXPECT_NEAR(*std::ranges::max_element(tip_x_mm), aside_mm, 0.15 * aside_mm);
  EXPECT_GT(largest_mm, 1.0);
  EXPECT_EQ(deflection_mm.back(), 0.0);  // Out again.
  for (const char* axis : {"torque_x_n_mm", "torque_y_n_mm", "torque_z_n_mm"}) {
    EXPECT_TRUE(bent.Has(axis));
  }
  EXPECT_NE(ReadTextFile(folder_ / "bent/report.html").find(about), std::string::npos);
  EXPECT_NE(ReadTextFile(folder_ / "bent/metrics.json").find("largest tip deflection"),
            std::string::npos);
  // The same bytes with one thread, images and all.
  Run("again", 1, bends);
  for (const char* name : {"forces.csv", "images.igs.mha", "metrics.json"}) {
    EXPECT_EQ(ReadTextFile(folder_ / "bent" / name), ReadTextFile(folder_ / "again" / name));
  }
  EXPECT_NE(ReadTextFile(folder_ / "bent/images.igs.mha"),
            ReadTextFile(folder_ / "plain/images.igs.mha"));
}

TEST_F(Replay, LogsWhatTheNeedleMeets) {
  Run("run", 2);
  const CsvTable forces(folder_ / "run/forces.csv");
  ASSERT_EQ(forces.num_rows(), 6000U);
  const auto axial_n = forces.Numbers("force_axial_n");
  const auto z_force_n = forces.Numbers("force_z_n");
  const auto bone_n = forces.Numbers("bone_n");
  const auto lateral_n = forces.Numbers("lateral_n");
  const auto events = forces.Texts("event");
  const auto tissues = forces.Texts("tissue");
  for (std::size_t row = 0; row < axial_n.size(); ++row) {
    // The needle points along +z: a force that pushes it out points along -z.
    ASSERT_NEAR(z_force_n[row], -axial_n[row], 1e-9 + lateral_n[row]) << row;
  }
  EXPECT_EQ(*std::ranges::max_element(std::span(axial_n).first(190)), 0.0);  // Still in the air.
  EXPECT_GT(bone_n[3000], 1.0);
  EXPECT_EQ(bone_n[4500], 0.0);
  EXPECT_LT(axial_n[4500], 0.0);  // Friction holds a needle that is drawn out.
  EXPECT_EQ(axial_n[5999], 0.0);
  EXPECT_EQ(tissues[3000], "bone");
  EXPECT_EQ(tissues[0], "outside");
  const auto count = [&events](const char* name) { return std::ranges::count(events, name); };
  EXPECT_EQ(count("contact"), 1);
  EXPECT_GE(count("puncture"), 1);
  EXPECT_EQ(count("bone_contact"), 1);
  EXPECT_EQ(count("withdrawal"), 1);
}

TEST_F(Replay, WritesWhereThingsHappenedAndWhereTheTipWasToGo) {
  WriteTextFile(folder_ / "corridor.csv", "name,x_mm,y_mm,z_mm\ntarget,0,20,50\nentry,0,20,0\n");
  Run("run", 1, {{"/patient/corridor", (folder_ / "corridor.csv").string()}});
  const auto points = transforms::ReadLandmarks(folder_ / "run" / kEventMarkups);
  const CsvTable events(folder_ / "run/events.csv");
  ASSERT_EQ(points.names.size(), events.num_rows());
  const auto time_s = events.Numbers("time_s");
  for (std::size_t i = 0; i < points.names.size(); ++i) {
    EXPECT_EQ(points.names[i],
              Message(i + 1, " ", events.Texts("event")[i], " ", events.Texts("tissue")[i]));
    const double ms = 1e3 * time_s[i];
    const double z_mm = ms < 2720 ? -5.0 + 0.025 * ms : 63.0 - 0.025 * (ms - 3200);
    EXPECT_LT(
        (points.points_mm.col(static_cast<Eigen::Index>(i)) - Eigen::Vector3d(0.0, 20.0, z_mm))
            .norm(),
        1e-6)
        << points.names[i];
  }
  const auto targets = transforms::ReadLandmarks(folder_ / "run" / kTargetMarkups);
  EXPECT_THAT(targets.names, testing::ElementsAre("entry", "target"));
  EXPECT_EQ(targets.points_mm.col(1), Eigen::Vector3d(0, 20, 50));
}

TEST_F(Replay, FramesHaveTheirPlace) {
  Run("run", 1);
  session::SequenceFile sequence(folder_ / "run/images.igs.mha");
  const auto probe_from_image =
      session::NumbersOf(*sequence.header().Field("ImageToProbeTransform"));
  ASSERT_TRUE(probe_from_image && probe_from_image->size() == 16);
  using Matrix = Eigen::Matrix<double, 4, 4, Eigen::RowMajor>;
  for (const std::size_t frame : {std::size_t{0}, sequence.num_frames() - 1}) {
    const auto matrix = [&](const char* name) {
      const auto numbers = session::NumbersOf(*sequence.header().Field(frame, name));
      return Matrix(Eigen::Map<const Matrix>(numbers->data()));
    };
    EXPECT_TRUE(matrix("ImageToReferenceTransform")
                    .isApprox(matrix("ProbeToReferenceTransform") *
                                  Eigen::Map<const Matrix>(probe_from_image->data()),
                              1e-12));
    EXPECT_EQ(sequence.header().Field(frame, "ImageToReferenceTransformStatus"), "OK");
  }
}

TEST_F(Replay, ReportsWhenTheStepsOfAChecklistWereDone) {
  WriteTextFile(folder_ / "exercise.json", R"({"format": "acus-exercise/1", "name": "In",
    "checklist": {"order": "free", "steps": [{"text": "Needle", "when": "needle_in_tissue"}]}})");
  const std::vector<scenario::Override> changes = {
      scenario::ParseOverride("/effects/ultrasound=null"),
      scenario::ParseOverride("/effects/ct_slice=null")};
  ReplayOptions options;
  options.run_folder = folder_ / "run";
  options.exercise = folder_ / "exercise.json";
  ReplaySession(scenario::ReadScenario(folder_ / "scene.json", changes), folder_ / "session",
                options, context_);
  const auto step = config::ReadJson(folder_ / "run/training.json").at("checklist").at(0);
  EXPECT_EQ(step.at("state"), "done");
  EXPECT_NEAR(step.at("time_s").get<double>(), 0.2, 0.02) << "5 mm at 25 mm/s";
  EXPECT_THAT(ReadTextFile(folder_ / "run/report.html"),
              testing::ContainsRegex("Needle</td><td[^>]*>0.2"));
}

TEST_F(Replay, SaysThatNeedleAndProbeWereNeverAtTheBody) {
  const auto warnings_of = [this](const char* run) {
    return config::ReadJson(folder_ / run / "run.json").at("warnings").dump();
  };
  const std::vector<scenario::Override> forces_only = {{"/effects/ultrasound", nullptr},
                                                       {"/effects/ct_slice", nullptr}};
  Run("inside", 1, forces_only);
  EXPECT_EQ(warnings_of("inside"), "[]");
  auto beside = forces_only;
  beside.push_back(
      {"/patient/ct_from_reference", {1, 0, 0, 500, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}});
  Run("beside", 1, beside);
  EXPECT_THAT(warnings_of("beside"), HasSubstr("never in the body"));
  Run("image", 1, {beside.back()});
  EXPECT_THAT(warnings_of("image"), HasSubstr("no image shows the body"));
  Run("all", 1);
  EXPECT_EQ(warnings_of("all"), "[]");
}

TEST_F(Replay, WritesOneImagePerPeriod) {
  Run("run", 2);
  const auto run = config::ReadJson(folder_ / "run/run.json");
  EXPECT_EQ(run.at("images"), 60);  // 0 s to 5.98 s at 10 Hz.
  for (const char* name : {"images.igs.mha", "film.mp4", "report.html", "forces.svg",
                           "metrics.json", "event_01.png", "provenance.json"}) {
    EXPECT_TRUE(fs::exists(folder_ / "run" / name)) << name;
  }
}

TEST_F(Replay, NeedsNoInputOfAnEffectThatIsOff) {
  fs::remove(folder_ / "ct.nrrd");
  const std::vector<scenario::Override> no_images = {
      scenario::ParseOverride("/patient/ct=null"),
      scenario::ParseOverride("/effects/ultrasound=null"),
      scenario::ParseOverride("/effects/ct_slice=null")};
  Run("forces_only", 1, no_images);
  EXPECT_FALSE(fs::exists(folder_ / "forces_only/film.mp4"));
  EXPECT_THAT(
      [&] { Run("all", 1, {scenario::ParseOverride("/patient/ct=null")}); },
      ThrowsMessage<InputError>(HasSubstr("B-mode (effect ultrasound is called for) needs ct")));
  EXPECT_FALSE(fs::exists(folder_ / "all"));
}

TEST_F(Replay, ForcesDoNotDependOnTheImages) {
  Run("all", 1);
  Run("forces_only", 1,
      {scenario::ParseOverride("/effects/ultrasound=null"),
       scenario::ParseOverride("/effects/ct_slice=null")});
  EXPECT_EQ(ReadTextFile(folder_ / "all/forces.csv"),
            ReadTextFile(folder_ / "forces_only/forces.csv"));
}

TEST_F(Replay, ImagesDoNotDependOnTheForces) {
  Run("all", 1);
  Run("images_only", 1, {scenario::ParseOverride("/effects/needle_force=null")});
  // The forces are fields of the frames; the pixels are at the end of the file.
  const std::string all = ReadTextFile(folder_ / "all/images.igs.mha");
  const std::string images_only = ReadTextFile(folder_ / "images_only/images.igs.mha");
  const std::string marker = "ElementDataFile = LOCAL\n";
  EXPECT_EQ(all.substr(all.find(marker)), images_only.substr(images_only.find(marker)));
}

TEST_F(Replay, ExplainsThePlanWithMeasuredCost) {
  const ReplayResult result = Run(nullptr, 1, {scenario::ParseOverride("/effects/ct_slice=null")});
  EXPECT_THAT(result.plan_text, AllOf(HasSubstr("effect ultrasound is called for"),
                                      HasSubstr("no effect of the scenario needs it"),
                                      HasSubstr("needed by needle force"), HasSubstr("us/run")));
}

TEST_F(Replay, LeavesNothingBehindWhenStopped) {
  std::atomic<bool> stop{true};
  RunContext context;
  context.stop = &stop;
  ReplayOptions options;
  options.run_folder = folder_ / "stopped";
  EXPECT_THROW(ReplaySession(scenario::ReadScenario(folder_ / "scene.json", {}),
                             folder_ / "session", options, context),
               Cancelled);
  for (const auto& entry : fs::directory_iterator(folder_)) {
    EXPECT_THAT(entry.path().filename().string(), testing::Not(HasSubstr("stopped")));
  }
}

TEST_F(Replay, EveryForceModelStopsAtBoneAndIsFeltInTheTissue) {
  for (const std::string model : {"layered", "alamilla", "vidal"}) {
    SCOPED_TRACE(model);
    const std::string table = model == "layered" ? "default" : model;
    const std::vector<scenario::Override> overrides = {
        {"/effects/needle_force/model", model},
        {"/effects/needle_force/table", "forces/" + table + ".json"},
        {"/effects/ultrasound", nullptr},
        {"/effects/ct_slice", nullptr}};
    Run((model + "_1").c_str(), 1, overrides);
    Run((model + "_2").c_str(), 2, overrides);
    EXPECT_EQ(ReadTextFile(folder_ / (model + "_1") / "forces.csv"),
              ReadTextFile(folder_ / (model + "_2") / "forces.csv"));
    const CsvTable forces(folder_ / (model + "_1") / "forces.csv");
    const auto axial_n = forces.Numbers("force_axial_n");
    const auto bone_n = forces.Numbers("bone_n");
    EXPECT_GT(*std::ranges::max_element(axial_n), 1.0);
    EXPECT_LT(*std::ranges::max_element(axial_n), 30.0);
    EXPECT_GT(*std::ranges::max_element(bone_n), 1.0);
    EXPECT_EQ(axial_n.front(), 0.0);
    EXPECT_EQ(axial_n.back(), 0.0);
    EXPECT_THAT(forces.Texts("tissue"), testing::Contains("muscle"));
    EXPECT_THAT(forces.Texts("event"), testing::Contains("bone_contact"));
  }
}

TEST_F(Replay, FeelsTheProbeAlsoWithoutANeedle) {
  session::Session pressing;  // In by 12 mm along the beam and out again; the skin is at z = 0.
  for (int ms = 0; ms < 2000; ms += 5) {
    Eigen::Isometry3d probe = Eigen::Isometry3d::Identity();
    probe.linear() << 1, 0, 0, 0, 0, -1, 0, 1, 0;
    probe.translation() << 0.0, 0.0, -2.0 + 14.0 * (1.0 - std::abs(ms - 1000) / 1000.0);
    pressing.probe.push_back({ms * std::int64_t{1'000'000}, probe, true});
  }
  session::WriteSession(folder_ / "pressing", pressing, context_);
  for (const char* effect :
       {R"({"model": "vidal"})", R"({"model": "multi_proxy"})",
        R"({"model": "multi_proxy", "multi_proxy": {"reads": "labels", "tool": "fingertip"}})"}) {
    SCOPED_TRACE(effect);
    const std::vector<scenario::Override> overrides = {
        {"/effects", {{"probe_force", nlohmann::json::parse(effect)}}}};
    for (const int threads : {1, 2}) {
      RunContext context;
      context.num_threads = threads;
      context.overwrite = true;
      ReplayOptions options;
      options.run_folder = folder_ / Message("felt_", threads);
      ReplaySession(scenario::ReadScenario(folder_ / "scene.json", overrides), folder_ / "pressing",
                    options, context);
    }
    EXPECT_EQ(ReadTextFile(folder_ / "felt_1/probe_forces.csv"),
              ReadTextFile(folder_ / "felt_2/probe_forces.csv"));
    EXPECT_FALSE(fs::exists(folder_ / "felt_1/forces.csv"));
    EXPECT_TRUE(fs::exists(folder_ / "felt_1/probe_forces.svg"));
    const CsvTable felt(folder_ / "felt_1/probe_forces.csv");
    ASSERT_EQ(felt.num_rows(), 400U);
    const auto z_force_n = felt.Numbers("force_z_n");
    const auto skin_mm = felt.Numbers("skin_mm");
    EXPECT_EQ(z_force_n.front(), 0.0);
    EXPECT_EQ(z_force_n.back(), 0.0);
    EXPECT_LT(z_force_n[200], -1.5);  // Pushed out, along -z.
    EXPECT_NEAR(skin_mm[200], 12.0, 1.0);
    const auto metrics = config::ReadJson(folder_ / "felt_1/metrics.json").at("metrics");
    const auto largest = std::ranges::find_if(
        metrics, [](const auto& m) { return m.at("name") == "largest probe force"; });
    ASSERT_NE(largest, metrics.end());
    EXPECT_NEAR(largest->at("value").get<double>(), std::abs(z_force_n[200]), 0.3);
  }
}

// With a needle the probe is felt at the needle's samples, and the needle's forces stay the same.
TEST_F(Replay, TheProbesForceLeavesTheNeedlesAsItIs) {
  const std::vector<scenario::Override> no_images = {{"/effects/ultrasound", nullptr},
                                                     {"/effects/ct_slice", nullptr}};
  auto with_probe = no_images;
  with_probe.push_back({"/effects/probe_force", nlohmann::json::object()});
  Run("needle", 1, no_images);
  Run("both", 1, with_probe);
  EXPECT_EQ(ReadTextFile(folder_ / "needle/forces.csv"), ReadTextFile(folder_ / "both/forces.csv"));
  EXPECT_FALSE(fs::exists(folder_ / "needle/probe_forces.csv"));
  const CsvTable lying(folder_ / "both/probe_forces.csv");
  ASSERT_EQ(lying.num_rows(), 6000U);
  EXPECT_EQ(std::ranges::max(lying.Numbers("force_n")), 0.0);
  EXPECT_THAT(ReadTextFile(folder_ / "both/run.json"), HasSubstr("press_mm"));
  // The probe lies half a millimetre above the skin.
  with_probe.back().value = {{"press_mm", 5.5}};
  Run("pressed", 1, with_probe);
  const CsvTable pressed(folder_ / "pressed/probe_forces.csv");
  EXPECT_NEAR(pressed.Numbers("skin_mm").back(), 5.0, 0.5);
  EXPECT_GT(pressed.Numbers("force_n").back(), 1.5);
}

// The layers are at 0, 2, 15 and 60 mm; labels change half way between voxels, as these do. The
// models by label wait for interface_hysteresis_mm before an interface counts.
TEST_F(Replay, LogsEventsWhereTheTruthIs) {
  for (const std::string model : {"layered", "alamilla", "vidal"}) {
    SCOPED_TRACE(model);
    Run(model.c_str(), 1,
        {{"/effects/needle_force/model", model},
         {"/effects/ultrasound", nullptr},
         {"/effects/ct_slice", nullptr}});
    const CsvTable events(folder_ / model / "events.csv");
    const auto names = events.Texts("event");
    const auto tissues = events.Texts("tissue");
    const auto depth_mm = events.Numbers("depth_mm");
    const auto time_s = events.Numbers("time_s");
    const auto before_n = events.Numbers("force_before_n");
    const auto after_n = events.Numbers("force_axial_n");
    const auto find = [&](const std::string& name, const std::string& tissue) {
      for (std::size_t i = 0; i < names.size(); ++i) {
        if (names[i] == name && (tissue.empty() || tissues[i] == tissue)) return i;
      }
      ADD_FAILURE() << name << " in " << tissue;
      return std::size_t{0};
    };
    const std::size_t contact = find("contact", "skin");
    // By HU bone begins a little above the voxels that are called so.
    const std::size_t bone = find("bone_contact", model == "vidal" ? "" : "bone");
    const std::size_t withdrawal = find("withdrawal", "outside");
    // Vidal's skin and bone are where the CT, between voxels, passes their HU.
    const double off_mm = model == "vidal" ? 0.6 : 0.06;
    EXPECT_NEAR(0.025 * (1000.0 * time_s[contact] - 200.0), 0.0, off_mm + 0.03);
    EXPECT_NEAR(depth_mm[bone], 60.0, off_mm);
    EXPECT_GT(time_s[withdrawal], time_s[bone]);
    EXPECT_LT(depth_mm[withdrawal], 0.5);
    const auto puncture =
        static_cast<std::size_t>(std::ranges::find(names, "puncture") - names.begin());
    ASSERT_LT(puncture, names.size());
    EXPECT_GT(before_n[puncture], after_n[puncture]);
    EXPECT_GT(before_n[puncture], 0.5);
    EXPECT_EQ(std::ranges::count(names, "withdrawal"), 1);
    const auto logged = config::ReadJson(folder_ / model / "run.json").at("events");
    ASSERT_EQ(logged.size(), names.size());
    EXPECT_EQ(logged.at(bone).at("event"), "bone_contact");
    EXPECT_EQ(logged.at(bone).at("depth_mm"), depth_mm[bone]);
    if (model == "vidal") continue;
    EXPECT_NEAR(depth_mm[find("interface", "fat")], 2.0 + 0.3, 0.06);
    EXPECT_NEAR(depth_mm[find("interface", "muscle")], 15.0 + 0.3, 0.06);
    // On the way out the same two, in the channel that is cut. The layered model waits for nothing
    // there: drawn back so far, the needle may take a new path, and the old one is forgotten.
    const double out_mm = model == "layered" ? 0.0 : 0.3;
    EXPECT_NEAR(depth_mm[find("channel_interface", "fat")], 15.0 - out_mm, 0.06);
    EXPECT_NEAR(depth_mm[find("channel_interface", "skin")], 2.0 - out_mm, 0.06);
    EXPECT_EQ(std::ranges::count(names, "channel_interface"), 2);
  }
}

TEST_F(Replay, IdentifiesTissuesByHuWhereThereIsNoLabelMap) {
  RunContext context;
  std::vector<std::string> warnings;
  context.on_warning = [&](std::string_view text) { warnings.emplace_back(text); };
  ReplayOptions options;
  options.run_folder = folder_ / "by_hu";
  const std::vector<scenario::Override> overrides = {{"/patient/labels", nullptr},
                                                     {"/effects/ultrasound", nullptr},
                                                     {"/effects/ct_slice", nullptr}};
  ReplaySession(scenario::ReadScenario(folder_ / "scene.json", overrides), folder_ / "session",
                options, context);
  EXPECT_THAT(warnings, testing::Contains(HasSubstr("no label map")));
  const CsvTable forces(folder_ / "by_hu" / "forces.csv");
  EXPECT_THAT(forces.Texts("tissue"), testing::Contains("fat"));
  EXPECT_THAT(forces.Texts("event"), testing::Contains("bone_contact"));
}

}  // namespace
}  // namespace acus::replay
