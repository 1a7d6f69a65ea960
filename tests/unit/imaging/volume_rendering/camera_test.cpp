#include "acus/imaging/volume_rendering/camera.h"

#include <gmock/gmock.h>

#include "acus/base/core/error.h"

namespace acus::volume_rendering {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

TEST(Camera, LooksAtTheFocusWithUpUpAndRightRight) {
  const Camera camera =
      LookAt({.eye_in_ct_mm = {0, -500, 0}, .focus_in_ct_mm = {0, 0, 0}, .view_angle_deg = 30.0},
             {201, 101});
  EXPECT_TRUE(camera.ProjectPx({0, 0, 0}).isApprox(Eigen::Vector2d(100, 50)));
  // From in front: the patient's left (+x) is on the right, his head up, that is at smaller rows.
  EXPECT_GT(camera.ProjectPx({10, 0, 0})[0], 100.5);
  EXPECT_LT(camera.ProjectPx({0, 0, 10})[1], 49.5);
  // 15 degrees up from the middle is the upper border.
  const double half_height_mm = 500.0 * std::tan(15.0 * M_PI / 180.0);
  EXPECT_NEAR(camera.ProjectPx({0, 0, half_height_mm})[1], -0.5, 1e-9);
  EXPECT_TRUE(camera.EyeInCtMm().isApprox(Eigen::Vector3d(0, -500, 0)));
}

TEST(Camera, DirectionsGoThroughTheirPixels) {
  const Camera camera = LookAt({.eye_in_ct_mm = {300, -400, 200},
                                .focus_in_ct_mm = {10, 20, -5},
                                .up_in_ct = {0.1, 0.2, 1.0},
                                .view_angle_deg = 45.0},
                               {320, 240});
  for (const Eigen::Vector2d& pixel : {Eigen::Vector2d(0, 0), Eigen::Vector2d(319, 17)}) {
    const Eigen::Vector3d point = camera.EyeInCtMm() + 321.0 * camera.DirectionInCt(pixel);
    EXPECT_LT((camera.ProjectPx(point) - pixel).norm(), 1e-9);
  }
}

TEST(Camera, MagnifiedPixelsShareThePlaceOfTheirPixel) {
  const Camera camera =
      LookAt({.eye_in_ct_mm = {0, -500, 0}, .focus_in_ct_mm = {0, 0, 0}}, {64, 48});
  const Camera fine = camera.Magnified(2);
  const Eigen::Vector3d point(12, 3, -30);
  const Eigen::Vector2d coarse_px = camera.ProjectPx(point);
  EXPECT_TRUE(fine.ProjectPx(point).isApprox(2.0 * coarse_px + Eigen::Vector2d(0.5, 0.5)));
}

TEST(Camera, AViewFromASideHoldsTheWholeBox) {
  const Eigen::AlignedBox3d box(Eigen::Vector3d(-150, -80, 10), Eigen::Vector3d(170, 120, 300));
  for (const char* side :
       {"anterior", "posterior", "left", "right", "superior", "inferior", "oblique"}) {
    for (const ImageSize size : {ImageSize{512, 512}, ImageSize{300, 600}}) {
      const Camera camera = LookAt(ViewFrom(side, box, size), size);
      for (int n = 0; n < 8; ++n) {
        const Eigen::Vector2d px =
            camera.ProjectPx(box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(n)));
        EXPECT_TRUE((px.array() > 0.0).all() && px[0] < size.width_px && px[1] < size.height_px)
            << side << ": " << px.transpose();
      }
    }
  }
}

TEST(Camera, SidesLookStraightAlongAnAxisAndOppositeSidesFaceEachOther) {
  const Eigen::AlignedBox3d box(Eigen::Vector3d(-10, -20, -30), Eigen::Vector3d(30, 40, 50));
  const auto from = [&](const char* side) {
    const Viewpoint view = ViewFrom(side, box, {64, 64});
    EXPECT_TRUE(view.focus_in_ct_mm.isApprox(box.center())) << side;
    return (view.eye_in_ct_mm - view.focus_in_ct_mm).normalized().eval();
  };
  EXPECT_TRUE(from("anterior").isApprox(-Eigen::Vector3d::UnitY()));
  EXPECT_TRUE(from("posterior").isApprox(Eigen::Vector3d::UnitY()));
  EXPECT_TRUE(from("left").isApprox(Eigen::Vector3d::UnitX()));
  EXPECT_TRUE(from("right").isApprox(-Eigen::Vector3d::UnitX()));
  EXPECT_TRUE(from("superior").isApprox(Eigen::Vector3d::UnitZ()));
  EXPECT_TRUE(from("inferior").isApprox(-Eigen::Vector3d::UnitZ()));
}

TEST(Camera, RefusesWhatIsNoView) {
  const Viewpoint good{.eye_in_ct_mm = {0, -500, 0}, .focus_in_ct_mm = {0, 0, 0}};
  const ImageSize size{64, 64};
  const auto with = [&](auto change) {
    return [&good, &size, change] {
      Viewpoint v = good;
      change(v);
      LookAt(v, size);
    };
  };
  EXPECT_THAT(with([](Viewpoint& v) { v.eye_in_ct_mm = v.focus_in_ct_mm; }),
              ThrowsMessage<InputError>(HasSubstr("same place")));
  EXPECT_THAT(with([](Viewpoint& v) {
                v.up_in_ct = {0, 1, 0};
              }),
              ThrowsMessage<InputError>(HasSubstr("`up`")));
  for (const double angle : {0.0, 150.0, std::nan("")}) {
    EXPECT_THAT(with([&](Viewpoint& v) { v.view_angle_deg = angle; }),
                ThrowsMessage<InputError>(HasSubstr("view angle")));
  }
  EXPECT_THAT([&] { LookAt(good, {0, 64}); }, ThrowsMessage<InputError>(HasSubstr("0 x 64")));
  EXPECT_THAT([&] { LookAt(good, {64, 8193}); }, ThrowsMessage<InputError>(HasSubstr("8193")));
  const Eigen::AlignedBox3d box(Eigen::Vector3d::Zero(), Eigen::Vector3d::Ones());
  EXPECT_THAT([&] { ViewFrom("above", box, size); },
              ThrowsMessage<InputError>(HasSubstr("anterior, posterior")));
  EXPECT_THAT([&] { ViewFrom("left", {}, size); }, ThrowsMessage<InputError>(HasSubstr("nothing")));
}

TEST(Camera, EveryNumberIsChecked) {
  const Camera good = LookAt({.eye_in_ct_mm = {0, -500, 0}, .focus_in_ct_mm = {0, 0, 0}}, {64, 64});
  EXPECT_NO_THROW(good.Check());
  const auto refuses = [&](auto change) {
    Camera camera = good;
    change(camera);
    EXPECT_THAT([&] { camera.Check(); }, ThrowsMessage<InputError>(HasSubstr("all numbers")));
  };
  for (const int axis : {0, 1}) {
    for (const double focal_px : {0.0, -50.0, std::nan("")}) {
      refuses([&](Camera& camera) { camera.focal_px[axis] = focal_px; });
    }
    refuses([&](Camera& camera) { camera.centre_px[axis] = std::nan(""); });
  }
  refuses([](Camera& camera) { camera.camera_from_ct.translation()[2] = std::nan(""); });
}

}  // namespace
}  // namespace acus::volume_rendering
