#include "acus/window/coach.h"

#include <gtest/gtest.h>

namespace acus::window {
namespace {

/// Probe frame = CT frame, all in order: contact, target in view, needle in the plane.
CoachView InOrder() {
  CoachView view;
  view.has_needle = view.has_probe = view.wants_plane = true;
  view.field = {.depth_mm = 100.0, .half_width_mm = 20.0};
  view.now.needle_seen = view.now.probe_seen = view.now.probe_on_skin = true;
  view.now.target_in_view = view.now.needle_in_plane = true;
  view.now.target_in_probe_mm = Eigen::Vector3d(0.0, 50.0, 0.0);
  view.now.tip_in_probe_mm = Eigen::Vector3d(10.0, 20.0, 0.0);
  view.gap_to_skin_mm = 0.0;
  view.probe = {.is_virtual = true, .is_selected = true};
  view.needle = {.is_virtual = true, .is_selected = false};
  return view;
}

TEST(Coach, IsSilentWhereNothingStandsBetween) {
  EXPECT_EQ(CoachLine(InOrder()), "");
  CoachView view = InOrder();
  view.now.needle_in_plane = false;
  view.wants_plane = false;
  EXPECT_EQ(CoachLine(view), "") << "the exercise may have the needle out of the plane";
}

TEST(Coach, SaysTheFirstObstacleInOrder) {
  CoachView view = InOrder();
  view.now.needle_in_plane = false;
  view.now.tip_in_probe_mm = Eigen::Vector3d(10.0, 20.0, 23.0);
  EXPECT_EQ(CoachLine(view),
            "The needle's tip is 23 mm off the image plane: Tab selects the needle, Page Up moves "
            "it there.");
  view.now.target_in_view = false;
  view.now.target_in_probe_mm = Eigen::Vector3d(0.0, 50.0, 14.0);
  EXPECT_EQ(CoachLine(view), "The target is 14 mm off the image plane: Page Down moves it there.");
  view.now.probe_on_skin = false;
  view.gap_to_skin_mm = 30.0;
  EXPECT_EQ(CoachLine(view), "The probe is 30 mm off the skin: Up moves it there.");
  view.now.probe_seen = false;
  EXPECT_EQ(CoachLine(view), "The probe is not seen: turn its marker to the camera.");
  view.switch_is_open = true;
  EXPECT_NE(CoachLine(view).find("space bar"), std::string::npos);
}

TEST(Coach, DistinguishesBesideAndDeeper) {
  CoachView view = InOrder();
  view.now.target_in_view = false;
  view.now.target_in_probe_mm = Eigen::Vector3d(-35.0, 50.0, 1.0);
  EXPECT_EQ(CoachLine(view), "The target is beside the image, to the left: Left moves it there.");
  view.now.target_in_probe_mm = Eigen::Vector3d(3.0, 130.0, 1.0);
  EXPECT_EQ(CoachLine(view), "The target is deeper than the image: D shows more.");
}

TEST(Coach, NamesMovementsForARealHandAndKeysInTheDevicesFrame) {
  CoachView view = InOrder();
  view.now.probe_on_skin = false;
  view.gap_to_skin_mm = 12.0;
  view.probe.is_virtual = false;
  EXPECT_EQ(CoachLine(view), "The probe is 12 mm off the skin: place it on the skin.");
  view.gap_to_skin_mm.reset();
  EXPECT_EQ(CoachLine(view), "The probe does not face the patient: turn it to the skin.");
  SteeredTool tool{.is_virtual = true};
  tool.device_from_ct =
      Eigen::AngleAxisd(0.5 * 3.14159265358979, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  EXPECT_EQ(KeyTowards(tool, Eigen::Vector3d::UnitX()), "Up");
  EXPECT_EQ(KeyTowards(tool, Eigen::Vector3d::UnitY()), "Left");
  EXPECT_EQ(KeyTowards(tool, Eigen::Vector3d::UnitZ()), "Page Down");
}

TEST(Coach, AimsTheNeedleAtTheTargetBeforeItIsInserted) {
  CoachView view = InOrder();
  view.needle = {.is_virtual = true, .is_selected = true, .along_in_ct = Eigen::Vector3d::UnitY()};
  view.tip_to_target_in_ct_mm = Eigen::Vector3d(-6.0, 40.0, 0.0);
  EXPECT_EQ(CoachLine(view), "The needle's line misses the target by 6 mm: Left moves it there.");
  view.needle.is_selected = false;
  EXPECT_EQ(CoachLine(view),
            "The needle's line misses the target by 6 mm: Tab selects the needle, Left moves it "
            "there.");
  view.needle.is_virtual = false;
  EXPECT_EQ(CoachLine(view),
            "The needle's line misses the target by 6 mm: shift or turn the needle.");
  // Across the image plane, the tip is where the plane requires it.
  view.tip_to_target_in_ct_mm = Eigen::Vector3d(1.0, 40.0, 5.0);
  EXPECT_EQ(CoachLine(view), "");
  view.wants_plane = false;
  EXPECT_NE(CoachLine(view), "");
  view.tip_to_target_in_ct_mm.reset();  // An exercise without a target.
  EXPECT_EQ(CoachLine(view), "");
}

TEST(Coach, WithdrawsANeedleThatMissesOrHasPassedTheTarget) {
  CoachView view = InOrder();
  view.needle = {.is_virtual = true, .is_selected = true, .along_in_ct = Eigen::Vector3d::UnitY()};
  view.now.needle_in_tissue = true;
  view.tip_to_target_in_ct_mm = Eigen::Vector3d(4.0, 40.0, 0.0);
  EXPECT_EQ(CoachLine(view), "") << "within one and a half radii";
  view.tip_to_target_in_ct_mm = Eigen::Vector3d(7.0, 40.0, 0.0);
  EXPECT_EQ(CoachLine(view),
            "The needle's line misses the target by 7 mm: Page Up withdraws the needle.");
  view.tip_to_target_in_ct_mm = Eigen::Vector3d(1.0, -8.0, 0.0);
  EXPECT_EQ(CoachLine(view), "The tip is 8 mm beyond the target: Page Up withdraws the needle.");
  view.now.target_reached = true;
  EXPECT_EQ(CoachLine(view), "");
}

TEST(Coach, DrawsAProbeBackThatIsDeepInThePatient) {
  CoachView view = InOrder();
  view.probe_depth_mm = 10.0;  // Tissue that it presses in.
  EXPECT_EQ(CoachLine(view), "");
  view.probe_depth_mm = 24.0;
  EXPECT_EQ(CoachLine(view), "The probe is 24 mm below the skin: Down moves it there.");
}

TEST(HowTo, NamesTheKeyOfEachStepThatNeedsAMovement) {
  using training::StepCondition;
  CoachView view = InOrder();
  view.needle.is_selected = true;
  EXPECT_EQ(HowTo(view), "") << "no step";
  const auto how = [&](StepCondition next) {
    view.next = next;
    return HowTo(view);
  };
  for (const auto seen : {StepCondition::kProbeOnSkin, StepCondition::kTargetInView,
                          StepCondition::kNeedleInPlane, StepCondition::kNeedleSeen}) {
    EXPECT_EQ(how(seen), "");
  }
  for (const auto reached : {StepCondition::kNeedleAtSkin, StepCondition::kNeedleInTissue,
                             StepCondition::kStructuresSpared, StepCondition::kTargetReached,
                             StepCondition::kNeedleJiggled}) {
    EXPECT_EQ(how(reached), "Page Down advances the needle.");
  }
  EXPECT_EQ(how(StepCondition::kNeedleWithdrawn), "Page Up withdraws the needle.");
  EXPECT_EQ(how(StepCondition::kBreathHeld), "B holds the breath.");
  EXPECT_EQ(how(StepCondition::kPlungerPressed), "I presses the plunger.");
  EXPECT_EQ(how(StepCondition::kPlungerPulled),
            "Shift+I pulls the plunger, or removes the stylet.");
  view.breath_held = true;
  EXPECT_EQ(how(StepCondition::kPositionChecked), "");
  view.now.needle_in_tissue = view.now.target_reached = true;
  EXPECT_EQ(how(StepCondition::kTargetReached), "Hold the needle still.");
  EXPECT_EQ(how(StepCondition::kNeedleJiggled), "Page Down and Page Up, in turn, jiggle it.");
  view.needle = {};
  view.now.target_reached = false;
  EXPECT_EQ(how(StepCondition::kTargetReached), "Advance the needle.");
}

}  // namespace
}  // namespace acus::window
