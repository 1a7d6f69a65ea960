// Random legal scenarios, and legal ones at the ends of what the schema allows: no crash, nothing
// that is no number, no force over its limit, no energy from nowhere. Each runs in a process of its
// own; one that fails is shrunk to a small scenario file that does the same, and kept with a
// session. ACUS_STABILITY_SECONDS=600 goes on for ten minutes.
#include <gmock/gmock.h>

#include "acus/base/core/cpu_time.h"
#include "acus/run/replay/replay.h"
#include "support/bound.h"
#include "support/child_process.h"
#include "support/kept_failure.h"
#include "support/random_patient.h"
#include "support/stability_length.h"
#include "support/temporary_folder.h"

namespace acus::testing_support {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

class RandomScenarios : public testing::Test {
 protected:
  void SetUp() override {
    fs::create_directories(folder_);
    WriteRandomPatient(folder_);
    if (std::getenv("ACUS_STABILITY_FAILURES") == nullptr) fs::remove_all(failures_);
  }

  /// Loads the scenario at `file` as acus-replay does and tries it.
  void Try(const fs::path& file, std::uint64_t seed) {
    const auto scenario = scenario::ReadScenario(file, {});
    RunContext context;
    simulation::Scene scene = simulation::LoadScene(
        scenario,
        simulation::PlanEffects(scenario,
                                {.needle_poses = true, .probe_poses = true, .breath = false}),
        context);
    ScenarioTrial(std::move(scene), *trace_, also_).Run(seed);
  }

  Outcome TryInChild(const json& document, std::uint64_t seed) {
    const fs::path file = folder_ / "drawn.json";
    config::WriteJson(file, document);
    *trace_ = TrialTrace();
    return InChild([&] { Try(file, seed); });
  }

  /// Tries it; if it fails, finds the smallest scenario that does, and keeps it.
  End TryAndKeep(const json& document, std::uint64_t seed) {
    const Outcome outcome = TryInChild(document, seed);
    ++num_run_;
    if (outcome.end == End::kSound) {
      force_share_.Add(trace_->largest_force_share);
      generated_mj_.Add(trace_->generated_mj);
      loop_mj_.Add(trace_->loop_mj);
      strained_mj_.Add(trace_->strained_mj);
    }
    if (outcome.end == End::kRefused) {
      ++num_refused_;
      if (std::getenv("ACUS_STABILITY_VERBOSE") != nullptr)
        std::printf("  %s\n", outcome.what.c_str());
    }
    if (outcome.end == End::kSound || outcome.end == End::kRefused) return outcome.end;
    const json small = Shrunk(document, [&](const json& smaller) {
      return TryInChild(smaller, seed).end == outcome.end;
    });
    const Outcome again = TryInChild(small, seed);
    ++num_failed_;
    int number = 1;  // Those of earlier tests stay.
    while (fs::exists(failures_ / std::to_string(number))) ++number;
    const fs::path kept = failures_ / std::to_string(number);
    fs::remove(folder_ / "drawn.json");
    KeepFailure(kept, {.scenario = small, .what = again.what, .seed = seed}, *trace_, folder_);
    if (expects_failures_) return outcome.end;
    ADD_FAILURE() << "seed " << seed << ": " << again.what << "\n"
                  << small.dump(2) << "\nkept in " << kept << ": see what.txt there";
    return outcome.end;
  }

  void State(const HardCase& hard) const {
    hard.Expect("scenarios that crash, give no number, too much force or energy", num_failed_,
                Exactly(0));
    hard.Expect("largest force, of its limit", force_share_, AtMost(1.0 + 1e-9));
    hard.Expect("energy given to a hand in 4 s", generated_mj_,
                AtMost(ScenarioTrial::kEnergyLimitMj), "mJ");
    hard.Expect("energy given to a device and a hand in 3 s", loop_mj_,
                AtMost(ScenarioTrial::kLoopLimitMj), "mJ");
    std::printf("  a hand got %.4f mJ, in held breath %.4f mJ; a device and a hand %.4f mJ\n",
                static_cast<double>(generated_mj_), static_cast<double>(strained_mj_),
                static_cast<double>(loop_mj_));
    hard.Expect("energy given to a hand in held breath in 4 s", strained_mj_,
                AtMost(ScenarioTrial::kEnergyLimitMj), "mJ");
    hard.Note("scenarios run", std::to_string(num_run_));
    hard.Note("of these refused, as effects do not go together", std::to_string(num_refused_));
  }

