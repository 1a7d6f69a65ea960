// Random legal scenarios: no crash, nothing that is no number, no force over its limit, no energy
// from nowhere. Each runs in a process of its own; one that fails is shrunk to a small scenario
// file that does the same. ACUS_STABILITY_SECONDS=600 goes on for ten minutes.
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <gtest/gtest.h>
#include <limits>
#include <sys/wait.h>
#include <unistd.h>

#include "breathing/motion_file.h"
#include "config/json_file.h"
#include "core/atomic_file.h"
#include "core/cpu_time.h"
#include "core/error.h"
#include "forces/closed_loop.h"
#include "simulation/image_renderer.h"
#include "simulation/simulation.h"
#include "support/breathing_box.h"
#include "support/layered_scene.h"
#include "support/schema_sampler.h"
#include "support/temporary_folder.h"
#include "support/wild_hand.h"
#include "volume/volume_io.h"

namespace acus::simulation {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr double kEnergyLimitMj = 0.1;  // In four seconds; 1 mJ a minute is what is felt.
constexpr int kHandSteps = 4000;
constexpr int kWildSteps = 1500;
constexpr int kChildSeconds = 60;

class Violation : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

void Require(bool holds, const std::string& what) {
  if (!holds) throw Violation(what);
}

/// Keeps the rules between effects, which are not in the schema: what they forbid is tested where
/// they are checked, and would here only waste most of the draws.
json Mended(json document) {
  json& effects = document["effects"];
  const auto model_of = [&effects](const char* effect) {
    return effects.contains(effect) ? effects[effect].value("model", "") : std::string();
  };
  if (effects.contains("needle") || model_of("tissue") == "displacement_functions") {
    effects.emplace("needle_force", json::object());
  }
  if (model_of("needle_force") == "tissue" && model_of("tissue") != "springs" &&
      model_of("tissue") != "fe_2d") {
    effects["needle_force"].erase("model");
  }
  if (effects.contains("needle") || model_of("needle_force") == "tissue") {
    if (effects.contains("needle_force")) effects["needle_force"].erase("guidance");
  }
  if (model_of("needle") == "bendable") effects["needle"].erase("axis_lock");
  if (effects.empty()) effects["ct_slice"] = json::object();
  return document;
}

/// The layered patient on disk, with all that effects may ask for but a mesh.
class RandomScenarios : public testing::Test {
 protected:
  void SetUp() override {
    setenv("ACUS_CONFIGS", (fs::path(ACUS_SOURCE_DIR) / "configs").c_str(), 1);
    const Scene scene =
        testing_support::LayeredScene(testing_support::PlanOf(true, true, true, true), true);
    volume::WriteCt(folder_ / "ct.nrrd", *scene.ct);
    volume::WriteLabelMap(folder_ / "labels.seg.nrrd", *scene.labels);
    WriteTextFile(folder_ / "corridor.csv", "name,x_mm,y_mm,z_mm\nentry,0,0,0\ntarget,0,0,50\n");
    for (const char* kind : {"sinusoid", "full_cycle", "half_cycle", "surrogate"}) {
      breathing::PatientMotion motion{
          .name = kind,
          .model =
              breathing::BuildModel(breathing::MotionKindOf(kind), testing_support::TruePhases(8))};
      fs::create_directories(folder_ / kind);
      breathing::WritePatientMotion(folder_ / kind, motion);
    }
  }

  testing_support::SchemaSampler Sampler() const {
    testing_support::SchemaSampler::Choices choices = {
        {"/patient",
         {{{"ct", "ct.nrrd"}, {"labels", "labels.seg.nrrd"}, {"corridor", "corridor.csv"}}}},
        {"/session", {}},
        {"/needle",
         {"needles/spinal_22g.json", "needles/bevel_22g.json", "needles/trocar_18g.json"}},
        {"/probe", {"probes/linear_l14.json", "probes/curvilinear_c5.json"}},
        // Needs a condensed mesh, which has hard cases of its own.
        {"/effects/tissue/model", {"displacement_functions", "springs", "fe_2d"}},
        {"/effects/breathing/motion", {"sinusoid", "full_cycle", "half_cycle", "surrogate"}},
        {"/effects/breathing/from_session", {}},
        {"/effects/breathing/hold", {json::array(), {{1.0, 2.5}}}},
        // A film; its pictures have tests of their own.
        {"/effects/view_3d", {}}};
    return {json::parse(config::SchemaText("acus-scenario")), choices};
  }

