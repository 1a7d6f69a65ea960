// What the papers say of their speed, done here: numbers for docs/papers-claims.md. CPU time of one
// thread. Every number is checked to be of something that worked; a solver that has diverged can
// look fast.
#include <CLI/CLI.hpp>
#include <cmath>
#include <iostream>

#include "acus/base/config/json_file.h"
#include "acus/base/core/cpu_time.h"
#include "acus/base/core/error.h"
#include "acus/base/core/run_main.h"
#include "acus/base/math/statistics.h"
#include "acus/imaging/volume_rendering/moving_surface.h"
#include "acus/imaging/volume_rendering/patient_view.h"
#include "acus/physics/tissue/plane_model_2010.h"
#include "acus/scene/simulation/breathing_scene.h"
#include "acus/scene/simulation/simulation.h"
#include "benchmarks/insertion.h"
#include "benchmarks/tissue_run.h"
#include "benchmarks/trunk_body.h"
#include "support/bending_scene.h"
#include "support/breathing_patients.h"
#include "support/layered_tissue.h"
#include "support/wound_sheet.h"

namespace {

using namespace acus;  // NOLINT: a program of one file.

/// A number that is not positive, or a run that did not work, is no answer.
class Results {
 public:
  void Add(const std::string& name, double value) {
    if (!(std::isfinite(value) && value > 0.0)) Fail(name + " is not positive");
    numbers_[name] = value;
    std::cout << name << " " << value << std::endl;
  }
  /// Median and 99.9th percentile.
  void AddTimes(const std::string& name, const std::vector<double>& times_us) {
    Add(name + "_median_us", math::Median(times_us));
    Add(name + "_p999_us", math::Quantile(times_us, 0.999));
  }
  void Fail(const std::string& why) {
    std::cerr << "not plausible: " << why << std::endl;
    plausible_ = false;
  }
  void Require(bool is_so, const std::string& what) {
    if (!is_so) Fail(what);
  }
  bool plausible() const { return plausible_; }
  const nlohmann::json& numbers() const { return numbers_; }