  TemporaryFolder temporary_;
  fs::path folder_ = temporary_ / "patient";
  fs::path failures_ = [] {
    const char* asked = std::getenv("ACUS_STABILITY_FAILURES");
    return asked != nullptr ? fs::path(asked)
                            : fs::path(ACUS_BUILD_DIR) / "random_scenarios" /
                                  testing::UnitTest::GetInstance()->current_test_info()->name();
  }();
  Shared<TrialTrace> trace_;
  ScenarioTrial::StepCheck also_;
  bool expects_failures_ = false;
  int num_run_ = 0;
  int num_refused_ = 0;
  int num_failed_ = 0;
  Largest force_share_;
  Largest generated_mj_;
  Largest loop_mj_;
  Largest strained_mj_;
};

TEST_F(RandomScenarios, AreSound) {
  const HardCase hard("Scenarios drawn from the schema: any effects, models and numbers together.");
  const auto sampler = ScenarioSampler();
  const std::uint64_t first = StabilitySeed();
  const double begin_s = CpuSeconds(CLOCK_MONOTONIC);
  const auto elapsed_s = [begin_s] { return CpuSeconds(CLOCK_MONOTONIC) - begin_s; };
  std::uint64_t seed = first;
  for (; num_failed_ < 5 && (num_run_ < 30 || elapsed_s() < StabilitySeconds()); ++seed) {
    TryAndKeep(Mended(sampler.Draw(seed)), seed);
  }
  std::printf("  %d scenarios, %d refused, %.0f s\n", num_run_, num_refused_, elapsed_s());
  State(hard);
  // What the schema allows is mostly a scenario.
  hard.Expect("scenarios refused, as a share", static_cast<double>(num_refused_) / num_run_,
              Below(0.5));
  hard.Note("seeds", Message(first, " to ", seed - 1));
  hard.Note("time", Message(std::lround(elapsed_s()), " s"));
}

/// Each number of the schema at its smallest and its largest, in each model of its effect.
class ExtremeScenarios : public RandomScenarios {
 protected:
  struct Extreme {
    json::json_pointer pointer;
    json value;
    json::json_pointer model_pointer;  ///< Empty if its effect has no models.
    json model;
  };

  std::vector<Extreme> Extremes() const {
    std::vector<Extreme> extremes;
    for (const auto& range : sampler_.Ranges()) {
      const std::string text = range.pointer.to_string();
      const std::string effect = text.substr(0, text.find('/', std::strlen("/effects/")));
      const std::string model_pointer = effect + "/model";
      std::vector<json> models = sampler_.ValuesAt(model_pointer);
      if (models.empty()) models.emplace_back();
      for (const json& model : models) {
        // A block that is of another model.
        if (model.is_string() && OfAnother(text, models, model)) continue;
        for (const json& value : {range.low, range.high}) {
          extremes.push_back(
              {range.pointer, value,
               model.is_null() ? json::json_pointer() : json::json_pointer(model_pointer), model});
        }
      }
    }
    return extremes;
  }

  json DocumentOf(const std::vector<Extreme>& extremes, std::uint64_t seed) const {
    std::vector<std::pair<json::json_pointer, json>> values;
    for (const Extreme& extreme : extremes) {
      if (!extreme.model.is_null()) values.emplace_back(extreme.model_pointer, extreme.model);
      values.emplace_back(extreme.pointer, extreme.value);
    }
    return Mended(sampler_.Least(values, seed));
  }

  const SchemaSampler sampler_ = ScenarioSampler();