  /// @throws Violation, or InputError where the scenario is not one after all.
  void Run(const json& document, std::uint64_t seed) const {
    const fs::path file = folder_ / Message("scenario_", seed, ".json");
    config::WriteJson(file, document);
    const auto scenario = scenario::ReadScenario(file, {});
    RunContext context;
    const Scene scene = LoadScene(
        scenario,
        PlanEffects(scenario, {.needle_poses = true, .probe_poses = true, .breath = false}),
        context);
    Felt(scene, seed);
    Wild(scene, seed);
  }

  enum class End { kSound, kRefused, kViolated, kCrashed };
  struct Outcome {
    End end = End::kSound;
    std::string what;
  };

  /// In a process of its own, so that a crash is an outcome like others.
  Outcome InChild(const json& document, std::uint64_t seed) const {
    int pipe_ends[2];
    if (pipe(pipe_ends) != 0) throw std::runtime_error("no pipe");
    std::fflush(nullptr);
    const pid_t child = fork();
    if (child == 0) {
      alarm(kChildSeconds);
      Outcome outcome;
      try {
        Run(document, seed);
      } catch (const InputError& error) {
        outcome = {End::kRefused, error.what()};
      } catch (const std::exception& error) {
        outcome = {End::kViolated, error.what()};
      }
      const auto written [[maybe_unused]] = write(pipe_ends[1], outcome.what.data(),
                                                  std::min<std::size_t>(outcome.what.size(), 4000));
      _exit(static_cast<int>(outcome.end));
    }
    close(pipe_ends[1]);
    std::string what;
    char buffer[512];
    for (ssize_t n = 0; (n = read(pipe_ends[0], buffer, sizeof buffer)) > 0;) {
      what.append(buffer, static_cast<std::size_t>(n));
    }
    close(pipe_ends[0]);
    int status = 0;
    waitpid(child, &status, 0);
    if (!WIFEXITED(status)) {
      return {End::kCrashed, Message("signal ", WTERMSIG(status),
                                     WTERMSIG(status) == SIGALRM ? " (took too long)" : "")};
    }
    return {static_cast<End>(WEXITSTATUS(status)), what};
  }

 private:
  static void CheckStep(const Scene& scene, const Simulation& simulation, const State& state,
                        const StepOutput& out) {
    const double most_n = scene.force_from_tissue || !scene.forces
                              ? 30.0
                              : scene.forces->table().settings.largest_force_n;
    Require(out.force.force_in_ct_n.allFinite(), "force is not finite");
    Require(out.force.force_in_ct_n.norm() <= most_n * (1.0 + 1e-9),
            Message("force of ", out.force.force_in_ct_n.norm(), " N is over ", most_n));
    Require(out.force.torque_in_ct_n_mm.allFinite(), "torque is not finite");
    Require(out.force.torque_in_ct_n_mm.norm() < 1e5, "torque is beyond all measure");
    Require(out.probe.force_in_ct_n.allFinite(), "probe force is not finite");
    Require(out.probe.force_in_ct_n.norm() <= 100.0, "probe force is over 100 N");
    Require(std::isfinite(out.shape.tip_deflection_mm), "deflection is not finite");
    math::Polyline line;
    if (!simulation.ShapeOf(state, line)) return;
    for (int i = 0; i < line.num_points; ++i)
      Require(line.At(i).allFinite(), "shape is not finite");
  }

  static Eigen::Isometry3d ProbeOnSkin(double t) {
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.linear() << 1, 0, 0, 0, 0, -1, 0, 1, 0;
    pose.translation() << 2.0 * std::sin(t), 3.0, std::sin(2.0 * t);
    return pose;
  }

  static void Look(const Scene& scene, const Simulation& simulation, const State& state,
                   const StepOutput& out, double t) {
    Snapshot snapshot{.time_ns = out.time_ns, .session_s = t};
    snapshot.probe_valid = true;
    snapshot.ct_from_probe = ProbeOnSkin(t);
    snapshot.ct_from_needle = out.ct_from_needle;
    math::Polyline line;
    if (simulation.ShapeOf(state, line)) snapshot.needle_shape = &line;
    tissue::TissueLoad load;
    if (scene.plan.Has(StageId::kDeformation) && simulation.LoadOf(state, out, load)) {
      snapshot.load = &load;
    }
    ImageRenderer renderer(scene);
    Images images;
    Images again;
    renderer.Render(snapshot, images);
    renderer.Render(snapshot, again);
    Require(images.b_mode.pixels == again.b_mode.pixels, "two B-modes of one moment differ");
    Require(images.ct_slice.pixels == again.ct_slice.pixels, "two slices of one moment differ");
  }

