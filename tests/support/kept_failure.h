// A scenario that failed, as files that anybody can run again.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "acus/base/config/json_file.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/run_context.h"
#include "acus/data/session/session_io.h"
#include "support/scenario_trial.h"

namespace acus::testing_support {

/// What was done to the scenario, as a session: of the samples those that a recording can hold.
inline session::Session SessionOf(const TrialTrace& trace) {
  session::Session session;
  session.name = ScenarioTrial::NameOf(trace.phase);
  std::int64_t last_ns = -1;
  for (int i = 0; i < trace.num_steps; ++i) {
    const TrialTrace::Place& place = trace.place[i];
    const Eigen::Vector3d tip_mm(place.tip_mm[0], place.tip_mm[1], place.tip_mm[2]);
    const Eigen::Vector3d axis(place.axis[0], place.axis[1], place.axis[2]);
    const bool is_pose = tip_mm.allFinite() && tip_mm.norm() < 1e6 && axis.allFinite() &&
                         axis.norm() > 1e-3 && axis.norm() < 1e3;
    if (place.time_ns <= last_ns || !is_pose) continue;
    last_ns = place.time_ns;
    const Eigen::Quaterniond turn =
        Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), axis.normalized());
    session.needle.push_back({.time_ns = place.time_ns,
                              .reference_from_tool = transforms::Pose(turn, tip_mm),
                              .valid = place.valid});
    session.probe.push_back({.time_ns = place.time_ns,
                             .reference_from_tool = transforms::Pose(
                                 ProbeOnSkin(1e-9 * static_cast<double>(last_ns)))});
  }
  return session;
}

struct FailureToKeep {
  nlohmann::json scenario;  ///< Shrunk.
  std::string what;
  std::uint64_t seed = 0;
};

/// Writes `folder`: scenario.json, session/ (if there was a step), what they need of
/// `patient_folder`, what.txt and the script reproduce.sh. Replaces what is there.
inline void KeepFailure(const std::filesystem::path& folder, const FailureToKeep& failure,
                        const TrialTrace& trace, const std::filesystem::path& patient_folder) {
  namespace fs = std::filesystem;
  fs::remove_all(folder);
  fs::create_directories(folder);
  fs::copy(patient_folder, folder, fs::copy_options::recursive);
  nlohmann::json scenario = failure.scenario;
  if (trace.phase == ScenarioTrial::kHeldBreath) {
    scenario["effects"]["breathing"]["hold"] = {{ScenarioTrial::kHeldFromS, 1e4}};
  }
  // The trial's hands are in the frame of the CT, which a session has to say.
  if (!scenario["patient"].contains("ct_from_reference") &&
      !scenario["patient"].contains("ct_from_reference_file")) {
    scenario["patient"]["ct_from_reference"] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  }
  config::WriteJson(folder / "scenario.json", scenario);
  // Before the hand's steps it breathes as drawn, in the trial too.
  config::WriteJson(folder / "trial.json", failure.scenario);
  const session::Session session = SessionOf(trace);
  if (!session.needle.empty()) session::WriteSession(folder / "session", session, RunContext());
  WriteTextFile(folder / "what.txt",
                Message(failure.what, "\nin: ", ScenarioTrial::NameOf(trace.phase), ", step ",
                        trace.num_steps, ", seed ", failure.seed,
                        "\nscenario.json is the smallest scenario that does it; session/ is what "
                        "the hand did up to that step,\nwithout samples that are no poses.\n"
                        "To see it:    acus-replay scenario.json session -o run\n"
                        "To check it:  developer/stability --reproduce FOLDER\n"));
  WriteTextFile(
      folder / "reproduce.sh",
      Message("#!/usr/bin/env bash\n# ", failure.what.substr(0, failure.what.find('\n')),
              "\n# Runs the scenario as users do; then, given the program of the test, checks it.\n"
              "set -u\ncd \"$(dirname \"${BASH_SOURCE[0]}\")\" || exit 1\n"
              "if [[ -d session ]]; then\n"
              "  acus-replay scenario.json session -o run --overwrite --quiet\n"
              "  echo \"acus-replay: exit code $?\"\nfi\n"
              "if [[ $# -gt 0 ]]; then\n"
              "  ACUS_STABILITY_SCENARIO=$PWD/trial.json ACUS_STABILITY_SEED=",
              failure.seed, " exec \"$1\" --gtest_filter='*.AGivenScenarioIsSound'\nfi\n"));
  fs::permissions(folder / "reproduce.sh", fs::perms::owner_all, fs::perm_options::add);
}

}  // namespace acus::testing_support