 private:
  static bool OfAnother(const std::string& text, const std::vector<json>& models,
                        const json& model) {
    for (const json& other : models) {
      const bool named = text.find("/" + other.get<std::string>() + "/") != std::string::npos;
      if (named && other != model) return true;
    }
    return false;
  }
};

TEST_F(ExtremeScenarios, AreSoundOneByOne) {
  const HardCase hard("Each number of the schema at its smallest and largest, the rest at rest.");
  const auto extremes = Extremes();
  ASSERT_GT(extremes.size(), 60u);
  // All of them on demand; every seventh in the short form.
  const std::size_t stride = StabilitySeconds() > 0.0 ? 1 : 7;
  for (std::size_t i = StabilitySeed() % stride; i < extremes.size() && num_failed_ < 5;
       i += stride) {
    TryAndKeep(DocumentOf({extremes[i]}, i), i);
  }
  std::printf("  %d of %zu extremes, %d refused\n", num_run_, extremes.size(), num_refused_);
  State(hard);
  hard.Note("extremes of the schema", std::to_string(extremes.size()));
}

TEST_F(ExtremeScenarios, AreSoundInPairs) {
  const HardCase hard("Two numbers of the schema at an end of their range, any two.");
  const auto extremes = Extremes();
  const double begin_s = CpuSeconds(CLOCK_MONOTONIC);
  const double asked_s = 0.25 * StabilitySeconds();
  RandomStream random(StabilitySeed(), "pairs");
  while (num_failed_ < 5 && (num_run_ < 8 || CpuSeconds(CLOCK_MONOTONIC) - begin_s < asked_s)) {
    const Extreme& a = extremes[random.Next() % extremes.size()];
    const Extreme& b = extremes[random.Next() % extremes.size()];
    if (a.pointer == b.pointer) continue;
    TryAndKeep(DocumentOf({a, b}, static_cast<std::uint64_t>(num_run_)),
               static_cast<std::uint64_t>(num_run_));
  }
  State(hard);
  hard.Note("seed", std::to_string(StabilitySeed()));
}

// Runs a failure again that was kept: developer/stability --reproduce FOLDER.
TEST_F(RandomScenarios, AGivenScenarioIsSound) {
  const char* file = std::getenv("ACUS_STABILITY_SCENARIO");
  if (file == nullptr) GTEST_SKIP() << "ACUS_STABILITY_SCENARIO names no scenario";
  const Outcome outcome = InChild([&] { Try(file, StabilitySeed()); });
  EXPECT_EQ(static_cast<int>(outcome.end), static_cast<int>(End::kSound))
      << outcome.what << "\nin: " << ScenarioTrial::NameOf(trace_->phase) << ", step "
      << trace_->num_steps;
}

/// A check that is broken on purpose: it fails on forces that are quite all right.
class FailingScenarios : public RandomScenarios {
 protected:
  FailingScenarios() {
    expects_failures_ = true;
    also_ = [](const simulation::StepOutput& out) {
      Require(out.force.force_in_ct_n.norm() < 0.2, "a force of 0.2 N, which is none too large");
    };
    failures_ = temporary_ / "kept";
  }
};

TEST_F(FailingScenarios, AreShrunkAndKeptSoThatTheyCanBeReplayed) {
  // Much that has nothing to do with it.
  const json document = {
      {"format", "acus-scenario/1"},
      {"patient",
       {{"ct", "ct.nrrd"},
        {"labels", "labels.seg.nrrd"},
        {"corridor", "corridor.csv"},
        {"ct_from_reference", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}}}},
      {"image_rate_hz", 10.0},
      {"effects",
       {{"needle_force", {{"model", "layered"}, {"guidance", "none"}}},
        {"tissue", {{"model", "springs"}, {"springs", {{"path_spacing_mm", 5.0}}}}},
        {"ultrasound", {{"model", "columns_2010"}, {"needle", false}}},
        {"ct_slice", json::object()}}}};
  ASSERT_EQ(TryAndKeep(document, 7), End::kViolated);
  const fs::path kept = failures_ / "1";
  const json small = config::ReadJson(kept / "scenario.json");
  EXPECT_FALSE(small.contains("image_rate_hz")) << small;
  EXPECT_FALSE(small["effects"].contains("ultrasound")) << small;
  EXPECT_FALSE(small["effects"].contains("ct_slice")) << small;
  EXPECT_TRUE(small["effects"].contains("needle_force") || small["effects"].contains("tissue"));
  EXPECT_THAT(ReadTextFile(kept / "what.txt"), testing::HasSubstr("a force of 0.2 N"));
  EXPECT_THAT(ReadTextFile(kept / "what.txt"), testing::HasSubstr("seed 7"));
  EXPECT_NE(fs::status(kept / "reproduce.sh").permissions() & fs::perms::owner_exec,
            fs::perms::none);

  // As acus-replay runs it: the same force in the last row, and below it before.
  RunContext context;
  replay::ReplayOptions options;
  options.run_folder = kept / "run";
  replay::ReplaySession(scenario::ReadScenario(kept / "scenario.json", {}), kept / "session",
                        options, context);
  std::istringstream rows(ReadTextFile(kept / "run/forces.csv"));
  std::vector<double> force_n;
  std::string row;
  std::getline(rows, row);
  EXPECT_TRUE(row.starts_with("time_s,depth_mm,tissue,force_axial_n")) << row;
  while (std::getline(rows, row)) {
    std::istringstream cells(row);
    std::string cell;
    for (int i = 0; i < 4; ++i) std::getline(cells, cell, ',');
    force_n.push_back(std::abs(std::stod(cell)));
  }
  ASSERT_EQ(force_n.size(), static_cast<std::size_t>(trace_->num_steps));
  EXPECT_GE(force_n.back(), 0.2);
  EXPECT_LT(*std::max_element(force_n.begin(), force_n.end() - 1), 0.2);

  // And by the test, alone.
  const Outcome again = InChild([&] { Try(kept / "trial.json", 7); });
  EXPECT_EQ(static_cast<int>(again.end), static_cast<int>(End::kViolated));
}

TEST_F(FailingScenarios, ACrashIsKeptWithTheStepThatDidIt) {
  also_ = [this](const simulation::StepOutput&) {
    if (trace_->num_steps == 100) std::abort();
  };
  const json document = {
      {"format", "acus-scenario/1"},
      {"patient",
       {{"ct", "ct.nrrd"},
        {"labels", "labels.seg.nrrd"},
        {"ct_from_reference", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}}}},
      {"effects", {{"needle_force", json::object()}}}};
  ASSERT_EQ(TryAndKeep(document, 3), End::kCrashed);
  EXPECT_THAT(ReadTextFile(failures_ / "1/what.txt"), testing::HasSubstr("step 100"));
  EXPECT_EQ(session::ReadSession(failures_ / "1/session", {}).needle.size(), 100u);
}

}  // namespace
}  // namespace acus::testing_support