  /// A hand in and out of the tissue: sound, and it gets no energy.
  static void Felt(const Scene& scene, std::uint64_t seed) {
    const Simulation simulation(scene);
    State state = simulation.NewState();
    forces::RandomHand hand{.across_mm = 3.0};
    hand.to_mm = 58.0;
    hand.slowest_s = 1.0;
    const auto place = forces::RandomMotion(hand, 1e-3 * kHandSteps, seed);
    double balance_mj = 0.0;
    double generated_mj = 0.0;
    StepOutput before;
    for (int i = 0; i < kHandSteps; ++i) {
      const double t = 1e-3 * i;
      Sample sample{.time_ns = std::llround(1e9 * t), .needle_valid = true};
      sample.reference_from_needle.translation() = place(t);
      sample.probe_valid = true;
      sample.reference_from_probe = ProbeOnSkin(t);
      const StepOutput out = simulation.Step(state, sample);
      CheckStep(scene, simulation, state, out);
      const Eigen::Vector3d moved_mm =
          out.ct_from_needle.translation() - before.ct_from_needle.translation();
      balance_mj -= before.force.force_in_ct_n.dot(moved_mm);
      generated_mj = std::max(generated_mj, -balance_mj);
      if (out.force.force_in_ct_n.isZero() && out.force.torque_in_ct_n_mm.isZero())
        balance_mj = 0.0;
      before = out;
      if (i == 1500 || i == kHandSteps - 1) Look(scene, simulation, state, out, t);
    }
    // A patient who breathes does work on the needle.
    if (scene.breathing) return;
    Require(generated_mj <= kEnergyLimitMj, Message("gave ", generated_mj, " mJ"));
  }

  /// Jumps, lost poses, numbers that are none.
  static void Wild(const Scene& scene, std::uint64_t seed) {
    const Simulation simulation(scene);
    State state = simulation.NewState();
    testing_support::WildHand hand(seed);
    for (int i = 0; i < kWildSteps; ++i) {
      const forces::NeedleInput input = hand.Next();
      Sample sample{.needle_valid = input.valid};
      sample.time_ns = std::isfinite(input.time_s) && std::abs(input.time_s) < 1e9
                           ? std::llround(1e9 * input.time_s)
                           : std::numeric_limits<std::int64_t>::min();
      sample.reference_from_needle.linear().col(2) = input.axis_in_ct;
      sample.reference_from_needle.translation() = input.tip_in_ct_mm;
      sample.probe_valid = i % 7 != 0;
      sample.reference_from_probe = ProbeOnSkin(0.01 * i);
      if (i % 100 == 0) sample.reference_from_probe.translation() = input.tip_in_ct_mm;
      CheckStep(scene, simulation, state, simulation.Step(state, sample));
    }
  }

  testing_support::TemporaryFolder temporary_;

 protected:
  fs::path folder_ = temporary_.path();
};

TEST_F(RandomScenarios, AreSound) {
  const char* asked = std::getenv("ACUS_STABILITY_SECONDS");
  const char* first = std::getenv("ACUS_STABILITY_SEED");
  const double wanted_s = asked == nullptr ? 0.0 : std::atof(asked);
  const std::uint64_t seed_0 = first == nullptr ? 1 : std::strtoull(first, nullptr, 10);
  const auto sampler = Sampler();
  const double begin_s = CpuSeconds(CLOCK_MONOTONIC);
  const auto elapsed_s = [begin_s] { return CpuSeconds(CLOCK_MONOTONIC) - begin_s; };
  int num_run = 0;
  int num_refused = 0;
  int num_failed = 0;
  for (std::uint64_t seed = seed_0; num_run < 40 || elapsed_s() < wanted_s; ++seed) {
    const json document = Mended(sampler.Draw(seed));
    const Outcome outcome = InChild(document, seed);
    ++num_run;
    if (outcome.end == End::kSound) continue;
    if (outcome.end == End::kRefused) {
      ++num_refused;
      if (std::getenv("ACUS_STABILITY_VERBOSE") != nullptr)
        std::printf("  %s\n", outcome.what.c_str());
      continue;
    }
    const json small = testing_support::Shrunk(
        document, [&](const json& smaller) { return InChild(smaller, seed).end == outcome.end; });
    const fs::path kept = fs::path(ACUS_BUILD_DIR) / "random_scenarios" / Message("seed_", seed);
    fs::create_directories(kept);
    fs::copy(folder_, kept, fs::copy_options::recursive | fs::copy_options::overwrite_existing);
    config::WriteJson(kept / "scenario.json", small);
    ADD_FAILURE() << "seed " << seed << ": " << outcome.what << "\n"
                  << small.dump(2) << "\nkept in " << kept;
    if (++num_failed == 5) break;
  }
  std::printf("  %d scenarios, %d refused\n", num_run, num_refused);
  // What the schema allows is mostly a scenario.
  EXPECT_LT(num_refused, num_run / 2);
}

}  // namespace
}  // namespace acus::simulation
