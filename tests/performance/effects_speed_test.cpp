// Removing an effect never slows anything down: not the steps, not the images that are left, not
// the start, and not in memory. CPU times of runs in turns.
#include <gtest/gtest.h>
#include <malloc.h>
#include <set>
#include <sys/wait.h>
#include <unistd.h>

#include "acus/base/core/cpu_time.h"
#include "acus/base/core/error.h"
#include "acus/base/math/statistics.h"
#include "support/effects_patient.h"
#include "support/effects_run.h"

namespace acus::simulation {
namespace {

using nlohmann::json;

constexpr int kSteps = 400;
constexpr int kRounds = 3;     // Before the first judgement ...
constexpr int kPatience = 20;  // ... and once more each time that noise may have spoiled it.
constexpr double kNoise = 1.05;
constexpr double kNoiseMs = 0.02;

const testing_support::EffectsPatient& Patient() {
  static const testing_support::EffectsPatient patient;
  return patient;
}

json Everything() {
  return {{"needle_force", {{"model", "layered"}}},
          {"needle", {{"model", "bendable"}}},
          {"probe_force", {{"model", "multi_proxy"}}},
          {"tissue", {{"model", "springs"}}},
          {"breathing", {{"motion", "surrogate"}}},
          {"ultrasound", {{"model", "beams"}}},
          {"ct_slice", json::object()},
          {"fluoroscopy", json::object()},
          {"view_3d", {{"width_px", 96}, {"height_px", 72}, {"surface_grid_mm", 4}}}};
}

json Without(json effects, const std::string& effect) {
  effects.erase(effect);
  if (effect == "needle_force") effects.erase("needle");  // Says what is across its path.
  return effects;
}

/// CPU time, ms, of all steps together and of each kind of image, by round.
using Costs = std::map<std::string, std::vector<double>>;

Scene SceneOf(const json& effects) {
  const auto s = Patient().With(effects);
  RunContext context;
  return LoadScene(s, PlanEffects(s, {.needle_poses = true, .probe_poses = true}), context);
}

/// A scene that can be measured again and again.
class Measured {
 public:
  explicit Measured(const json& effects) : scene_(SceneOf(effects)) {}

  void Measure() {
    testing_support::EffectsRun run(scene_);
    const double begin_s = ThreadCpuSeconds();
    run.Steps(kSteps, {});
    Keep("steps", 1e3 * (ThreadCpuSeconds() - begin_s));
    testing_support::Outputs out;
    const Snapshot now = run.Now();
    run.RenderImages(now, out);  // Buffers are made now.
    StageTimes times(scene_.plan);
    run.RenderImages(now, out, &times);
    for (const PlannedStage& stage : scene_.plan.stages()) {
      if (!stage.in || stage.rate != "image" || times.Of(stage).runs == 0) continue;
      Keep(std::string(stage.name), 1e3 * times.Of(stage).seconds);
    }
  }
  const Costs& costs() const { return costs_; }

 private:
  void Keep(const std::string& what, double ms) { costs_[what].push_back(ms); }

