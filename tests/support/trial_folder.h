// An exercise in the layered patient on disk: a target 30 mm below the skin, and sessions.
#pragma once

#include <cmath>

#include "acus/assess/trials/trial_scene.h"
#include "acus/data/session/session_io.h"
#include "support/layered_folder.h"
#include "support/temporary_folder.h"

namespace acus::testing_support {

class TrialFolder : public testing::Test {
 protected:
  void SetUp() override {
    WriteLayeredFolder(folder_, R"({"needle_force": {}, "ct_slice": {}})", 1);
    WriteTextFile(folder_ / "corridor.csv", "name,x_mm,y_mm,z_mm\nentry,3,0,0\ntarget,3,10,30\n");
    WriteTextFile(folder_ / "exercise.json", R"({
      "format": "acus-exercise/1", "name": "Layers", "target": {"radius_mm": 3}, "avoid": ["bone"],
      "goals": [{"metric": "tip to target at the end", "at_most": 3},
                {"metric": "entries into what is to be spared", "at_most": 0},
                {"metric": "attempts", "at_most": 1},
                {"metric": "needle in the image plane", "at_least": 70}]})");
  }

  scenario::Scenario Scenario() const {
    const std::vector<scenario::Override> changes = {
        {"/patient/corridor", (folder_ / "corridor.csv").string()}};
    return scenario::ReadScenario(folder_ / "scene.json", changes);
  }

  trials::TrialScene Loaded(const session::Session& like) {
    return trials::LoadTrialScene(Scenario(), folder_ / "exercise.json", like, context_);
  }

  /// Straight in from 10 mm outside, 40 degrees off the skin's normal towards +y, at 20 mm/s, to
  /// 35 mm of depth along the needle, entry (3, -5, 0); the probe's plane is x = 3.
  static session::Session Insertion() {
    session::Session session;
    session.name = "insertion";
    const Eigen::Vector3d axis = TrialAxis();
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.linear() =
        Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), axis).toRotationMatrix();
    Eigen::Isometry3d probe = Eigen::Isometry3d::Identity();
    probe.linear() << 0, 0, 1, 1, 0, 0, 0, 1, 0;
    probe.translation() << 3.0, 10.0, 0.0;
    for (int ms = 0; ms <= 2500; ++ms) {
      const double along_mm = std::min(35.0, -10.0 + 0.02 * ms);
      pose.translation() = Eigen::Vector3d(3.0, -5.0, 0.0) + along_mm * axis;
      session.needle.push_back({ms * std::int64_t{1'000'000}, pose, true});
      if (ms % 20 == 0) session.probe.push_back({ms * std::int64_t{1'000'000}, probe, true});
    }
    return session;
  }
  static Eigen::Vector3d TrialAxis() {
    constexpr double kTiltRad = 40.0 * 3.14159265358979323846 / 180.0;
    return {0.0, std::sin(kTiltRad), std::cos(kTiltRad)};
  }

  TemporaryFolder temporary_;
  std::filesystem::path folder_ = temporary_.path();
  RunContext context_;
};

}  // namespace acus::testing_support
