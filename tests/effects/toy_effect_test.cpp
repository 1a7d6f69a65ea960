// An effect stands on its own: this file defines one and registers it, and without another line
// anywhere it is in the schema, the plan, --explain, the log and report of a replay, a live session
// and a sweep; it moves tissue, adds a force on the needle, changes the echoes of the B-mode, has
// an event, a metric and a finding in the report.
#include <deque>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>
#include <numbers>
#include <thread>

#include "acus/assess/tuning/knob.h"
#include "acus/base/config/json_file.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/csv.h"
#include "acus/run/live/live_session.h"
#include "acus/run/replay/plan_table.h"
#include "acus/run/replay/replay.h"
#include "acus/scene/effects/effect_list.h"
#include "acus/scene/effects/ports.h"
#include "acus/scene/simulation/probe_image_renderer.h"
#include "acus/scene/simulation/simulation.h"
#include "support/sweep_folder.h"

namespace acus {
namespace {

namespace fs = std::filesystem;
using effects::Activity;
using nlohmann::json;
using testing::HasSubstr;

struct SwayState {
  double offset_mm = 0.0;
  std::int32_t turns = 0;
  bool is_started = false;
};

/// The patient's table sways along x, as a sum of the odd terms of a triangle wave.
class SwayStep final : public effects::StepStageOf<SwayState> {
 public:
  explicit SwayStep(const json& settings)
      : amplitude_mm_(settings.at("amplitude_mm")),
        num_terms_(settings.at("terms")),
        push_n_per_mm_(settings.at("push_n_per_mm")),
        echo_db_(settings.at("echo_db")) {}

  Activity Step(SwayState& state, const effects::StepTime& time, effects::PortValues& /*ports*/,
                std::span<double> columns) const noexcept override {
    const double before_mm = state.offset_mm;
    state.offset_mm = 0.0;
    for (int n = 0; n < num_terms_; ++n) {
      const double k = 2.0 * n + 1.0;
      state.offset_mm += amplitude_mm_ * 8.0 / (std::numbers::pi * std::numbers::pi) *
                         std::cos(2.0 * std::numbers::pi * k * time.session_s) / (k * k);
    }
    if (state.is_started && (state.offset_mm > 0.0) != (before_mm > 0.0)) ++state.turns;
    state.is_started = true;
    columns[0] = state.offset_mm;
    columns[1] = state.turns;
    return state.offset_mm == 0.0 ? Activity::kIdle : Activity::kActive;
  }
  Eigen::Vector3d RestInCtMm(const SwayState& state,
                             const Eigen::Vector3d& place_in_ct_mm) const noexcept override {
    return place_in_ct_mm - state.offset_mm * Eigen::Vector3d::UnitX();
  }
  bool IsSameMotion(const SwayState& a, const SwayState& b) const noexcept override {
    return a.offset_mm == b.offset_mm;
  }
  Eigen::Vector3d ForceInCtN(const SwayState& state) const noexcept override {
    return -push_n_per_mm_ * state.offset_mm * Eigen::Vector3d::UnitZ();
  }
  double EchoChangeDb(const SwayState& /*state*/,
                      const effects::EchoPlace& place) const noexcept override {
    return place.depth_mm < 20.0 ? echo_db_ : 0.0;
  }

 private:
  double amplitude_mm_;
  int num_terms_;
  double push_n_per_mm_;
  double echo_db_;
};

class SwayMeter final : public effects::EffectMeter {
 public:
  void Add(double /*session_s*/, std::span<const double> columns) override {
    largest_mm_ = std::max(largest_mm_, std::abs(columns[0]));
  }
  std::vector<effects::MeasuredValue> Values() const override {
    return {{"largest sway", "mm", largest_mm_}};
  }
  std::vector<std::string> Findings() const override { return {"The table swayed."}; }

 private:
  double largest_mm_ = 0.0;
};

/// A bar as long as the table has moved.
class SwayImage final : public effects::ImageStage {
 public:
  Activity Render(const effects::ImageMoment& moment, const effects::PortValues& /*ports*/,
                  effects::EffectPixels& pixels) override {
    image::GrayImage& out = pixels.gray;
    out.Resize(64, 32);
    std::ranges::fill(out.pixels, std::uint8_t{0});
    if (moment.state == nullptr) return Activity::kIdle;
    const double offset_mm = SwayStep::StateAt(moment.state).offset_mm;
    const int length = std::clamp(static_cast<int>(32.0 + 8.0 * offset_mm), 1, 64);
    for (int row = 8; row < 24; ++row) {
      for (int column = 0; column < length; ++column) {
        out.pixels[static_cast<std::size_t>(64 * row + column)] = 255;
      }
    }
    return Activity::kActive;
  }
};

class LoadedSway final : public effects::LoadedEffect {
 public:
  explicit LoadedSway(const json& settings) : step_(settings) {}
  const effects::StepStage* step() const override { return &step_; }
  std::unique_ptr<effects::ImageStage> NewImageStage(const effects::PortValues&,
                                                     const RunContext&) const override {
    return std::make_unique<SwayImage>();
  }
  std::unique_ptr<effects::EffectMeter> NewMeter() const override {
    return std::make_unique<SwayMeter>();
  }