  Scene scene_;
  Costs costs_;
};

double Least(const std::vector<double>& ms) {
  return *std::ranges::min_element(ms);
}

/// Of the ratios within the rounds.
double MedianRatio(const std::vector<double>& less, const std::vector<double>& all) {
  std::vector<double> ratios;
  for (std::size_t i = 0; i < less.size(); ++i) ratios.push_back(less[i] / all[i]);
  return math::Median(ratios);
}

/// What costs more in the scene with less in it. Neighbours on the machine can make one round slow
/// or lucky; what is really slower is so at its best and in most rounds.
std::string Slower(const Costs& less, const Costs& all) {
  std::string text;
  for (const auto& [what, ms] : less) {
    const auto before = all.find(what);
    if (before == all.end()) continue;
    if (Least(ms) <= kNoise * Least(before->second) + kNoiseMs) continue;
    if (MedianRatio(ms, before->second) <= kNoise) continue;
    text += Message("  ", what, ": ", Least(ms), " ms, was ", Least(before->second), " ms\n");
  }
  return text;
}

TEST(Effects, RemovingOneNeverSlowsTheOthersDown) {
  const json everything = Everything();
  for (const auto& [effect, settings] : everything.items()) {
    Measured all(everything);
    Measured less(Without(everything, effect));
    std::string slower;
    for (int round = 0; round < kRounds + kPatience; ++round) {
      (round % 2 == 0 ? all : less).Measure();
      (round % 2 == 0 ? less : all).Measure();
      if (round + 1 < kRounds) continue;
      slower = Slower(less.costs(), all.costs());
      if (slower.empty()) break;
    }
    EXPECT_EQ(slower, "") << "without " << effect;
    std::printf("  without %-12s", effect.c_str());
    for (const auto& [what, ms] : all.costs()) {
      const auto left = less.costs().find(what);
      if (left == less.costs().end()) continue;
      std::printf("  %s %.2f -> %.2f ms", what.c_str(), Least(ms), Least(left->second));
    }
    std::printf("\n");
  }
}

struct Start {
  double cpu_ms = 0.0;
  double held_mib = 0.0;  ///< On the heap, and mapped.
};

double HeldMib() {
  const struct mallinfo2 info = mallinfo2();
  return static_cast<double>(info.uordblks + info.hblkhd) / (1024.0 * 1024.0);
}

/// Loads in a process of its own: nothing is warm or held from before.
Start StartOf(const testing_support::EffectsPatient& patient, const json& effects) {
  const auto s = patient.With(effects);
  const auto plan = PlanEffects(s, {.needle_poses = true, .probe_poses = true});
  int ends[2];
  if (pipe(ends) != 0) throw std::runtime_error("no pipe");
  std::fflush(nullptr);
  const pid_t child = fork();
  if (child == 0) {
    RunContext context;
    context.num_threads = 1;
    const double before_mib = HeldMib();
    const double begin_s = ProcessCpuSeconds();
    const Scene scene = LoadScene(s, plan, context);
    const Start start{1e3 * (ProcessCpuSeconds() - begin_s), HeldMib() - before_mib};
    const auto written [[maybe_unused]] = write(ends[1], &start, sizeof start);
    _exit(0);
  }
  close(ends[1]);
  Start start;
  const auto got = read(ends[0], &start, sizeof start);
  close(ends[0]);
  waitpid(child, nullptr, 0);
  EXPECT_EQ(got, static_cast<ssize_t>(sizeof start));
  return start;
}

Start LeastStart(const testing_support::EffectsPatient& patient, const json& effects, int rounds) {
  Start least = StartOf(patient, effects);
  for (int i = 1; i < rounds; ++i) {
    least.cpu_ms = std::min(least.cpu_ms, StartOf(patient, effects).cpu_ms);
  }
  return least;
}

/// A CT of a size as patients have it, 60 MiB; the mesh stays small.
volume::Geometry PatientSized() {
  volume::Geometry geometry;
  geometry.size = {400, 400, 200};
  geometry.spacing_mm = {0.5, 0.5, 0.5};
  geometry.origin_mm = {-100.0, -100.0, -9.5};
  return geometry;
}

TEST(Effects, StartAndMemoryFollowWhatIsCalledFor) {
  const json everything = Everything();
  const testing_support::EffectsPatient patient(PatientSized());
  const json forces = {{"needle_force", {{"model", "layered"}}}};
  const json images = {{"ultrasound", json::object()}, {"ct_slice", json::object()}};
  const auto print = [](const std::string& what, const Start& start) {
    std::printf("  | %-24s | %6.0f | %7.1f |\n", what.c_str(), start.cpu_ms, start.held_mib);
  };
  std::printf("  | scene                    | CPU ms |     MiB |\n");
  const Start of_forces = LeastStart(patient, forces, 3);
  print("forces only", of_forces);
  const Start of_images = LeastStart(patient, images, 3);
  print("images only", of_images);
  for (const auto& [effect, settings] : everything.items()) {
    json alone = {{effect, settings}};
    if (effect == "needle") alone["needle_force"] = everything.at("needle_force");
    if (effect == "breathing") alone["ct_slice"] = json::object();
    print(effect + (alone.size() > 1 ? " (with another)" : ""), LeastStart(patient, alone, 2));
  }
  const Start whole = LeastStart(patient, everything, 3);
  print("everything", whole);
  // The CT has two bytes a voxel, the label map one.
  const double voxels_mib = PatientSized().size.cast<double>().prod() / (1024.0 * 1024.0);
  EXPECT_LT(of_forces.held_mib, 1.2 * voxels_mib);
  EXPECT_GT(of_images.held_mib, 2.0 * voxels_mib);
  EXPECT_LT(of_images.held_mib, 2.4 * voxels_mib);
  EXPECT_LT(of_forces.cpu_ms, whole.cpu_ms);
  EXPECT_LT(of_images.cpu_ms, whole.cpu_ms);
  for (const auto& [effect, settings] : everything.items()) {
    const Start less = StartOf(patient, Without(everything, effect));
    print("everything but " + effect, less);
    EXPECT_LE(less.held_mib, whole.held_mib + 0.1) << effect;
    Start again = less;
    double most_ms = whole.cpu_ms;
    for (int i = 0; i < kPatience && again.cpu_ms > kNoise * most_ms + 5.0; ++i) {
      again.cpu_ms = std::min(again.cpu_ms, StartOf(patient, Without(everything, effect)).cpu_ms);
      most_ms = std::max(most_ms, StartOf(patient, everything).cpu_ms);
    }
    EXPECT_LE(again.cpu_ms, kNoise * most_ms + 5.0) << effect;
  }
}

}  // namespace
}  // namespace acus::simulation