 private:
  nlohmann::json numbers_ = nlohmann::json::object();
  bool plausible_ = true;
};

/// What Augmented-2010 counts: one node of the needle changes between stick and slip, and all
/// forces at the needle follow, on a square plane of `side` x `side` nodes.
void Swaps(int side, Results& results) {
  const testing_support::Layers body{{{0, "skin"}, {2, "fat"}, {20, "liver"}}};
  tissue::PlaneSettings settings;
  settings.spacing_mm = settings.width_mm / (side - 1);
  settings.above_mm = settings.spacing_mm;
  settings.depth_mm = settings.width_mm - settings.above_mm;
  const tissue::PlaneModel2010 model(settings, {}, testing_support::RoundForces(),
                                     testing_support::Trocar18(),
                                     testing_support::RoundElasticity(), body.At());
  const mechanics::PlaneGrid& grid = model.planes().grid();
  const std::string name = "swap_" + std::to_string(grid.num_nodes());
  for (const auto update : {tissue::PlaneUpdate::kFull, tissue::PlaneUpdate::kRestricted}) {
    tissue::PlaneContact contact(model.planes().compliance(), 2 * grid.rows, update);
    for (int row = 0; row < grid.rows; ++row) {
      const int dof = model.planes().dof_of_node()[grid.Node(grid.columns / 2, row)];
      if (dof >= 0) contact.Append(dof, 0.0, 1.0);
    }
    for (int i = 0; i < contact.size(); ++i) {
      contact.SetDemand(i, i % 2 == 0 ? 1.0 : 0.1, -0.1, 1e3);
    }
    contact.Solve(1e-10);
    constexpr int kAtOnce = 20;  // Reading the clock takes 0.2 us.
    std::vector<double> times_us;
    int slot = 0;
    for (int n = 0; n < 50; ++n) {
      const double begin_s = ThreadCpuSeconds();
      for (int m = 0; m < kAtOnce; ++m, slot = (slot + 2) % contact.size()) {
        contact.SwapForTest(slot);
      }
      times_us.push_back(1e6 * (ThreadCpuSeconds() - begin_s) / kAtOnce);
    }
    for (int i = 0; i < contact.size(); ++i) {
      results.Require(std::abs(contact.ForceN(i)) < 100.0, name + ": forces out of bounds");
    }
    const bool full = update == tissue::PlaneUpdate::kFull;
    results.Add(name + (full ? "_full_us" : "_restricted_us"), math::Median(times_us));
  }
}

/// Augmented-2010: 361 nodes at 512 Hz, over 1000 at 1 kHz; here the plane of the paper, and meshes
/// in three dimensions, under the same scripted insertion at 1 kHz.
void FiniteElements(bool quick, Results& results, RunContext& context) {
  const auto tables = benchmarks::TissueBlockTables::FromPresets(context.provenance);
  const auto samples = benchmarks::ScriptedInsertion();
  const double largest_n = tables.forces.settings.largest_force_n;
  const auto add = [&](const std::string& name, const benchmarks::MeasuredRun& run) {
    const std::string wrong = benchmarks::WhyUnusable(run.run, samples, largest_n);
    results.Require(wrong.empty(), name + ": " + wrong);
    results.AddTimes(name, run.run.step_us);
    results.Require(math::Quantile(run.run.step_us, 0.999) < 1000.0,
                    name + " does not run at 1 kHz");
  };
  // Every change of a step on the whole inverse, as in the claim of 512 Hz.
  const tissue::PlaneModel2010 plane = benchmarks::PlaneOf(5.0, 90.0, 78.0, tables, samples);
  benchmarks::MeasuredRun whole;
  whole.run = benchmarks::Insert(plane.WithUpdate(tissue::PlaneUpdate::kFull), samples);
  add("plane_361_full", whole);
  for (const double element_mm :
       quick ? std::vector{12.0} : std::vector{12.0, 6.0, 4.0, 3.0, 2.0}) {
    context.Checkpoint("finite elements", 0.05);
    benchmarks::FemSetting setting;
    setting.element_mm = element_mm;
    RunContext quiet;
    quiet.stop = context.stop;
    const std::string name = "fe_" + std::to_string(static_cast<int>(element_mm)) + "mm";
    const benchmarks::MeasuredRun run = benchmarks::RunFem(setting, tables, samples, quiet);
    results.Add(name + "_nodes", run.num_nodes);
    add(name, run);
  }
}

/// Fortmeier-2016: algorithm 1 with the paper's needle of 25 nodes and its constants in a breathing
/// patient, whole steps of the simulation.
void BreathingNeedle(bool quick, Results& results) {
  testing_support::BendingScene bending;
  bending.tissue = nullptr;  // Layers.
  bending.force = scenario::NeedleForceModelKind::kTissue;
  bending.needle = "needles/measured_16g.json";
  bending.table = "forces/fortmeier.json";
  bending.elasticity = "elasticity/fortmeier.json";
  bending.springs.node_spacing_mm = 2.0;
  bending.effect.nodes = 25;
  bending.effect.path_spacing_mm = 2.0;
  bending.effect.bevel = false;
  simulation::Scene scene = bending.Make();
  testing_support::BreathingPatient patient{.kind = breathing::MotionKind::kSurrogate,
                                            .nodes_per_axis = 128};
  patient.box.size.setConstant(301);
  patient.box.origin_mm = {-150.0, -150.0, -70.0};
  patient.towards = {0.0, 1.0, 0.3};
  scene.breathing.emplace(patient.Make());
  const simulation::Simulation simulation(scene);
  simulation::State state = simulation.NewState();
  std::vector<double> times_us;
  double largest_n = 0.0;
  for (int n = 0; n < (quick ? 4000 : 40000); ++n) {
    const double t = 5e-4 * n;  // 2 kHz
    const double depth_mm = t < 1.0 ? 45.0 * t - 2.0 : 43.0 + 8.0 * std::sin(2.0 * t - 2.0);
    const auto sample = testing_support::NeedleAt(
        t, {std::sin(3.0 * t), std::cos(2.1 * t), depth_mm}, {0.1 * std::sin(2.5 * t), 0.05, 0.0});
    const double begin_s = ThreadCpuSeconds();
    const auto step = simulation.Step(state, sample);
    const double took_us = 1e6 * (ThreadCpuSeconds() - begin_s);
    largest_n = std::max(largest_n, step.force.force_in_ct_n.norm());
    if (step.shape.bent) times_us.push_back(took_us);
  }
  results.Require(times_us.size() > 1500, "the needle is hardly ever bent");
  results.Require(largest_n > 0.1 && largest_n < 20.0, "forces out of bounds");
  results.AddTimes("breathing_step", times_us);
  results.Require(math::Quantile(times_us, 0.99) < 500.0, "the step does not run at 2 kHz");
}

/// Fortmeier-2016, table 2. Components of the field: none; 2, between two key frames; 3, of the
/// surrogate model.
struct View {
  const char* layer;
  const char* motion;
  int num_components;
};

/// A CT of 256^3 voxels, fields of 128^3 nodes, 1224 x 1014 pixels.
void VolumeRendering(bool quick, Results& results, const RunContext& context) {
  const auto ct = benchmarks::TrunkBody::Ct(quick ? 96 : 256);
  const volume_rendering::ImageSize size =
      quick ? volume_rendering::ImageSize{200, 166} : volume_rendering::ImageSize{1224, 1014};
  breathing::MotionField field;
  for (const View view : {View{"skin", "at_rest", 0},
                          {"bone", "at_rest", 0},
                          {"skin", "key_frames", 2},
                          {"bone", "key_frames", 2},
                          {"skin", "surrogate", 3},
                          {"bone", "surrogate", 3}}) {
    context.Checkpoint("volume rendering", 0.6);
    if (view.num_components > 0 && field.num_components() != view.num_components) {
      field = benchmarks::TrunkBody::Breath(quick ? 32 : 128, view.num_components);
    }
    breathing::MotionWeights weights;
    for (int i = 0; i < view.num_components; ++i) weights.Add(i, i == 0 ? 0.9 : 0.3);
    const breathing::MotionMap motion(field, weights);
    const bool is_breathing = view.num_components > 0;
    volume_rendering::PatientInView patient;
    patient.ct = ct;
    patient.layers = {{view.layer, 1.0}};
    patient.field = is_breathing ? &field : nullptr;
    volume_rendering::PatientView renderer(patient, {});
    const auto camera = LookAt(ViewFrom("oblique", renderer.box_in_ct_mm(), size), size);
    volume_rendering::ViewImage image;
    std::vector<double> times_ms;
    for (int n = 0; n < (quick ? 2 : 7); ++n) {
      const double begin_s = ThreadCpuSeconds();
      renderer.Render(camera, {.motion = is_breathing ? &motion : nullptr}, image, 1);
      times_ms.push_back(1e3 * (ThreadCpuSeconds() - begin_s));
    }
    const auto shown = std::ranges::count_if(image.coverage, [](auto c) { return c > 0; });
    const std::string name = "volume_" + std::string(view.layer) + "_" + view.motion;
    results.Require(shown * 20 > static_cast<std::ptrdiff_t>(image.coverage.size()),
                    name + " shows nothing");
    results.Add(name + "_ms", math::Median(times_ms));
  }
  for (const int count : quick ? std::vector{12026} : std::vector{430578, 145648, 12026}) {
    volume_rendering::MovingSurface surface(testing_support::WoundSheet(count));
    const Eigen::Matrix3Xf rest = surface.nodes_mm();
    std::vector<double> times_ms;
    for (int n = 0; n < 16; ++n) {
      breathing::MotionWeights breath;
      breath.Add(0, 0.5 + 0.02 * n);
      const breathing::MotionMap moment(field, breath);
      const double begin_s = ThreadCpuSeconds();
      surface.Update(&moment, 1);
      if (n > 0) times_ms.push_back(1e3 * (ThreadCpuSeconds() - begin_s));
    }
    results.Require((surface.nodes_mm() - rest).cwiseAbs().maxCoeff() > 1.0F,
                    "no vertex has moved");
    results.Add("vertices_" + std::to_string(count) + "_ms", math::Median(times_ms));
  }
}

}  // namespace

int main(int argc, char** argv) {
  std::filesystem::path output;
  bool quick = false;
  CLI::App app{"What the papers say of their speed, done here.", "bench_paper_claims"};
  app.add_option("-o,--output", output, "Write the numbers to this file, as JSON");
  app.add_flag("--quick", quick, "Small sizes: to see that it works");
  app.footer("EXAMPLE\n  bench_paper_claims -o papers-claims.json");
  return RunMain(app, argc, argv, [&](RunContext& context) {
    Results results;
    for (const int side : {19, 33}) Swaps(side, results);
    FiniteElements(quick, results, context);
    BreathingNeedle(quick, results);
    VolumeRendering(quick, results, context);
    if (!results.plausible()) throw NoAnswerError("a number is not plausible; nothing was written");
    if (!output.empty()) config::WriteJson(output, results.numbers());
    return ExitCode::kOk;
  });
}