 private:
  SwayStep step_;
};

class Sway : public effects::Effect {
 public:
  std::string_view key() const override { return "toy_sway"; }
  std::string_view title() const override { return "Sway of the table"; }
  json Schema() const override {
    return json::parse(R"({"type": "object", "additionalProperties": false,
      "description": "The table sways",
      "properties": {
        "amplitude_mm": {"type": "number", "minimum": 0, "maximum": 10, "default": 2,
                         "description": "To each side"},
        "terms": {"type": "integer", "minimum": 1, "maximum": 64, "default": 8,
                  "description": "Of the series of a triangle wave"},
        "push_n_per_mm": {"type": "number", "default": 0, "description": "Of the needle, upwards"},
        "echo_db": {"type": "number", "default": 0, "description": "Of the first 20 mm"}}})");
  }
  std::optional<effects::StageDeclaration> StepStageOf(const json& settings) const override {
    effects::StageDeclaration stage{
        .name = "sway", .reads = {}, .writes = {effects::ports::kTissueMotion}};
    if (settings.at("push_n_per_mm") != 0) stage.writes.push_back(effects::ports::kAddedForce);
    if (settings.at("echo_db") != 0) stage.writes.push_back(effects::ports::kEcho);
    return stage;
  }
  std::optional<effects::StageDeclaration> ImageStageOf(const json&) const override {
    return effects::StageDeclaration{
        .name = "sway image", .reads = {effects::ports::kProbe}, .writes = {kImage}};
  }
  std::vector<effects::Column> Columns() const override {
    return {{"sway_mm", "How far the table is aside", "mm"},
            {"turns", "Times that the table was in the middle", "", "table_in_the_middle"}};
  }
  std::vector<effects::Knob> Knobs() const override {
    return {{.name = "sway_terms",
             .title = "terms of the sway",
             .unit = "",
             .key = "terms",
             .values = {1, 2, 8, 64}}};
  }
  std::unique_ptr<const effects::LoadedEffect> Load(const json& settings,
                                                    const effects::PortValues&,
                                                    RunContext&) const override {
    return std::make_unique<LoadedSway>(settings);
  }

 private:
  static constexpr effects::Port<image::GrayImage> kImage{"sway image"};
};

/// Reads, at every sample or at every image, what the table's sway writes at every sample.
class Reader final : public Sway {
 public:
  explicit Reader(std::string_view key) : key_(key) {}
  std::string_view key() const override { return key_; }
  json Schema() const override {
    json schema = Sway::Schema();
    schema["properties"]["at_images"] = {
        {"type", "boolean"}, {"default", false}, {"description", "Read there"}};
    return schema;
  }
  std::optional<effects::StageDeclaration> StepStageOf(const json& settings) const override {
    return Stage(settings.at("at_images") == false);
  }
  std::optional<effects::StageDeclaration> ImageStageOf(const json& settings) const override {
    return Stage(settings.at("at_images"));
  }

 private:
  static std::optional<effects::StageDeclaration> Stage(bool is_there) {
    if (!is_there) return std::nullopt;
    return effects::StageDeclaration{
        .name = "reader", .reads = {effects::ports::kTissueMotion}, .writes = {kRead}};
  }
  static constexpr effects::Port<double> kRead{"what was read"};
  std::string_view key_;
};

/// One of many tables.
class Numbered final : public Sway {
 public:
  explicit Numbered(int n) : key_("toy_table_" + std::to_string(n)) {}
  std::string_view key() const override { return key_; }

 private:
  std::string key_;
};
constexpr int kNumTables = 12;

constexpr const char* kWithSway =
    R"({"needle_force": {}, "probe_force": {"press_mm": 5}, "ct_slice": {}, "toy_sway": {}})";

class ToyEffect : public testing_support::SweepFolder {
 protected:
  static void SetUpTestSuite() {
    static const Sway sway;
    static const Reader early("toy_early");
    static const Reader late("toy_late");
    for (const Sway* effect :
         {static_cast<const Sway*>(&early), &sway, static_cast<const Sway*>(&late)}) {
      effects::RegisterEffect(*effect);
    }
    static std::deque<Numbered> tables;
    for (int n = 0; n < kNumTables; ++n) effects::RegisterEffect(tables.emplace_back(n));
  }

