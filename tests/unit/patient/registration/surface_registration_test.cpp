#include "acus/patient/registration/surface_registration.h"

#include <gmock/gmock.h>

#include "acus/base/core/error.h"
#include "acus/base/core/random.h"
#include "support/bumpy_surface.h"
#include "support/marker_layouts.h"

namespace acus::registration {
namespace {

using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Vector3d;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using testing::ThrowsMessage;
using testing_support::KnownPose;

/// Points swept over the front and both flanks (y > -40), seen in the mannequin's frame.
transforms::Markers Swept(int count, double sd_mm, std::uint64_t index = 0) {
  RandomStream random(6, "sweep", index);
  transforms::Markers points_mm(3, count);
  for (Eigen::Index i = 0; i < count;) {
    const Vector3d at_mm =
        testing_support::TrunkPlace(random.Uniform(-0.9, 0.9), random.Uniform(0, 6.2832));
    if (at_mm.y() < -40) continue;
    points_mm.col(i++) =
        at_mm + sd_mm * Vector3d(random.Normal(), random.Normal(), random.Normal());
  }
  return KnownPose().inverse() * points_mm;
}

Isometry3d Near(const Isometry3d& pose, const Vector3d& shift_mm, double angle_rad) {
  return Eigen::Translation3d(shift_mm) * pose *
         AngleAxisd(angle_rad, Vector3d(1, -1, 2).normalized());
}

double WorstMm(const Isometry3d& a, const Isometry3d& b, const transforms::Markers& points_mm) {
  return (a * points_mm - b * points_mm).colwise().norm().maxCoeff();
}

TEST(RegisterToSurface, FindsThePoseFromARoughStart) {
  const transforms::Markers points_mm = Swept(600, 0.0);
  const auto fit = RegisterToSurface(points_mm, testing_support::Trunk(150, 220),
                                     Near(KnownPose(), {20, -15, 18}, 0.2), {}, RunContext{});
  // The mesh's chords lie up to 0.2 mm inside the true surface.
  EXPECT_LT(WorstMm(fit.ct_from_reference, KnownPose(), points_mm), 0.15);
  EXPECT_LT(fit.rms_mm, 0.1);
}

TEST(RegisterToSurface, ErrsAsMuchAsItSays) {
  const mesh::Surface trunk = testing_support::Trunk(150, 220);
  SurfaceSettings settings;
  settings.keep = 1.0;
  settings.num_starts = 1;
  double error2 = 0.0, said2 = 0.0;
  for (std::uint64_t seed = 0; seed < 25; ++seed) {
    const transforms::Markers points_mm = Swept(200, 0.8, seed);
    const auto fit = RegisterToSurface(points_mm, trunk, Near(KnownPose(), {4, 3, -4}, 0.03),
                                       settings, RunContext{});
    const Vector3d target_mm(10, 30, 50);
    const Vector3d source_mm = KnownPose().inverse() * target_mm;
    error2 += (fit.ct_from_reference * source_mm - target_mm).squaredNorm();
    said2 += std::pow(fit.error.At(target_mm).rms_mm, 2);
  }
  EXPECT_NEAR(std::sqrt(error2 / said2), 1.0, 0.35);
}

TEST(RegisterToSurface, TrimsPointsThatAreNotOnTheSkin) {
  transforms::Markers points_mm = Swept(400, 0.3);
  for (Eigen::Index i = 0; i < 400; i += 8) points_mm.col(i) += Vector3d(25, 10, -30);  // Lifted.
  SurfaceSettings settings;
  settings.keep = 0.8;
  const auto fit = RegisterToSurface(points_mm, testing_support::Trunk(150, 220),
                                     Near(KnownPose(), {10, -10, 8}, 0.1), settings, RunContext{});
  EXPECT_LT(WorstMm(fit.ct_from_reference, KnownPose(), Swept(400, 0.0)), 0.8);
}

TEST(RegisterToSurface, FindsThePoseWithoutAStart) {
  SurfaceSettings settings;
  settings.num_starts = 200;
  const transforms::Markers points_mm = Swept(500, 0.2);
  const auto fit =
      RegisterToSurface(points_mm, testing_support::Trunk(), std::nullopt, settings, RunContext{});
  EXPECT_LT(WorstMm(fit.ct_from_reference, KnownPose(), points_mm), 1.0);
}

TEST(RegisterToSurface, SaysWhatIsFreeOnACylinderABallAndAPlane) {
  transforms::Markers on_cylinder_mm(3, 400), on_ball_mm(3, 400), on_plane_mm(3, 400);
  RandomStream random(3, "free");
  for (Eigen::Index i = 0; i < 400; ++i) {
    const double a = random.Uniform(0, 3), z = random.Uniform(-80, 80);
    const Vector3d noise_mm = 0.1 * Vector3d(random.Normal(), random.Normal(), random.Normal());
    on_cylinder_mm.col(i) = Vector3d(100 * std::cos(a), 100 * std::sin(a), z) + noise_mm;
    on_ball_mm.col(i) = Vector3d(100 * std::cos(a) * std::cos(z / 100),
                                 100 * std::sin(a) * std::cos(z / 100), 100 * std::sin(z / 100)) +
                        noise_mm;
    on_plane_mm.col(i) = Vector3d(random.Uniform(-50, 50), random.Uniform(-50, 50), 0) + noise_mm;
  }
  const Isometry3d start(Eigen::Translation3d(1, 2, 1));
  const auto tried = [&](const transforms::Markers& points_mm, const mesh::Surface& surface) {
    return [&points_mm, surface, start] {
      RegisterToSurface(points_mm, surface, start, {}, RunContext{});
    };
  };
  EXPECT_THAT(tried(on_cylinder_mm, testing_support::Cylinder(100, 400)),
              ThrowsMessage<NoAnswerError>(
                  AllOf(HasSubstr("sliding along"), HasSubstr("do not determine the pose"))));
  EXPECT_THAT(tried(on_ball_mm, testing_support::Ball(100)),
              ThrowsMessage<NoAnswerError>(HasSubstr(";")));  // Three turns.
  mesh::Surface plane;
  plane.nodes_mm.resize(3, 4);
  plane.nodes_mm << -500, 500, 500, -500, -500, -500, 500, 500, 0, 0, 0, 0;
  plane.triangles.resize(3, 2);
  plane.triangles << 0, 0, 1, 2, 2, 3;
  EXPECT_THAT(tried(on_plane_mm, plane), ThrowsMessage<NoAnswerError>(HasSubstr("sliding along")));
}

TEST(RegisterToSurface, DoesNotDependOnThreads) {
  const transforms::Markers points_mm = Swept(200, 0.5);
  RunContext one, three;
  three.num_threads = 3;
  const auto start = Near(KnownPose(), {10, -10, 8}, 0.1);
  const auto a = RegisterToSurface(points_mm, testing_support::Trunk(), start, {}, one);
  const auto b = RegisterToSurface(points_mm, testing_support::Trunk(), start, {}, three);
  EXPECT_EQ(a.ct_from_reference.matrix(), b.ct_from_reference.matrix());
}

TEST(RegisterToSurface, RefusesSettingsThatMakeNoSense) {
  const transforms::Markers points_mm = Swept(50, 0.0);
  const auto with = [&](auto change) {
    SurfaceSettings settings;
    change(settings);
    return [&points_mm, settings] {
      RegisterToSurface(points_mm, testing_support::Trunk(20, 30), KnownPose(), settings,
                        RunContext{});
    };
  };
  using S = SurfaceSettings;
  EXPECT_THROW(with([](S& s) { s.keep = 0.0; })(), InputError);
  EXPECT_THROW(with([](S& s) { s.keep = 1.1; })(), InputError);
  EXPECT_THROW(with([](S& s) { s.num_starts = 0; })(), InputError);
  EXPECT_THROW(with([](S& s) { s.start_mm = -1; })(), InputError);
  EXPECT_THROW(with([](S& s) { s.least_hold = 0; })(), InputError);
  EXPECT_THROW(RegisterToSurface(points_mm.leftCols(11), testing_support::Trunk(20, 30),
                                 KnownPose(), {}, RunContext{}),
               InputError);
}

}  // namespace
}  // namespace acus::registration
