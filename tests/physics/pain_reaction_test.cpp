// A patient who jerks away from the needle, in a whole scene: when, how far, and what tools feel.
#include <gtest/gtest.h>

#include "acus/base/config/json_file.h"
#include "acus/data/volume/volume_io.h"
#include "acus/scene/simulation/simulation.h"
#include "support/temporary_folder.h"

namespace acus::simulation {
namespace {

constexpr std::int64_t kStepNs = 1'000'000;

/// Muscle from y = 0 on, under 2 mm of skin; the needle comes along y, 10 mm/s.
class PainScene : public testing::Test {
 protected:
  PainScene() {
    setenv("ACUS_CONFIGS", (std::filesystem::path(ACUS_SOURCE_DIR) / "configs").c_str(), 1);
    volume::Geometry geometry;
    geometry.size = {30, 80, 30};
    geometry.origin_mm = {-15.0, -20.0, -15.0};
    volume::LabelMap labels(geometry);
    labels.names[1] = "skin";
    labels.names[3] = "muscle";
    for (int k = 0; k < 30; ++k) {
      for (int j = 20; j < 80; ++j) {
        for (int i = 0; i < 30; ++i) labels.At(i, j, k) = j < 22 ? 1 : 3;
      }
    }
    volume::WriteLabelMap(folder() / "labels.seg.nrrd", labels);
  }

  struct Seen {
    std::vector<double> shift_mm;
    std::vector<double> force_n;
    double reactions = 0.0;
    std::int64_t entered = -1;  ///< Step at which the tip came into the skin.
  };

  Seen Insert(const nlohmann::json& pain) {
    nlohmann::json effects = {{"needle_force", {{"model", "layered"}}}};
    if (!pain.is_null()) effects["pain_reaction"] = pain;
    config::WriteJson(folder() / "scene.json", {{"format", "acus-scenario/1"},
                                                {"patient", {{"labels", "labels.seg.nrrd"}}},
                                                {"effects", effects}});
    const auto scenario = scenario::ReadScenario(folder() / "scene.json", {});
    RunContext context;
    const Scene scene = LoadScene(scenario, PlanEffects(scenario, {.needle_poses = true}), context);
    const Simulation simulation(scene);
    State state = simulation.NewState();
    Seen seen;
    for (std::int64_t n = 0; n < 4000; ++n) {
      Sample sample{.time_ns = n * kStepNs, .needle_valid = true};
      // In to 15 mm, and there it stays: the hand does not follow.
      sample.reference_from_needle.linear() << 1, 0, 0, 0, 0, 1, 0, -1, 0;
      sample.reference_from_needle.translation().y() =
          std::min(-5.0 + 0.01 * static_cast<double>(n), 15.0);
      const StepOutput out = simulation.Step(state, sample);
      if (seen.entered < 0 && out.tissue_at_tip == 1) seen.entered = n;
      seen.shift_mm.push_back(out.effect[0]);
      seen.reactions = out.effect[1];
      seen.force_n.push_back(out.force.force_in_ct_n.norm());
    }
    return seen;
  }

  const std::filesystem::path& folder() const { return temporary_.path(); }

  testing_support::TemporaryFolder temporary_;
};

TEST_F(PainScene, ThePatientJerksOnceWhenTheSkinIsEntered) {
  const Seen calm = Insert(nullptr);
  const Seen seen = Insert({{"tissues", {"skin"}},
                            {"latency_s", 0.1},
                            {"rise_s", 0.2},
                            {"return_s", 1.0},
                            {"amplitude_mm", 3.0}});
  ASSERT_GT(seen.entered, 0);
  EXPECT_EQ(seen.reactions, 1.0);
  const auto at = [&](double since_s) {
    return seen.shift_mm[static_cast<std::size_t>(seen.entered) +
                         static_cast<std::size_t>(std::lround(since_s * 1e3))];
  };
  EXPECT_NEAR(at(0.1), 0.0, 1e-12);
  EXPECT_NEAR(at(0.2), 1.5, 1e-9) << "half-way";
  EXPECT_NEAR(at(0.3), 3.0, 1e-9);
  EXPECT_NEAR(at(0.8), 1.5, 1e-9);
  EXPECT_EQ(at(1.31), 0.0);
  // Before it jerks the patient is as any other; while it moves away the needle is less deep.
  for (std::int64_t n = 0; n < seen.entered + 100; ++n) {
    ASSERT_EQ(seen.force_n[static_cast<std::size_t>(n)], calm.force_n[static_cast<std::size_t>(n)]);
  }
  EXPECT_NE(seen.force_n[static_cast<std::size_t>(seen.entered) + 300],
            calm.force_n[static_cast<std::size_t>(seen.entered) + 300]);
}

TEST_F(PainScene, AnaesthesiaTakesThePainAway) {
  const nlohmann::json numb = {
      {"tissues", {"skin"}}, {"anaesthesia_at_mm", {0, 0, 0}}, {"anaesthesia_radius_mm", 5}};
  const Seen seen = Insert(numb);
  EXPECT_EQ(seen.reactions, 0.0);
  EXPECT_EQ(seen.force_n, Insert(nullptr).force_n);
  nlohmann::json beside = numb;
  beside["anaesthesia_at_mm"] = {10, 0, 0};
  EXPECT_EQ(Insert(beside).reactions, 1.0);
}

TEST_F(PainScene, EachTissueThatHurtsIsFeltAfterThePause) {
  const nlohmann::json both = {{"tissues", {"skin", "muscle"}}, {"amplitude_mm", 0.5}};
  EXPECT_EQ(Insert(both).reactions, 1.0) << "the muscle comes within the pause";
  nlohmann::json brief = both;
  brief.update({{"latency_s", 0.0}, {"rise_s", 0.02}, {"return_s", 0.03}, {"pause_s", 0.0}});
  EXPECT_EQ(Insert(brief).reactions, 2.0);
}

TEST_F(PainScene, AnUnknownTissueIsAnErrorThatNamesThePlace) {
  try {
    Insert({{"tissues", {"skim"}}});
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("/effects/pain_reaction/tissues"), std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace acus::simulation
