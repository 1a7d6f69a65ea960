#include "acus/imaging/ultrasound/columns/bmode.h"

#include <algorithm>
#include <gtest/gtest.h>
#include <limits>

#include "acus/base/core/error.h"
#include "acus/base/core/random.h"
#include "acus/imaging/ultrasound/beams/beam_renderer.h"
#include "support/allocation_counter.h"
#include "support/synthetic_ct.h"

namespace acus::ultrasound {
namespace {

acoustics::Probe SmallProbe(acoustics::ProbeKind kind) {
  return {.name = "test",
          .kind = kind,
          .frequency_mhz = 5,
          .scan_lines = 100,
          .width_mm = 40,
          .radius_mm = 40,
          .field_of_view_rad = 0.9,
          .depth_mm = 40,
          .image_width_px = 300,
          .image_height_px = 200,
          .slice_thickness_mm = 3,
          .pulse_length_mm = 0.8,
          .beam_width_mm = 1.2,
          .dynamic_range_db = 60,
          .gain_db = 20};
}

volume::CtVolume NoisyBody() {
  RandomStream random(9, "body");
  return testing_support::SyntheticCt({60, 60, 40}, 1.0, [&](double x, double y, double) {
    const double noise = 12.0 * random.Normal();
    return y < 4 ? -1000.0 : std::hypot(x - 30, y - 30) < 5 ? 700.0 : 40.0 + noise;
  });
}

Eigen::Isometry3d OnTheSkin() {
  return Eigen::Isometry3d(Eigen::Translation3d(30, 3.6, 20));
}

image::NeedleInImage SomeNeedle() {
  image::NeedleInImage needle;
  needle.tip_in_ct_mm << 25, 20, 20;
  needle.axis_in_ct = Eigen::Vector3d(1, 1, 0).normalized();
  needle.length_mm = 60;
  needle.radius_mm = 0.5;
  return needle;
}

TEST(BMode, GivesTheSameBitsWithAnyNumberOfThreads) {
  const volume::CtVolume ct = NoisyBody();
  BModeOptions options = DefaultBModeOptions();
  for (const bool all_stages : {false, true}) {
    options.texture = options.attenuation = all_stages;
    options.angle_exponent = all_stages ? 2 : 0;
    for (const acoustics::ProbeKind kind :
         {acoustics::ProbeKind::kLinear, acoustics::ProbeKind::kCurvilinear}) {
      BModeRenderer renderer(ct, SmallProbe(kind), options);
      image::GrayImage one;
      renderer.Render(OnTheSkin(), SomeNeedle(), one, 1);
      EXPECT_GT(*std::max_element(one.pixels.begin(), one.pixels.end()), 200);
      for (const int threads : {2, 4}) {
        image::GrayImage many;
        renderer.Render(OnTheSkin(), SomeNeedle(), many, threads);
        EXPECT_EQ(one.pixels, many.pixels) << threads << " threads";
      }
    }
  }
}

TEST(BMode, DependsOnNothingRenderedBefore) {
  const volume::CtVolume ct = NoisyBody();
  BModeRenderer fresh(ct, SmallProbe(acoustics::ProbeKind::kLinear), DefaultBModeOptions());
  BModeRenderer used(ct, SmallProbe(acoustics::ProbeKind::kLinear), DefaultBModeOptions());
  image::GrayImage a;
  image::GrayImage b;
  used.Render(OnTheSkin() * Eigen::Translation3d(3, -20, 1), SomeNeedle(), b);
  used.Render(OnTheSkin(), std::nullopt, b);
  fresh.Render(OnTheSkin(), std::nullopt, a);
  EXPECT_EQ(a.pixels, b.pixels);
}

TEST(BMode, AllocatesNothingAfterTheFirstImage) {
  const volume::CtVolume ct = NoisyBody();
  BModeOptions options = DefaultBModeOptions();
  options.texture = options.attenuation = true;
  options.angle_exponent = 1;
  for (const acoustics::ProbeKind kind :
       {acoustics::ProbeKind::kLinear, acoustics::ProbeKind::kCurvilinear}) {
    BModeRenderer renderer(ct, SmallProbe(kind), options);
    image::GrayImage image;
    renderer.Render(OnTheSkin(), SomeNeedle(), image);
    const long before = testing_support::num_allocations;
    for (int n = 0; n < 5; ++n) {
      renderer.Render(OnTheSkin() * Eigen::Translation3d(n, 0, 0.1 * n), SomeNeedle(), image);
    }
    EXPECT_EQ(testing_support::num_allocations - before, 0);
  }
}

TEST(BMode, TheBeamModelAllocatesNothingAfterTheFirstImage) {
  const volume::CtVolume ct = NoisyBody();
  const acoustics::TissueAcousticsTable table{
      .name = "test",
      .file = "test table",
      .tissues = {{"air", {.impedance_mrayl = 0.0004}}, {"liver", {}}},
      .by_hu = {{-1000, "air"}, {-300, "air"}, {0, "liver"}}};
  for (const acoustics::ProbeKind kind :
       {acoustics::ProbeKind::kLinear, acoustics::ProbeKind::kCurvilinear}) {
    BeamOptions options;
    options.elevation_planes = 3;
    options.time_of_flight = options.refraction = options.multiple_reflections = true;
    acoustics::Probe probe = SmallProbe(kind);
    probe.scan_lines = 64;
    probe.samples_per_line = 200;
    BeamRenderer renderer({.ct = &ct, .acoustics = &table}, probe, options);
    image::GrayImage image;
    renderer.Render(OnTheSkin(), SomeNeedle(), image, 2);
    const long before = testing_support::num_allocations;
    for (int n = 0; n < 5; ++n) {
      renderer.Render(OnTheSkin() * Eigen::Translation3d(n, 0, 0.1 * n), SomeNeedle(), image, 2);
    }
    EXPECT_EQ(testing_support::num_allocations - before, 0);
  }
}

TEST(BMode, APlaneOutsideTheVolumeIsBlack) {
  const volume::CtVolume ct = NoisyBody();
  BModeRenderer renderer(ct, SmallProbe(acoustics::ProbeKind::kLinear), DefaultBModeOptions());
  image::GrayImage image;
  for (const double z_mm : {45.0, -10.0, 1e7}) {
    renderer.Render(Eigen::Isometry3d(Eigen::Translation3d(30, 3.6, z_mm)), std::nullopt, image);
    EXPECT_EQ(*std::max_element(image.pixels.begin(), image.pixels.end()), 0) << z_mm;
  }
}

TEST(BMode, WithoutContactThereIsNoImage) {
  const volume::CtVolume ct = NoisyBody();
  BModeRenderer renderer(ct, SmallProbe(acoustics::ProbeKind::kLinear), DefaultBModeOptions());
  image::GrayImage touching;
  image::GrayImage lifted;
  renderer.Render(OnTheSkin(), std::nullopt, touching);
  renderer.Render(Eigen::Isometry3d(Eigen::Translation3d(30, -8, 20)), std::nullopt, lifted);
  EXPECT_GT(*std::max_element(touching.pixels.begin(), touching.pixels.end()), 200);
  EXPECT_EQ(*std::max_element(lifted.pixels.begin(), lifted.pixels.end()), 0);
}

TEST(BMode, SurvivesHardPoses) {
  const volume::CtVolume ct = NoisyBody();
  BModeRenderer renderer(ct, SmallProbe(acoustics::ProbeKind::kLinear), DefaultBModeOptions());
  image::GrayImage image;
  // Grazing the last slice, along the edge of the volume, and a needle along the plane's border.
  image::NeedleInImage needle = SomeNeedle();
  for (const double z_mm : {-0.5, 39.5, 0.0, 39.0}) {
    needle.tip_in_ct_mm << 10.0, 3.6, z_mm + 1.5 + needle.radius_mm;
    needle.axis_in_ct << 1, 0, 0;
    renderer.Render(Eigen::Isometry3d(Eigen::Translation3d(30, 3.6, z_mm)), needle, image);
    EXPECT_EQ(image.width, 300);
  }
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Eigen::Isometry3d pose = OnTheSkin();
  pose.translation().z() = nan;
  EXPECT_THROW(renderer.Render(pose, std::nullopt, image), InputError);
  pose = OnTheSkin();
  pose.linear()(0, 0) = std::numeric_limits<double>::infinity();
  EXPECT_THROW(renderer.Render(pose, std::nullopt, image), InputError);
  needle.axis_in_ct.x() = nan;
  EXPECT_THROW(renderer.Render(OnTheSkin(), needle, image), InputError);
}

TEST(BMode, RefusesAProbeThatIsNone) {
  const volume::CtVolume ct = NoisyBody();
  const auto refuses = [&](auto change, acoustics::ProbeKind kind = acoustics::ProbeKind::kLinear) {
    acoustics::Probe probe = SmallProbe(kind);
    change(probe);
    EXPECT_THROW(BModeRenderer(ct, probe, DefaultBModeOptions()), InputError);
  };
  refuses([](acoustics::Probe& p) { p.image_width_px = 15; });
  refuses([](acoustics::Probe& p) { p.image_height_px = 4097; });
  refuses([](acoustics::Probe& p) { p.depth_mm = 0; });
  refuses([](acoustics::Probe& p) { p.width_mm = -1; });
  refuses([](acoustics::Probe& p) { p.dynamic_range_db = 0; });
  refuses([](acoustics::Probe& p) { p.dynamic_range_db = 121; });
  refuses([](acoustics::Probe& p) { p.gain_db = std::numeric_limits<double>::quiet_NaN(); });
  refuses([](acoustics::Probe& p) { p.slice_thickness_mm = -1; });
  refuses([](acoustics::Probe& p) { p.scan_lines = 15; }, acoustics::ProbeKind::kCurvilinear);
  refuses([](acoustics::Probe& p) { p.radius_mm = 0; }, acoustics::ProbeKind::kCurvilinear);
  refuses([](acoustics::Probe& p) { p.field_of_view_rad = 3.1; },
          acoustics::ProbeKind::kCurvilinear);
}

TEST(BMode, ExtremesOfDepthWork) {
  const volume::CtVolume ct = NoisyBody();
  for (const double depth_mm : {0.5, 5.0, 300.0}) {
    acoustics::Probe probe = SmallProbe(acoustics::ProbeKind::kLinear);
    probe.depth_mm = depth_mm;
    BModeRenderer renderer(ct, probe, DefaultBModeOptions());
    image::GrayImage image;
    renderer.Render(OnTheSkin(), SomeNeedle(), image);
    EXPECT_EQ(image.pixels.size(), 300U * 200U);
  }
}

}  // namespace
}  // namespace acus::ultrasound
