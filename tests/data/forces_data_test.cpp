// The models that read the CT itself, on a real one with its noise and its bones.
#include <cstdio>
#include <gmock/gmock.h>

#include "acus/base/core/run_context.h"
#include "acus/data/volume/volume_io.h"
#include "support/force_scenes.h"
#include "support/shared_data.h"

namespace acus::forces {
namespace {

using Eigen::Vector3d;
using testing_support::DrivenProbe;
using testing_support::LayeredBodyField;
using testing_support::SharedData;
using testing_support::ShippedTable;
using testing_support::Trocar18G;

constexpr double kSkinHu = -300.0;

/// Abdomen, 0.57 x 0.57 x 1.6 mm. From the front, +y is into the body.
class RealCt : public testing::Test {
 protected:
  void SetUp() override {
    const auto folder = SharedData("ct/ircadb01_dicom");
    if (!folder) GTEST_SKIP() << "test data ct/ircadb01_dicom is not here";
    ct = volume::ReadCt(*folder, "", RunContext());
    field.emplace(ct);
    const Vector3d centre =
        ct.geometry.ct_from_index() * (0.5 * ct.geometry.size.cast<double>()).matrix();
    const Vector3d front =
        centre - Vector3d(0, 0.5 * ct.geometry.size[1] * ct.geometry.spacing_mm[1], 0);
    const double share = field->FirstCrossing(front, centre, kSkinHu);
    ASSERT_LT(share, 1.0);
    skin_mm = front + share * (centre - front);
  }
  volume::CtVolume ct;
  std::optional<CtField> field;
  Vector3d skin_mm = Vector3d::Zero();
};

TEST_F(RealCt, ANeedleGoesInThroughTheSkinAndOutAgain) {
  const VidalModel model(ShippedTable("vidal.json"), Trocar18G(), *field);
  VidalState state;
  double t = 0.0;
  int punctures = 0;
  int interfaces = 0;
  int withdrawals = 0;
  double largest_step_n = 0.0;
  double before_n = 0.0;
  bool inside = false;
  const auto go = [&](double from_mm, double to_mm) {
    const double step_mm = from_mm < to_mm ? 0.01 : -0.01;
    for (double d = from_mm; step_mm * (to_mm - d) > 0.0; d += step_mm) {
      const NeedleForce out =
          model.Step(state, {t += 0.001, skin_mm + Vector3d(0, d, 0), Vector3d::UnitY()});
      ASSERT_TRUE(out.force_in_ct_n.allFinite());
      punctures += out.event == NeedleEvent::kPuncture;
      interfaces += out.event == NeedleEvent::kInterface;
      withdrawals += out.event == NeedleEvent::kWithdrawal;
      if (inside && state.pierced)
        largest_step_n = std::max(largest_step_n, std::abs(out.AxialN() - before_n));
      before_n = out.AxialN();
      inside = state.pierced;
    }
  };
  go(-5.0, 60.0);
  EXPECT_EQ(punctures, 1);
  EXPECT_GT(interfaces, 0);
  EXPECT_GT(state.depth_mm, 20.0);
  go(60.0, -5.0);
  EXPECT_EQ(withdrawals, 1);
  EXPECT_LT(largest_step_n, 0.1);  // 1 N/mm times 0.01 mm, bone 2 N/mm and its damping.
}

// Pressed in by 8 mm and slid over the abdomen: a CT's noise must not be felt as gravel.
TEST_F(RealCt, AProbeSlidesOverTheSkinWithoutGravel) {
  const VidalProbe model(ShippedTable("vidal.json"), *field);
  DrivenProbe probe{model};
  double t = 0.0;
  const Vector3d above = skin_mm - Vector3d(0, 5, 0);
  for (int i = 0; i <= 650; ++i) probe.Step(t += 0.001, above + Vector3d(0, 0.02 * i, 0));
  double largest_step_n = 0.0;
  double rough = 0.0;
  Vector3d before_n = probe.last.force_in_ct_n;
  EXPECT_NEAR(before_n.norm(), 0.4 * 8.0, 0.3);
  for (int i = 0; i <= 1000; ++i) {  // 20 mm at 20 mm/s.
    probe.Step(t += 0.001, above + Vector3d(0.02 * i, 13.0, 0));
    ASSERT_TRUE(probe.last.on_skin);
    const double step_n = (probe.last.force_in_ct_n - before_n).norm();
    if (i > 0) {
      largest_step_n = std::max(largest_step_n, step_n);
      rough += step_n * step_n;
    }
    before_n = probe.last.force_in_ct_n;
  }
  std::printf("  change of the force per sample: largest %.4f N, RMS %.4f N\n", largest_step_n,
              std::sqrt(rough / 1000.0));
  EXPECT_LT(largest_step_n, 0.1);
}

TEST_F(RealCt, NeitherNeedleNorProbeDriveTheHand) {
  RandomHand motion;
  motion.origin_in_ct_mm = skin_mm;
  motion.axis_in_ct = Vector3d::UnitY();
  motion.across_mm = 8.0;
  for (std::uint64_t seed = 1; seed <= 2; ++seed) {
    Hand hand;
    motion.to_mm = 20.0;
    hand.wants_in_ct_mm = RandomMotion(motion, 60.0, seed);
    const VidalProbe probe_model(ShippedTable("vidal.json"), *field);
    DrivenProbe probe{probe_model};
    const LoopResult probing = RunClosedLoop({}, hand, probe.Loop(), 60.0);
    motion.to_mm = 50.0;
    hand.wants_in_ct_mm = RandomMotion(motion, 60.0, seed);
    const VidalModel needle_model(ShippedTable("vidal.json"), Trocar18G(), *field);
    VidalState state;
    const LoopResult needling = RunClosedLoop(
        {}, hand,
        [&](double time_s, const Vector3d& tip_mm) {
          return needle_model.Step(state, {time_s, tip_mm, Vector3d::UnitY()}).force_in_ct_n;
        },
        60.0);
    std::printf("  probe: generated %.4f mJ, took %.0f mJ; needle: %.4f mJ, %.0f mJ\n",
                probing.generated_mj, probing.taken_mj, needling.generated_mj, needling.taken_mj);
    EXPECT_LE(probing.generated_mj, 1.0);
    EXPECT_LE(needling.generated_mj, 1.0);
  }
}

}  // namespace
}  // namespace acus::forces
