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

}  // namespace
}  // namespace acus::window
