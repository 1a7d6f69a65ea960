#include "acus/physics/forces/probe/surface_proxy.h"

#include <gmock/gmock.h>

#include "acus/physics/forces/laws/window_average.h"

namespace acus::forces {
namespace {

using Eigen::Vector3d;

/// HU falls by 100 per mm from the centre of a ball: 0 at its surface.
struct Ball : HuField {
  double radius_mm = 50.0;
  double HuAt(const Vector3d& p) const noexcept override { return 100.0 * (radius_mm - p.norm()); }
  double ResolutionMm() const noexcept override { return 0.7; }
};

TEST(SurfaceProxy, IsTheNearestPointOfABall) {
  const Ball ball;
  const SurfaceProxySettings settings{0.0, 0.0, 0.0};
  SurfaceProxy proxy;
  proxy.Touch(ball, {}, Vector3d(0, 0, 50));
  Vector3d device(0, 0, 50);
  for (int i = 0; i < 2000; ++i) {
    device = Eigen::AngleAxisd(0.0005 * i, Vector3d::UnitX()) * Vector3d(0, 0, 50 - 0.005 * i);
    proxy.Follow(ball, settings, device);
    ASSERT_TRUE(proxy.touching);
    ASSERT_LT((proxy.at_in_ct_mm - 50.0 * device.normalized()).norm(), 2e-3) << i;
  }
  EXPECT_NEAR(proxy.PenetrationMm(device).norm(), 10.0, 0.01);
  EXPECT_TRUE(proxy.outward_in_ct.isApprox(device.normalized(), 1e-3));
}

TEST(SurfaceProxy, LetsGoOutside) {
  const Ball ball;
  SurfaceProxy proxy;
  proxy.Touch(ball, {}, Vector3d(0, 0, 50));
  proxy.Follow(ball, {0.0, 0.0, 0.0}, Vector3d(0, 0, 49.9));
  EXPECT_TRUE(proxy.touching);
  proxy.Follow(ball, {0.0, 0.0, 0.0}, Vector3d(0, 0, 50.1));
  EXPECT_FALSE(proxy.touching);
  EXPECT_EQ(proxy.PenetrationMm(Vector3d(0, 0, 40)).norm(), 0.0);
}

TEST(SurfaceProxy, FrictionHoldsItWithinTheCone) {
  Ball flat;
  flat.radius_mm = 1e6;
  const SurfaceProxySettings settings{0.0, 0.3, 0.0};
  SurfaceProxy proxy;
  const Vector3d top(0, 0, 1e6);
  proxy.Touch(flat, {}, top);
  proxy.Follow(flat, settings, top + Vector3d(0.5, 0, -2.0));  // Within 0.6.
  EXPECT_NEAR((proxy.at_in_ct_mm - top).norm(), 0.0, 1e-6);
  proxy.Follow(flat, settings, top + Vector3d(1.0, 0, -2.0));
  EXPECT_NEAR(proxy.at_in_ct_mm.x(), 0.4, 1e-3);  // Dragged along at mu times the depth.
}

// A frictionless proxy is a potential: no path gives work.
TEST(SurfaceProxy, NoLoopGivesWork) {
  const Ball ball;
  const SurfaceProxySettings settings{0.0, 0.0, 0.0};
  SurfaceProxy proxy;
  proxy.Touch(ball, {}, Vector3d(0, 0, 50));
  double work = 0.0;
  Vector3d device(0, 0, 50);
  Vector3d force = Vector3d::Zero();
  for (int i = 0; i <= 20000; ++i) {
    const double t = 2.0 * 3.14159265358979 * i / 20000.0;
    const Vector3d next = Eigen::AngleAxisd(0.3 * std::sin(t), Vector3d::UnitX()) *
                          Vector3d(0, 0, 47.0 - 3.0 * std::cos(2 * t));
    proxy.Follow(ball, settings, next);
    const Vector3d new_force = proxy.PenetrationMm(next);
    if (i > 0) work -= 0.5 * (force + new_force).dot(next - device);
    device = next;
    force = new_force;
  }
  EXPECT_NEAR(work, 0.0, 0.02);  // Of 18 N mm stored at the deepest.
}

TEST(WindowAverage, IsTheMeanOverTheWindowAtAnyRate) {
  const double window_s = 0.010;
  for (const double rate_hz : {500.0, 1000.0, 4000.0, 20000.0}) {
    WindowAverage average;
    const double dt_s = 1.0 / rate_hz;
    Vector3d mean = Vector3d::Zero();
    double t = 0.0;
    for (int i = 0; i < 4000; ++i) {
      t += dt_s;
      mean = average.Add(Vector3d(2.0, t - 0.5 * dt_s, 0.0), dt_s, window_s);
    }
    EXPECT_NEAR(mean.x(), 2.0, 1e-12) << rate_hz;
    EXPECT_NEAR(mean.y(), t - 0.5 * window_s, 0.1 * window_s)
        << rate_hz;  // A ramp comes half late.
  }
}

TEST(WindowAverage, FillsFromZeroAndForgets) {
  WindowAverage average;
  EXPECT_NEAR(average.Add(Vector3d(1, 0, 0), 0.001, 0.010).x(), 0.1, 1e-12);
  for (int i = 0; i < 20; ++i) average.Add(Vector3d(1, 0, 0), 0.001, 0.010);
  Vector3d mean = Vector3d::Zero();
  for (int i = 0; i < 11; ++i) mean = average.Add(Vector3d::Zero(), 0.001, 0.010);
  EXPECT_NEAR(mean.x(), 0.0, 1e-12);
  EXPECT_EQ(average.Add(Vector3d(3, 0, 0), 0.001, 0.0).x(), 3.0);  // No window, no mean.
  EXPECT_EQ(average.Add(Vector3d(4, 0, 0), 0.5, 0.010).x(), 4.0);  // A gap longer than it.
}

}  // namespace
}  // namespace acus::forces
