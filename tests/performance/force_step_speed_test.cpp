// All that a step of forces can be made of must leave most of the hand's millisecond to others.
#include <algorithm>
#include <cstdio>
#include <gtest/gtest.h>

#include "acus/base/core/cpu_time.h"
#include "acus/base/math/statistics.h"
#include "acus/physics/forces/models/force_model.h"
#include "acus/physics/forces/probe/vidal_probe.h"
#include "benchmarks/force_model_cases.h"
#include "support/force_scenes.h"

namespace acus::benchmarks {
namespace {

// Every force model, tissue of every model, a needle of 25 nodes, and the probe, one after the
// other in one step: more than any scene calls for. Measured 16 us (2.6 GHz).
TEST(ForceStepSpeed, EveryComponentTogetherTakesLessThanFiftyMicroseconds) {
  const std::vector<ForceModelCase> models = ForceModelCases({}, {});
  std::vector<std::function<forces::NeedleForce(const tissue::ToolSample&)>> needles;
  for (const ForceModelCase& model : models) needles.push_back(model.begin());
  const testing_support::LayeredBodyField body(
      {{0.0, "skin", 20}, {2.0, "fat", -100}, {20.0, "bone", 900}});
  const forces::VidalProbe probe(testing_support::ShippedTable("vidal.json"), body);
  testing_support::DrivenProbe driven{probe};

  const std::vector<tissue::ToolSample> samples = SamplesEvery(1.0);
  std::vector<double> all_us;
  std::vector<std::vector<double>> part_us(needles.size() + 1);
  double felt_n = 0.0;
  for (const tissue::ToolSample& sample : samples) {
    const double begin_s = ThreadCpuSeconds();
    double before_s = begin_s;
    for (std::size_t i = 0; i < needles.size(); ++i) {
      felt_n += needles[i](sample).force_in_ct_n.norm();
      const double now_s = ThreadCpuSeconds();
      part_us[i].push_back(1e6 * (now_s - before_s));
      before_s = now_s;
    }
    // Pressed 8 mm into the skin, sliding.
    felt_n +=
        driven.Step(sample.time_s, {sample.time_s, 0.0, std::min(8.0, 20.0 * sample.time_s - 4.0)})
            .force_in_ct_n.norm();
    const double end_s = ThreadCpuSeconds();
    part_us.back().push_back(1e6 * (end_s - before_s));
    all_us.push_back(1e6 * (end_s - begin_s));
  }
  EXPECT_GT(felt_n, 1000.0);
  for (std::size_t i = 0; i < part_us.size(); ++i) {
    std::printf("  %-16s %6.2f us\n", i < models.size() ? models[i].name.c_str() : "probe",
                math::Median(part_us[i]));
  }
  std::printf("  %-16s %6.2f us\n", "all", math::Median(all_us));
  EXPECT_LT(math::Median(all_us), 50.0);
}

/// Eight layers in 50 mm, in voxels of 0.7 mm, and the same as HU.
volume::LabelMap LayersToSweep(volume::CtVolume& ct) {
  volume::Geometry geometry;
  geometry.size = {31, 31, 130};
  geometry.spacing_mm.setConstant(0.7);
  geometry.origin_mm = {-10.5, -10.5, -10.0};
  volume::LabelMap labels(geometry, 0);
  ct = volume::CtVolume(geometry, -1000);
  const char* tissues[] = {"skin", "fat", "muscle", "fat", "liver", "vessel", "liver", "fat"};
  const std::int16_t hu[] = {20, -100, 55, -100, 60, 180, 60, -100};
  for (std::size_t i = 0; i < labels.voxels.size(); ++i) {
    const double z_mm = -10.0 + 0.7 * static_cast<double>(i / (31 * 31));
    if (z_mm < 0.0) continue;
    const auto layer = std::min<std::size_t>(7, static_cast<std::size_t>(z_mm / 6.0));
    labels.voxels[i] = volume::LabelOf(tissues[layer]);
    ct.voxels[i] = hu[layer];
  }
  return labels;
}

// A jump of 50 mm is searched for tissue, and taken in as many steps as there are things to meet.
TEST(ForceStepSpeed, AJumpOfFiftyMillimetresTakesLessThanSixHundredStepsAtRest) {
  volume::CtVolume ct;
  const volume::LabelMap labels = LayersToSweep(ct);
  const forces::CtField field(ct);
  const forces::TissueLookup lookup(labels);
  const auto needle = testing_support::Trocar18G();
  using testing_support::ShippedTable;
  const std::pair<const char*, forces::ForceModel> models[] = {
      {"layered",
       forces::ForceModel(forces::NeedleForceModel(ShippedTable("default.json"), needle))},
      {"alamilla",
       forces::ForceModel(forces::AlamillaModel(ShippedTable("alamilla.json"), needle))},
      {"vidal", forces::ForceModel(forces::VidalModel(ShippedTable("vidal.json"), needle, field))}};
  for (const auto& [name, model] : models) {
    std::vector<double> jump_us, rest_us;
    for (int run = 0; run < 201; ++run) {
      forces::ForceState state = model.NewState();
      forces::PassedEvents events;
      const auto step_to = [&](double z_mm, double time_s) {
        const Eigen::Vector3d tip_mm(0.0, 0.0, z_mm);
        model.StepAlong(state, {time_s, tip_mm, Eigen::Vector3d::UnitZ(), lookup.At(tip_mm), true},
                        {&lookup}, events);
      };
      step_to(-1.0, 0.0);
      const double begin_s = ThreadCpuSeconds();
      step_to(49.0, 0.01);
      jump_us.push_back(1e6 * (ThreadCpuSeconds() - begin_s));
      ASSERT_GT(events.num, 5);
      constexpr int kAtRest = 100;  // Of which one is too short for the clock.
      const double rest_s = ThreadCpuSeconds();
      for (int n = 1; n <= kAtRest; ++n) step_to(49.0, 0.01 + 1e-3 * n);
      rest_us.push_back(1e6 / kAtRest * (ThreadCpuSeconds() - rest_s));
    }
    const double ratio = math::Median(jump_us) / math::Median(rest_us);
    std::printf("  %-16s jump of 50 mm %6.2f us, %4.0f steps at rest\n", name,
                math::Median(jump_us), ratio);
    EXPECT_LT(ratio, 600.0) << name;
  }
}

}  // namespace
}  // namespace acus::benchmarks
