// The force that deformed tissue has on the probe keeps the limit of its table, torque and all.
#include <gtest/gtest.h>

#include "acus/base/config/json_file.h"
#include "support/effects_patient.h"
#include "support/effects_run.h"

namespace acus::simulation {
namespace {

/// Largest force and torque on the probe, N and N mm.
std::pair<double, double> LargestWith(const testing_support::EffectsPatient& patient,
                                      double limit_n) {
  nlohmann::json table = config::ReadJson(config::FindConfig("forces/default.json", "."));
  table["largest_force_n"] = limit_n;
  config::WriteJson(patient.folder() / "forces.json", table);
  const auto scenario = patient.With(
      {{"tissue",
        {{"model", "fe_3d"}, {"table", "forces.json"}, {"fe_3d", {{"probe_contact", true}}}}},
       {"probe_force", {{"model", "tissue"}}}});
  RunContext context;
  const Scene scene = LoadScene(
      scenario, PlanEffects(scenario, {.needle_poses = true, .probe_poses = true}), context);
  testing_support::EffectsRun run(scene);
  testing_support::Outputs out;
  run.Steps(40, {}, &out);
  double force_n = 0.0;
  double torque_n_mm = 0.0;
  for (std::size_t n = 0; n + 6 <= out.probe_force.size(); n += 6) {
    force_n = std::max(force_n, Eigen::Map<const Eigen::Vector3d>(&out.probe_force[n]).norm());
    torque_n_mm =
        std::max(torque_n_mm, Eigen::Map<const Eigen::Vector3d>(&out.probe_force[n + 3]).norm());
  }
  return {force_n, torque_n_mm};
}

TEST(ProbeForceLimit, HoldsForTheTissuesOwnForce) {
  const testing_support::EffectsPatient patient;
  const auto [force_n, torque_n_mm] = LargestWith(patient, 30.0);
  ASSERT_GT(force_n, 0.3) << "the probe presses hard enough for a limit to be met";
  ASSERT_LT(force_n, 30.0);
  const double limit_n = 0.5 * force_n;
  const auto [held_n, held_n_mm] = LargestWith(patient, limit_n);
  EXPECT_NEAR(held_n, limit_n, 1e-9);
  EXPECT_LT(held_n_mm, torque_n_mm);
}

}  // namespace
}  // namespace acus::simulation
