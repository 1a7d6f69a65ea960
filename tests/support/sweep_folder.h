// A layered patient, a session of a second with needle and probe, and a scenario: for sweeps.
#pragma once

#include <filesystem>
#include <gtest/gtest.h>
#include <string>

#include "acus/assess/tuning/scene_sweep.h"
#include "acus/data/session/session_io.h"
#include "support/layered_folder.h"
#include "support/temporary_folder.h"

namespace acus::testing_support {

class SweepFolder : public testing::Test {
 protected:
  /// Writes scene.json with these effects, and session/.
  void Make(const std::string& effects) {
    WriteLayeredFolder(folder_, effects, 4);
    session::WriteSession(folder_ / "session", Insertion(), context_);
    request_.scene = {.scenario = folder_ / "scene.json",
                      .changes = {},
                      .session = folder_ / "session",
                      .from_s = 0.0,
                      .to_s = 0.0,
                      .most_images = 2};
    request_.repetitions = 1;
  }

  /// From above the skin to 30 mm in one second, with a push aside; the probe beside it.
  static session::Session Insertion() {
    session::Session session;
    session.name = "insertion";
    for (int ms = 0; ms <= 1000; ++ms) {
      session::PoseSample needle{.time_ns = ms * std::int64_t{1'000'000}};
      const double aside_mm = ms < 700 ? 0.0 : 2.0 * std::sin(0.01 * (ms - 700));
      needle.reference_from_tool =
          Eigen::Isometry3d(Eigen::Translation3d(aside_mm, 20.0, -5.0 + 0.035 * ms));
      session.needle.push_back(needle);
      if (ms % 20 != 0) continue;
      Eigen::Isometry3d probe = Eigen::Isometry3d::Identity();
      probe.linear() << 1, 0, 0, 0, 0, -1, 0, 1, 0;
      probe.translation() << 0.0, 20.0 + 1e-3 * ms, -0.5;
      session.probe.push_back(
          {.time_ns = ms * std::int64_t{1'000'000}, .reference_from_tool = probe, .valid = true});
    }
    return session;
  }

  tuning::SweepPlan Plan() { return tuning::MakePlan(request_, context_); }

  /// Runs all that is missing in `name`.
  tuning::SweepResult Sweep(const char* name) {
    const auto plan = Plan();
    const tuning::RunStore store(folder_ / name, tuning::IdentityOf(plan), false);
    tuning::RunCases(plan, store, "", context_);
    return tuning::Collect(plan, store);
  }

  static const tuning::SettingResult& Of(const tuning::SweepResult& result,
                                         const tuning::Setting& setting) {
    for (const auto& one : result.settings) {
      if (one.setting == setting) return one;
    }
    throw std::runtime_error("not swept: " + tuning::TextOf(setting));
  }

  TemporaryFolder temporary_;
  std::filesystem::path folder_ = temporary_.path();
  RunContext context_;
  tuning::SweepRequest request_;
};

/// A needle that bends in springs, and no images: quick.
inline constexpr const char* kBendableEffects =
    R"({"needle_force": {"model": "tissue"}, "tissue": {"model": "springs"},
        "needle": {"model": "bendable", "nodes": 15}})";

}  // namespace acus::testing_support
