#include "acus/assess/trials/trainee_session.h"

#include <cmath>
#include <gmock/gmock.h>

#include "acus/assess/trials/hand_noise.h"
#include "acus/assess/trials/what_if.h"
#include "support/trial_folder.h"

namespace acus::trials {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

/// Makes no error of any kind.
TraineeSkill Perfect() {
  TraineeSkill skill;
  skill.spread = skill.learning = skill.delay_s = 0.0;
  skill.tremor_mm = skill.tremor_deg = skill.drift_mm = 0.0;
  skill.plane_mm = skill.plane_deg = skill.entry_mm = skill.aim_deg = skill.bias_mm = 0.0;
  skill.target_mm = skill.depth_mm = skill.speed_spread = skill.correction_deg = 0.0;
  skill.search_s = skill.aim_s = 1.0;
  skill.speed_mm_per_s = 30.0;
  return skill;
}

class TraineeTest : public testing_support::TrialFolder {
 protected:
  TrialScene Scene() { return Loaded(Insertion()); }
  static TraineeSkill Preset(const std::string& name) {
    return ReadTraineeSkill(std::filesystem::path(ACUS_SOURCE_DIR) / "configs/trainees" /
                            (name + ".json"));
  }
};

TEST(BandNoise, HasItsSizeAndItsFrequencies) {
  RandomStream random(1, "noise");
  const BandNoise noise(0.3, 8.0, 12.0, random);
  constexpr int kSamples = 200'000;
  double squares = 0.0;
  int crossings = 0;
  for (int i = 0; i < kSamples; ++i) {
    const double now = noise.At(1e-3 * i).x();
    squares += now * now;
    if (i > 0 && now * noise.At(1e-3 * (i - 1)).x() < 0.0) ++crossings;
  }
  EXPECT_NEAR(std::sqrt(squares / kSamples), 0.3, 0.01);
  const double hz = 0.5 * crossings / (1e-3 * kSamples);
  EXPECT_GT(hz, 8.0);
  EXPECT_LT(hz, 12.0);
}

TEST_F(TraineeTest, WithoutErrorsTheTargetIsHitInOnePass) {
  const TrialScene scene = Scene();
  const auto made = SimulateTrial(scene, PlannedPathOf(scene), Perfect(), "P", 1, 0, 1000.0);
  EXPECT_EQ(made.num_corrections, 0);
  const auto result = RunTrial(scene, made.session, context_);
  EXPECT_LT(*ValueOf(result.assessment, "tip to target at the end"), 0.2);
  EXPECT_EQ(*ValueOf(result.assessment, "passes"), 1.0);
  EXPECT_EQ(*ValueOf(result.assessment, "attempts"), 1.0);
  EXPECT_GT(*ValueOf(result.assessment, "needle in the image plane"), 99.9);
}

TEST_F(TraineeTest, TheNeedleIsAsFastAsTheTraineeWishes) {
  const TrialScene scene = Scene();
  TraineeSkill skill = Perfect();
  skill.speed_mm_per_s = 15.0;
  skill.aim_s = 10.0;  // Slower than the insertion.
  const auto made = SimulateTrial(scene, PlannedPathOf(scene), skill, "P", 1, 0, 200.0);
  double fastest_mm_per_s = 0.0;
  for (std::size_t i = 1; i < made.session.needle.size(); ++i) {
    const auto& now = made.session.needle[i];
    const auto& before = made.session.needle[i - 1];
    const double mm =
        (now.reference_from_tool.translation() - before.reference_from_tool.translation()).norm();
    fastest_mm_per_s =
        std::max(fastest_mm_per_s, mm / (1e-9 * static_cast<double>(now.time_ns - before.time_ns)));
  }
  EXPECT_NEAR(fastest_mm_per_s, skill.speed_mm_per_s, 0.1);
}

/// Bone 2 mm below the skin: the needle is drawn back from there, not pushed on to the depth at
/// which a withdrawal ends.
TEST_F(TraineeTest, WithdrawalFromShallowBoneDoesNotGoIn) {
  auto labels = volume::ReadLabelMap(folder_ / "labels.seg.nrrd");
  auto ct = volume::ReadCt(folder_ / "ct.nrrd", "", context_);
  for (int k = 12; k < labels.geometry.size[2]; ++k) {
    for (int j = 0; j < labels.geometry.size[1]; ++j) {
      for (int i = 0; i < labels.geometry.size[0]; ++i) {
        labels.At(i, j, k) = volume::LabelOf("bone");
        ct.At(i, j, k) = 900;
      }
    }
  }
  volume::WriteLabelMap(folder_ / "labels.seg.nrrd", labels);
  volume::WriteCt(folder_ / "ct.nrrd", ct);
  const TrialScene scene = Scene();
  TraineeSkill skill = Perfect();
  skill.speed_mm_per_s = 5.0;
  const PlannedPath path = PlannedPathOf(scene);
  const auto made = SimulateTrial(scene, path, skill, "P", 1, 0, 500.0);
  EXPECT_GT(made.num_bone_contacts, 0);
  double deepest_mm = -100.0, longest_mm = 0.0;
  for (std::size_t i = 1; i < made.session.needle.size(); ++i) {
    const Eigen::Vector3d now = made.session.needle[i].reference_from_tool.translation();
    const Eigen::Vector3d before = made.session.needle[i - 1].reference_from_tool.translation();
    deepest_mm = std::max(deepest_mm, now.z());
    if (now.z() > 0.0) longest_mm = std::max(longest_mm, (now - before).norm());
  }
  // A withdrawal is 1.5 times as fast as an insertion; in 2 ms.
  EXPECT_LE(longest_mm, 1.5 * skill.speed_mm_per_s * 0.002 + 1e-9);
  EXPECT_LT(deepest_mm, 4.0);
}

TEST_F(TraineeTest, ABiasMovesTheEndByItsLength) {
  const TrialScene scene = Scene();
  TraineeSkill skill = Perfect();
  skill.bias_mm = 4.0;
  const auto made = SimulateTrial(scene, PlannedPathOf(scene), skill, "P", 1, 0, 1000.0);
  const auto result = RunTrial(scene, made.session, context_);
  EXPECT_NEAR(*ValueOf(result.assessment, "tip to target at the end"), 4.0, 0.2);
}

TEST_F(TraineeTest, AWrongDirectionIsCorrected) {
  const TrialScene scene = Scene();
  TraineeSkill skill = Perfect();
  skill.aim_deg = 20.0;
  skill.correction_gain = 1.0;
  int corrected = 0;
  for (int trial = 1; trial <= 5; ++trial) {
    const auto made = SimulateTrial(scene, PlannedPathOf(scene), skill, "P", trial, 0, 1000.0);
    if (made.num_corrections == 0) continue;
    ++corrected;
    const auto result = RunTrial(scene, made.session, context_);
    EXPECT_LT(*ValueOf(result.assessment, "tip to target at the end"), 1.0) << trial;
  }
  EXPECT_GE(corrected, 3);
}

TEST_F(TraineeTest, TheSameSeedGivesTheSameBitsAndAnotherTrialOthers) {
  const TrialScene scene = Scene();
  const PlannedPath path = PlannedPathOf(scene);
  const auto hash = [&](int trial, std::uint64_t seed) {
    const auto made = SimulateTrial(scene, path, Preset("novice"), "N", trial, seed, 500.0);
    return RunTrial(scene, made.session, context_).force_hash;
  };
  EXPECT_EQ(hash(1, 7), hash(1, 7));
  EXPECT_NE(hash(1, 7), hash(2, 7));
  EXPECT_NE(hash(1, 7), hash(1, 8));
}

TEST_F(TraineeTest, StopsAfterThreeMinutesAtTheLatest) {
  const TrialScene scene = Scene();
  TraineeSkill skill = Perfect();
  skill.speed_mm_per_s = 0.1;
  const auto made = SimulateTrial(scene, PlannedPathOf(scene), skill, "P", 1, 0, 50.0);
  EXPECT_NEAR(1e-9 * static_cast<double>(made.session.needle.back().time_ns), 180.0, 0.1);
}

TEST(PersonOf, PracticeFollowsThePowerLaw) {
  TraineeSkill skill = Perfect();
  skill.learning = 0.5;
  skill.search_s = 8.0;
  EXPECT_NEAR(PersonOf(skill, 0, "P", 4).search_s, 4.0, 1e-12);
  skill.spread = 0.3;
  EXPECT_EQ(PersonOf(skill, 0, "P", 1).search_s / PersonOf(skill, 0, "P", 4).search_s, 2.0)
      << "the same person";
  EXPECT_NE(PersonOf(skill, 0, "P", 1).search_s, PersonOf(skill, 0, "Q", 1).search_s);
}

TEST_F(TraineeTest, ASceneWithoutCorridorIsRefused) {
  const TrialScene scene =
      trials::LoadTrialScene(scenario::ReadScenario(folder_ / "scene.json", {}),
                             folder_ / "exercise.json", Insertion(), context_);
  EXPECT_THAT([&] { PlannedPathOf(scene); },
              ThrowsMessage<InputError>(HasSubstr("/patient/corridor: is missing")));
}

}  // namespace
}  // namespace acus::trials
