#include "acus/physics/tissue/displacement_functions.h"

#include <Eigen/Geometry>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <numbers>

#include "acus/base/core/error.h"
#include "acus/base/core/random.h"

namespace acus::tissue {
namespace {

using Eigen::Vector3d;

// The needle goes in along +z from the skin at z = 0; below `from` the tissue is ten times stiffer.
ModulusAt TwoModuli(double soft_mpa, double stiff_mpa, double from_mm) {
  return [=](const Vector3d& p) {
    return p.z() < 0.0 ? 0.0 : (p.z() < from_mm ? soft_mpa : stiff_mpa);
  };
}

TissueLoad Indenting(double depth_mm, double force_n) {
  TissueLoad load;
  load.needle.in_contact = true;
  load.needle.tip_in_ct_mm = Vector3d(0, 0, depth_mm);
  load.needle.pre_puncture_n = force_n;
  return load;
}

TissueLoad Inside(double depth_mm, double cutting_n, double friction_n) {
  TissueLoad load = Indenting(depth_mm, 0.0);
  load.needle.pierced = true;
  load.needle.cutting_n = cutting_n;
  load.needle.friction_n = friction_n;
  return load;
}

TEST(Fade, IsThePapersPolynomialAtItsSpecialPoints) {
  const auto g = [](double t) { return 1.0 - (3.0 * t * t - 2.0 * t * t * t); };
  EXPECT_EQ(Fade(0.0), 1.0);
  EXPECT_EQ(Fade(1.0), 0.0);
  EXPECT_DOUBLE_EQ(Fade(0.5), 0.5);
  EXPECT_EQ(ShaftFade(0.0), 5.0);
  EXPECT_EQ(ShaftFade(1.0), 0.0);
  for (double t = 0.0; t <= 1.0; t += 0.0625) {
    EXPECT_NEAR(Fade(t), g(t), 1e-15);
    EXPECT_NEAR(ShaftFade(t), g(2.0 - t), 1e-14);
  }
  for (const double outside : {1.0, 1.5, 100.0}) EXPECT_EQ(Fade(outside) + ShaftFade(outside), 0.0);
  EXPECT_EQ(Fade(-1.0), 1.0);
}

TEST(DisplacementFunctions, AsPrintedIsEquation13) {
  const DisplacementFunctions printed(DisplacementFunctionSettings::AsPrinted(),
                                      TwoModuli(0.5, 5.0, 12.0));
  const TissueLoad load = Indenting(4.0, 1.5);
  const auto d = [&](double x, double z) {
    return printed.DisplacementMm(load, Vector3d(x, 0, z)).z();
  };
  EXPECT_DOUBLE_EQ(d(0.0, 2.0), 4.0 * 5.0);                     // z_max g(2)
  EXPECT_DOUBLE_EQ(d(10.0, 2.0), 4.0 * (0.25 * 4.0));           // z_max g(1.5)
  EXPECT_DOUBLE_EQ(d(0.0, 4.0 + 5.0), 1.5 / 0.5 * Fade(0.25));  // f/E g(r/R), soft
  EXPECT_DOUBLE_EQ(d(0.0, 4.0 + 10.0), 1.5 / 5.0 * 0.5);        // stiff
  EXPECT_DOUBLE_EQ(d(6.0, 4.0 + 8.0), 1.5 / 5.0 * 0.5);         // r is spherical: 6, 8, 10.
  EXPECT_EQ(d(20.0, 2.0), 0.0);
  EXPECT_EQ(d(0.0, 24.0), 0.0);
  EXPECT_EQ(d(12.1, 4.0 + 16.0), 0.0);
}

TEST(DisplacementFunctions, AsPrintedIsEquation14) {
  const DisplacementFunctions printed(DisplacementFunctionSettings::AsPrinted(),
                                      TwoModuli(0.5, 5.0, 30.0));
  const TissueLoad load = Inside(40.0, 0.8, 2.0);
  const auto d = [&](double x, double z) {
    return printed.DisplacementMm(load, Vector3d(x, 0, z)).z();
  };
  EXPECT_DOUBLE_EQ(d(0.0, 10.0), 2.0 / (40.0 * 0.5) * 5.0);
  EXPECT_DOUBLE_EQ(d(10.0, 10.0), 2.0 / (40.0 * 0.5) * 1.0);
  EXPECT_DOUBLE_EQ(d(10.0, 35.0), 2.0 / (40.0 * 5.0) * 1.0);
  EXPECT_DOUBLE_EQ(d(0.0, 50.0), 0.8 / 5.0 * 0.5);
}

TEST(DisplacementFunctions, TheTipTakesTheTissueWithItBeforeThePuncture) {
  const DisplacementFunctions functions({}, TwoModuli(0.02, 0.2, 12.0));
  for (const double depth_mm : {0.1, 1.0, 3.0, 8.0, 11.9}) {
    const TissueLoad load = Indenting(depth_mm, 2.0);
    EXPECT_NEAR(functions.DisplacementMm(load, load.needle.tip_in_ct_mm).z(), depth_mm, 1e-12);
  }
  // Where the tissue below is stiffer, it moves less.
  const TissueLoad load = Indenting(3.0, 2.0);
  const double stiff_mm = functions.DisplacementMm(load, Vector3d(0, 0, 15.0)).z();
  EXPECT_NEAR(stiff_mm, 3.0 * 0.1 * Fade(12.0 / 20.0), 1e-12);
}

TEST(DisplacementFunctions, AfterThePunctureGoesWithForceAndWithOneOverE) {
  const auto at = [](double modulus_mpa, const TissueLoad& load, const Vector3d& p) {
    return DisplacementFunctions({}, TwoModuli(modulus_mpa, modulus_mpa, 0.0))
        .DisplacementMm(load, p);
  };
  const TissueLoad load = Inside(40.0, 0.6, 1.2);
  const Vector3d shaft(3, 4, 15);
  const Vector3d below(0, 5, 52);
  const double e = 0.1;
  EXPECT_NEAR(at(e, load, shaft).z(), 1.2 / (40.0 * e) * ShaftFade(0.25) / 5.0, 1e-12);
  EXPECT_NEAR(at(e, load, below).z(), 0.6 / (16.0 * std::numbers::pi * e) * Fade(13.0 / 20.0),
              1e-12);
  EXPECT_NEAR(at(2 * e, load, shaft).z(), 0.5 * at(e, load, shaft).z(), 1e-12);
  EXPECT_NEAR(at(2 * e, load, below).z(), 0.5 * at(e, load, below).z(), 1e-12);
  // A needle drawn back takes the tissue along its shaft outwards.
  EXPECT_NEAR(at(e, Inside(40.0, 0.6, -1.2), shaft).z(), -at(e, load, shaft).z(), 1e-12);
}

TEST(DisplacementFunctions, TurnWithTheNeedle) {
  const Eigen::Isometry3d turn =
      Eigen::Translation3d(30, -12, 7) * Eigen::AngleAxisd(0.8, Vector3d(1, 2, -0.5).normalized());
  const ModulusAt layers = TwoModuli(0.05, 0.5, 20.0);
  const ModulusAt turned_layers = [&](const Vector3d& p) { return layers(turn.inverse() * p); };
  DisplacementFunctionSettings at_point;
  at_point.modulus_blend_mm = 0.0;  // The grid of the blend does not turn.
  const DisplacementFunctions upright(at_point, layers);
  const DisplacementFunctions turned(at_point, turned_layers);
  for (const TissueLoad& load : {Indenting(5.0, 1.0), Inside(31.0, 0.7, 0.9)}) {
    TissueLoad turned_load = load;
    turned_load.needle.entry_in_ct_mm = turn * load.needle.entry_in_ct_mm;
    turned_load.needle.tip_in_ct_mm = turn * load.needle.tip_in_ct_mm;
    turned_load.needle.axis_in_ct = 2.5 * (turn.linear() * load.needle.axis_in_ct);
    RandomStream random(3, "points");
    for (int i = 0; i < 500; ++i) {
      const Vector3d p(random.Uniform(-25, 25), random.Uniform(-25, 25), random.Uniform(-5, 60));
      const Vector3d want = turn.linear() * upright.DisplacementMm(load, p);
      EXPECT_NEAR((turned.DisplacementMm(turned_load, turn * p) - want).norm(), 0.0, 1e-9);
    }
  }
}

// Steps of 10 um across the whole field, interfaces, skin, both zones and the border.
TEST(DisplacementFunctions, HaveNoStepAnywhereAndDoNotFold) {
  for (const double stiff_mpa : {0.02, 0.2, 20.0}) {
    const DisplacementFunctions functions({}, TwoModuli(0.02, stiff_mpa, 15.0));
    for (const TissueLoad& load : {Indenting(0.5, 1), Indenting(12, 3), Inside(0.2, 1, 0),
                                   Inside(14, 1, 1), Inside(40, 5, -3), Inside(60, 0, 30)}) {
      const auto prepared = functions.Prepare(load);
      for (const double x : {0.0, 0.3, 5.0, 10.0, 19.0}) {
        double before = functions.DisplacementMm(prepared, Vector3d(x, 0, -21)).z();
        EXPECT_EQ(before, 0.0);
        for (double z = -20.99; z < 82.0; z += 0.01) {
          const double now = functions.DisplacementMm(prepared, Vector3d(x, 0, z)).z();
          ASSERT_LT(std::abs(now - before), 0.13) << x << " " << z;
          if (stiff_mpa == 0.02 || prepared.pierced) {
            ASSERT_GT(now - before, -0.01)
                << "folds at x " << x << ", z " << z << ", depth " << load.needle.tip_in_ct_mm.z();
          }
          before = now;
        }
        EXPECT_EQ(before, 0.0);
      }
      for (const double z : {-3.0, 1.0, 14.0, 30.0, 45.0}) {
        double before = functions.DisplacementMm(prepared, Vector3d(-20.5, 0, z)).z();
        for (double x = -20.49; x < 20.5; x += 0.01) {
          const double now = functions.DisplacementMm(prepared, Vector3d(x, 0, z)).z();
          ASSERT_LT(std::abs(now - before), 0.06);
          before = now;
        }
      }
    }
  }
}

TEST(DisplacementFunctions, BoneStaysWhereItIs) {
  const DisplacementFunctions functions({}, TwoModuli(0.02, 10000.0, 20.0));
  const TissueLoad load = Inside(18.0, 1.0, 1.0);
  EXPECT_LT(functions.DisplacementMm(load, Vector3d(0, 0, 24)).norm(), 1e-5);
  EXPECT_GT(functions.DisplacementMm(load, Vector3d(0, 0, 17)).norm(), 1.0);
  // Infinitely stiff: not at all, not even where the needle touches nothing else.
  const double inf = std::numeric_limits<double>::infinity();
  const DisplacementFunctions rigid({}, TwoModuli(0.02, inf, 20.0));
  EXPECT_EQ(rigid.DisplacementMm(load, Vector3d(0, 0, 30)).norm(), 0.0);
  const DisplacementFunctions all_bone({}, TwoModuli(inf, inf, 20.0));
  EXPECT_EQ(all_bone.DisplacementMm(load, Vector3d(0, 0, 10)).norm(), 0.0);
  const Vector3d pressed = all_bone.DisplacementMm(Indenting(0.1, 3.0), Vector3d(0, 0, 10));
  EXPECT_EQ(pressed.norm(), 0.0);
}

TEST(DisplacementFunctions, NothingMovesWithoutContactOrWithInvalidData) {
  const DisplacementFunctions functions({}, TwoModuli(0.02, 0.2, 20.0));
  const Vector3d p(1, 1, 5);
  EXPECT_EQ(functions.DisplacementMm(TissueLoad(), p).norm(), 0.0);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  for (const double bad : {nan, inf, -inf}) {
    TissueLoad load = Inside(20, 1, 1);
    load.needle.cutting_n = bad;
    EXPECT_EQ(functions.DisplacementMm(load, p).norm(), 0.0);
    load = Inside(20, 1, 1);
    load.needle.tip_in_ct_mm.y() = bad;
    EXPECT_EQ(functions.DisplacementMm(load, p).norm(), 0.0);
    EXPECT_EQ(functions.DisplacementMm(Inside(20, 1, 1), Vector3d(0, bad, 5)).norm(), 0.0);
  }
  TissueLoad load = Inside(20, 1, 1);
  load.needle.axis_in_ct.setZero();
  EXPECT_EQ(functions.DisplacementMm(load, p).norm(), 0.0);
}

TEST(DisplacementFunctions, RefuseSettingsOutOfRange) {
  const ModulusAt modulus = TwoModuli(0.02, 0.2, 20.0);
  for (const double bad : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN()}) {
    DisplacementFunctionSettings settings;
    settings.influence_radius_mm = bad;
    EXPECT_THROW(DisplacementFunctions(settings, modulus), InputError);
    settings = {};
    settings.tip_length_mm = bad - 0.1;
    EXPECT_THROW(DisplacementFunctions(settings, modulus), InputError);
    settings = {};
    settings.largest_share = bad;
    EXPECT_THROW(DisplacementFunctions(settings, modulus), InputError);
    settings = {};
    settings.transition_mm = bad - 0.1;
    EXPECT_THROW(DisplacementFunctions(settings, modulus), InputError);
    settings = {};
    settings.modulus_blend_mm = bad - 0.1;
    EXPECT_THROW(DisplacementFunctions(settings, modulus), InputError);
  }
}

}  // namespace
}  // namespace acus::tissue