  void SetUp() override { Make(kWithSway); }

  scenario::Scenario Scene(const std::vector<scenario::Override>& changes = {}) {
    return scenario::ReadScenario(folder_ / "scene.json", changes);
  }

  void Replay(const char* run, const std::vector<scenario::Override>& changes = {},
              int num_threads = 1) {
    replay::ReplayOptions options;
    options.run_folder = folder_ / run;
    context_.num_threads = num_threads;
    result_ = replay::ReplaySession(Scene(changes), folder_ / "session", options, context_);
  }

  std::string Text(const char* file) { return ReadTextFile(folder_ / file); }

  replay::ReplayResult result_;
};

TEST_F(ToyEffect, IsInTheSchema) {
  EXPECT_EQ(Scene().effective.at("/effects/toy_sway/terms"_json_pointer), 8);
  EXPECT_THAT(
      [&] {
        Scene({{"/effects/toy_sway/amplitude_mm", 11}});
      },
      testing::ThrowsMessage<InputError>(HasSubstr("/effects/toy_sway/amplitude_mm")));
  EXPECT_THAT(
      [&] {
        Scene({{"/effects/toy_sway/term", 11}});
      },
      testing::ThrowsMessage<InputError>(HasSubstr("terms")));
}

TEST_F(ToyEffect, IsInThePlanAndExplained) {
  const std::string text =
      replay::CheckText(Scene(), folder_ / "session", replay::PlanDetail::kAll, context_);
  EXPECT_THAT(text, testing::ContainsRegex("sway +step +in +effect toy_sway is called for"));
  EXPECT_THAT(text, testing::ContainsRegex("sway image +image +in +effect toy_sway"));
  EXPECT_THAT(text, testing::ContainsRegex("needle pose +needle +needle poses, tissue motion"));
  const std::string without =
      replay::CheckText(Scene({{"/effects/toy_sway", nullptr}}), folder_ / "session",
                        replay::PlanDetail::kAll, context_);
  EXPECT_THAT(without, testing::Not(HasSubstr("sway")));
}

TEST_F(ToyEffect, AnyNumberOfEffectsIsPlanned) {
  std::vector<scenario::Override> all;
  for (int n = 0; n < kNumTables; ++n) {
    all.push_back({"/effects/toy_table_" + std::to_string(n), json::object()});
  }
  const auto plan =
      simulation::PlanEffects(Scene(all), {.needle_poses = true, .probe_poses = true});
  for (int n = 0; n < kNumTables; ++n) {
    const std::string key = "toy_table_" + std::to_string(n);
    const auto is_its = [&key](const auto& stage) { return stage.in && stage.owner == key; };
    EXPECT_EQ(std::ranges::count_if(plan.stages(), is_its), 2) << key;  // Step and image.
  }
  for (std::size_t n = 0; n < plan.stages().size(); ++n) EXPECT_EQ(plan.stages()[n].number, n);
}

TEST_F(ToyEffect, IsInTheLogAndTheReportOfAReplay) {
  Replay("run");
  const CsvTable log(folder_ / "run" / "toy_sway.csv");
  const auto sway_mm = log.Numbers("sway_mm");
  ASSERT_EQ(sway_mm.size(), 1001U);
  EXPECT_NEAR(sway_mm.front(), 2.0, 0.1);  // A triangle wave of 1 Hz ...
  EXPECT_NEAR(sway_mm[500], -2.0, 0.1);    // ... from one side to the other ...
  EXPECT_NEAR(sway_mm[250], 0.0, 1e-9);    // ... through the middle.
  const std::string report = Text("run/report.html");
  EXPECT_THAT(report, HasSubstr("Sway of the table"));
  EXPECT_THAT(report, HasSubstr("How far the table is aside"));
  EXPECT_THAT(report, HasSubstr("toy_sway.mp4"));
  EXPECT_TRUE(fs::exists(folder_ / "run" / "toy_sway.png"));
  EXPECT_GT(fs::file_size(folder_ / "run" / "toy_sway.mp4"), 500U);
  const json run = config::ReadJson(folder_ / "run" / "run.json");
  for (const auto& stage : run.at("effect_plan")) {
    if (stage.at("stage") == "sway") {
      EXPECT_EQ(stage.at("runs"), 1001);
    }
    if (stage.at("stage") == "sway image") {
      EXPECT_EQ(stage.at("runs"), run.at("images"));
    }
  }
  EXPECT_THAT(result_.plan_text, HasSubstr("sway"));
}

TEST_F(ToyEffect, ReadsAtEverySampleWhatAnEffectBeforeItWrites) {
  const json called = json::object();
  Replay("late", {{"/effects/toy_late", called}});
  EXPECT_THAT(
      [&] {
        Replay("early", {{"/effects/toy_early", called}});
      },
      testing::ThrowsMessage<InputError>(testing::AllOf(HasSubstr("effects/toy_early"),
                                                        HasSubstr("'tissue motion'"),
                                                        HasSubstr("no stage before it writes"))));
  EXPECT_THAT(
      [&] {
        Replay("image", {{"/effects/toy_late", {{"at_images", true}}}});
      },
      testing::ThrowsMessage<InputError>(
          testing::AllOf(HasSubstr("effects/toy_late"), HasSubstr("images are not given"))));
}

TEST_F(ToyEffect, IsFeltAndSeenAndTheSameWithAnyNumberOfThreads) {
  Replay("still", {{"/effects/toy_sway", nullptr}});
  Replay("one");
  Replay("two", {}, 2);
  for (const char* file : {"forces.csv", "probe_forces.csv", "images.igs.mha"}) {
    EXPECT_NE(Text((std::string("still/") + file).c_str()),
              Text((std::string("one/") + file).c_str()))
        << file;
    EXPECT_EQ(Text((std::string("one/") + file).c_str()),
              Text((std::string("two/") + file).c_str()))
        << file;
  }
  EXPECT_EQ(Text("one/toy_sway.mp4"), Text("two/toy_sway.mp4"));
  // An amplitude of 0 is the scene without it, bit by bit.
  Replay("zero", {{"/effects/toy_sway/amplitude_mm", 0}});
  EXPECT_EQ(Text("zero/forces.csv"), Text("still/forces.csv"));
  EXPECT_EQ(Text("zero/images.igs.mha"), Text("still/images.igs.mha"));
}

TEST_F(ToyEffect, AddsAForceOnTheNeedle) {
  Replay("without");
  Replay("with", {{"/effects/toy_sway/push_n_per_mm", 0.5}});
  const CsvTable without(folder_ / "without" / "forces.csv");
  const CsvTable with(folder_ / "with" / "forces.csv");
  const auto sway_mm = CsvTable(folder_ / "with" / "toy_sway.csv").Numbers("sway_mm");
  const auto added_n = with.Numbers("added_n");
  const auto along_n = with.Numbers("force_axial_n"), before_n = without.Numbers("force_axial_n");
  const auto z_n = with.Numbers("force_z_n"), z_before_n = without.Numbers("force_z_n");
  ASSERT_EQ(added_n.size(), 1001U);
  for (std::size_t i = 0; i < added_n.size(); ++i) {
    ASSERT_NEAR(added_n[i], 0.5 * sway_mm[i], 1e-9);  // The needle points along z.
    ASSERT_NEAR(along_n[i], before_n[i] + added_n[i], 1e-9);
    ASSERT_NEAR(z_n[i], z_before_n[i] - added_n[i], 1e-9);
  }
  EXPECT_FALSE(without.Has("added_n"));
  EXPECT_THAT(
      [&] {
        Replay("alone",
               {{"/effects/toy_sway/push_n_per_mm", 0.5}, {"/effects/needle_force", nullptr}});
      },
      testing::ThrowsMessage<InputError>(HasSubstr("adds a force on the needle")));
}

TEST_F(ToyEffect, ChangesEchoesOfTheBMode) {
  const scenario::Override image{"/effects/ultrasound", {{"model", "columns_2010"}}};
  const scenario::Override still{"/effects/toy_sway/amplitude_mm", 0};
  const auto grey_of = [&](double echo_db) {
    const auto scenario = Scene({image, still, {"/effects/toy_sway/echo_db", echo_db}});
    const auto plan =
        simulation::PlanEffects(scenario, {.needle_poses = true, .probe_poses = true});
    const simulation::Scene scene = simulation::LoadScene(scenario, plan, context_);
    const simulation::Simulation simulation(scene);
    simulation::State state = simulation.NewState();
    simulation.Step(state, {});
    simulation::Snapshot moment{.probe_valid = true, .memory = &state.effects};
    moment.ct_from_probe =
        scene.ct_from_reference * Insertion().probe.front().reference_from_tool.isometry();
    simulation::ProbeImages images;
    simulation::ProbeImageRenderer(scene).Render(moment, images);
    double sum = 0.0;
    for (const std::uint8_t grey : images.b_mode.pixels) sum += grey;
    return sum / static_cast<double>(images.b_mode.pixels.size());
  };
  const double as_it_is = grey_of(0.0);
  EXPECT_GT(as_it_is, 1.0);
  EXPECT_LT(grey_of(-200.0), 0.9 * as_it_is);
  EXPECT_GT(grey_of(6.0), as_it_is);
}

TEST_F(ToyEffect, HasAnEventAMetricAndAFinding) {
  Replay("run");
  EXPECT_THAT(Text("run/events.csv"), HasSubstr("table_in_the_middle"));
  EXPECT_THAT(Text("run/run.json"), HasSubstr("table_in_the_middle"));
  const std::string report = Text("run/report.html");
  EXPECT_THAT(report, HasSubstr("table in the middle"));
  EXPECT_THAT(report, HasSubstr("The table swayed."));
  const json metrics = config::ReadJson(folder_ / "run" / "metrics.json").at("metrics");
  const auto largest = std::ranges::find(metrics, "largest sway", [](const json& metric) {
    return metric.at("name").get<std::string>();
  });
  ASSERT_NE(largest, metrics.end());
  EXPECT_NEAR(largest->at("value").get<double>(), 2.0, 0.1);
}

TEST_F(ToyEffect, IsInALiveSessionThatReplaysToTheSameNumbers) {
  WriteTextFile(folder_ / "devices.json", R"({"format": "acus-devices/1", "devices": [
      {"name": "right", "driver": "virtual_hand", "virtual_hand": {"repeats": true, "path": [
        {"time_s": 0, "translation_mm": [0, 20, -5]}, {"time_s": 1, "translation_mm": [0, 20, 20]},
        {"time_s": 2, "translation_mm": [0, 20, -5]}]}},
      {"name": "left", "driver": "virtual_hand", "virtual_hand": {"path": [
        {"time_s": 0, "translation_mm": [0, 20, 2]}]}}],
      "needle": {"device": "right"}, "probe": {"device": "left"}})");
  live::LiveOptions options;
  options.session_folder = folder_ / "live";
  options.duration_s = 1.5;
  const std::vector<scenario::Override> pushing{{"/effects/toy_sway/push_n_per_mm", 0.5}};
  live::LiveSession session(Scene(pushing), live::ReadLiveDevices(folder_ / "devices.json"),
                            options, context_);
  session.Start();
  std::size_t width_px = 0;
  double largest_mm = 0.0;
  while (session.Poll()) {
    if (session.images().Refresh()) {
      const live::LiveImage& image = session.images().Front();
      if (!image.effects.empty()) {
        width_px = static_cast<std::size_t>(image.effects.front().pixels.gray.width);
        EXPECT_EQ(image.effects.front().key, "toy_sway");
      }
      largest_mm = std::max(largest_mm, std::abs(image.snapshot.output.effect[0]));
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  session.Stop();
  EXPECT_EQ(width_px, 64U);
  EXPECT_GT(largest_mm, 1.0);

  replay::ReplayOptions replay;
  replay.run_folder = folder_ / "replayed";
  replay::ReplaySession(Scene(pushing), folder_ / "live", replay, context_);
  EXPECT_EQ(Text("live/toy_sway.csv"), Text("replayed/toy_sway.csv"));
  EXPECT_EQ(Text("live/forces.csv"), Text("replayed/forces.csv"));
}

TEST_F(ToyEffect, IsInASweep) {
  const auto knobs = tuning::KnobsOf(Scene(), 1000.0);
  const tuning::Knob& knob = tuning::KnobNamed(knobs, "sway_terms");
  EXPECT_EQ(knob.default_value, 8);
  request_.knobs = {"sway_terms"};
  const tuning::SweepResult result = Sweep("sweep");
  const double coarse_n = Of(result, {{"sway_terms", 1}}).force_rms_n.mean;
  const double fine_n = Of(result, {{"sway_terms", 8}}).force_rms_n.mean;
  EXPECT_GT(coarse_n, 0.0);
  EXPECT_LT(fine_n, coarse_n);
}

class Named final : public Sway {
 public:
  explicit Named(std::string_view key) : key_(key) {}
  std::string_view key() const override { return key_; }

 private:
  std::string_view key_;
};

TEST_F(ToyEffect, KeysAreWordsAndEachIsThereOnce) {
  for (const char* key : {"toy_sway", "pulsating_vessels", "Toy sway", ""}) {
    const Named effect(key);
    EXPECT_THROW(effects::RegisterEffect(effect), InputError) << key;
  }
}

}  // namespace
}  // namespace acus
