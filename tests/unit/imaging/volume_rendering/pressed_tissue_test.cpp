#include "acus/imaging/volume_rendering/pressed_tissue.h"

#include <cmath>
#include <gmock/gmock.h>

#include "acus/base/core/error.h"
#include "acus/imaging/volume_rendering/moving_surface.h"
#include "acus/imaging/volume_rendering/patient_view.h"
#include "acus/imaging/volume_rendering/pressed_surface.h"
#include "support/view_scenes.h"

namespace acus::volume_rendering {
namespace {

using testing_support::At;
using testing_support::BallCt;
using testing_support::BallSurface;
using testing_support::Blob;
using testing_support::CoveredPart;
using testing_support::DiaphragmMm;
using testing_support::FieldOf;

const Eigen::Vector3d kDentMm{5.0, -12.0, 8.0};
constexpr double kDentSigmaMm = 14.0;

/// Tissue that is at x now was above it: pressed along -y by a Gaussian of that depth.
Eigen::Vector3d Dent(const Eigen::Vector3d& x, double depth_mm) {
  const double far_2 = (x - kDentMm).squaredNorm() / (kDentSigmaMm * kDentSigmaMm);
  return x - depth_mm * std::exp(-0.5 * far_2) * Eigen::Vector3d::UnitY();
}
PressedTissue DentOf(double depth_mm, double spacing_mm, int num_threads = 1) {
  const Eigen::AlignedBox3d box(kDentMm.array() - 70.0, kDentMm.array() + 70.0);
  return {box, spacing_mm,
          [=](const Eigen::Vector3d& x, const Eigen::Vector3d&) { return Dent(x, depth_mm); },
          num_threads};
}
/// Tissue shifted as a whole, far around everything that is seen.
PressedTissue ShiftOf(const Eigen::Vector3d& shift_mm) {
  const Eigen::AlignedBox3d box(Eigen::Vector3d::Constant(-120), Eigen::Vector3d::Constant(120));
  return {box, 10.0,
          [=](const Eigen::Vector3d& x, const Eigen::Vector3d&) -> Eigen::Vector3d {
            return x - shift_mm;
          },
          1};
}

template <class Visit>
void OverPlaces(const Visit& visit) {
  for (double z = -40.0; z <= 56.0; z += 3.7) {
    for (double y = -60.0; y <= 36.0; y += 4.3) {
      for (double x = -43.0; x <= 53.0; x += 4.9) visit(Eigen::Vector3d(x, y, z));
    }
  }
}

TEST(PressedTissue, ReadsBetweenKnotsToTheBoundOfLinearInterpolation) {
  for (const double spacing_mm : {8.0, 4.0, 2.0}) {
    const PressedTissue pressed = DentOf(10.0, spacing_mm);
    double worst_mm = 0.0;
    OverPlaces([&](const Eigen::Vector3d& x) {
      const Eigen::Vector3d read = x + pressed.OffsetMm(x.cast<float>()).cast<double>();
      worst_mm = std::max(worst_mm, (read - Dent(x, 10.0)).norm());
    });
    // h^2 / 8 times the second derivatives along the three axes, of which none is above A / s^2.
    const double bound_mm =
        3.0 / 8.0 * spacing_mm * spacing_mm * 10.0 / (kDentSigmaMm * kDentSigmaMm);
    EXPECT_LT(worst_mm, bound_mm) << spacing_mm;
    EXPECT_GT(worst_mm, 0.05 * bound_mm) << spacing_mm;
  }
}

TEST(PressedTissue, TheInverseHoldsItsTolerance) {
  // Up to a slope of 0.87 of the displacement along y.
  for (const double depth_mm : {2.0, 10.0, 20.0}) {
    const PressedTissue pressed = DentOf(depth_mm, 3.0);
    int most = 0;
    OverPlaces([&](const Eigen::Vector3d& y) {
      const auto found = pressed.WorldMm(y);
      const Eigen::Vector3d back =
          found.rest_mm + pressed.OffsetMm(found.rest_mm.cast<float>()).cast<double>();
      EXPECT_LE((back - y).norm(), PressedTissue::kInverse.tolerance_mm + 1e-4);
      most = std::max(most, found.iterations);
    });
    EXPECT_GE(most, 1);
    EXPECT_LT(most, PressedTissue::kInverse.max_iterations) << depth_mm;
  }
}

TEST(PressedTissue, AFoldIsBounded) {
  const PressedTissue pressed = DentOf(200.0, 3.0);
  OverPlaces([&](const Eigen::Vector3d& y) {
    const auto found = pressed.WorldMm(y);
    EXPECT_TRUE(found.rest_mm.allFinite());
    EXPECT_LE(found.residual_mm, 200.0);
    EXPECT_LE(found.iterations, PressedTissue::kInverse.max_iterations);
  });
}

TEST(PressedTissue, OutsideOfItNothingMoves) {
  const PressedTissue pressed = ShiftOf({0.0, 9.0, 0.0});
  const Eigen::Vector3d far_away(300.0, 20.0, -4.0);
  EXPECT_EQ(pressed.WorldMm(far_away).rest_mm, far_away);
  EXPECT_TRUE(pressed.OffsetMm(far_away.cast<float>()).isZero(0.0F));
  EXPECT_TRUE(PressedTissue().empty());
  const Eigen::AlignedBox3d box(Eigen::Vector3d::Zero(), Eigen::Vector3d::Ones());
  const auto stay = [](const Eigen::Vector3d& x, const Eigen::Vector3d&) { return x; };
  EXPECT_TRUE(PressedTissue(box, 0.5, stay, 1).empty());
  EXPECT_THROW(PressedTissue(box, 1e-4, stay, 1), InputError);
  EXPECT_THROW(PressedTissue(box, 0.0, stay, 1), InputError);
}

TEST(PressedTissue, TheGradientIsThatOfTheMap) {
  const PressedTissue pressed = DentOf(10.0, 1.0);
  OverPlaces([&](const Eigen::Vector3d& x) {
    Eigen::Matrix3d truth;
    constexpr double kStepMm = 0.01;
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::Vector3d aside = kStepMm * Eigen::Vector3d::Unit(axis);
      truth.col(axis) = (Dent(x + aside, 10.0) - Dent(x - aside, 10.0)) / (2.0 * kStepMm);
    }
    EXPECT_LT((pressed.GradientAt(x.cast<float>()).cast<double>() - truth).norm(), 0.02);
  });
}

TEST(PressedSurface, NodesLieWhereTheMapTakesThemAndNormalsFollow) {
  const MovingSurface ball(BallSurface({5.0, 10.0, 8.0}, 20.0));
  const PressedTissue pressed = DentOf(8.0, 3.0);
  PressedSurface surface;
  surface.Update(pressed, ball.nodes_mm(), ball.normals(), ball.triangles(), 1);
  EXPECT_GT(surface.num_pressed(), 500);
  const MovingSurface truth({surface.nodes_mm().cast<double>(), ball.triangles()});
  for (Eigen::Index i = 0; i < ball.nodes_mm().cols(); ++i) {
    const Eigen::Vector3f at = surface.nodes_mm().col(i);
    EXPECT_LE((at + pressed.OffsetMm(at) - ball.nodes_mm().col(i)).norm(), 0.021F);
    EXPECT_LT((surface.normals().col(i) - truth.normals().col(i)).norm(), 1e-4F) << i;
  }
  PressedSurface with_threads;
  with_threads.Update(pressed, ball.nodes_mm(), ball.normals(), ball.triangles(), 3);
  EXPECT_EQ(with_threads.nodes_mm(), surface.nodes_mm());
  EXPECT_EQ(with_threads.normals(), surface.normals());
  surface.Update({}, ball.nodes_mm(), ball.normals(), ball.triangles(), 1);
  EXPECT_EQ(surface.nodes_mm(), ball.nodes_mm());
}

const Eigen::Vector3d kPressedBallMm{12.0, -8.0, 15.0};
constexpr double kPressedRadiusMm = 20.0;

PatientInView PressedBall(bool volume, const breathing::MotionField* field = nullptr) {
  if (!volume) {
    return {.ct = nullptr,
            .layers = {},
            .surfaces = {{"ball", BallSurface(kPressedBallMm, kPressedRadiusMm)}},
            .field = field};
  }
  return {.ct = BallCt(kPressedBallMm, kPressedRadiusMm),
          .layers = {{"skin", 1.0}},
          .surfaces = {},
          .field = field};
}
Camera InFrontCamera() {
  return LookAt({.eye_in_ct_mm = {0, -450, 0}, .focus_in_ct_mm = {0, 0, 0}}, {256, 256});
}
ViewImage InFrontOf(PatientView& view, const ViewMoment& moment, int num_threads = 1) {
  ViewImage image;
  view.Render(InFrontCamera(), moment, image, num_threads);
  return image;
}

TEST(PressedTissue, RaysAndSurfacesShowBreathAndThenTools) {
  const Eigen::Vector3d breath_mm(4.0, -6.0, -12.0);
  const Eigen::Vector3d press_mm(-14.0, 9.0, 7.0);
  const auto field = FieldOf([&](const Eigen::Vector3d&) { return breath_mm; });
  const auto motion = At(field, 1.0);
  const PressedTissue pressed = ShiftOf(press_mm);
  PatientView truth_view({.ct = nullptr,
                          .layers = {},
                          .surfaces = {{"ball", BallSurface(kPressedBallMm + breath_mm + press_mm,
                                                            kPressedRadiusMm)}}},
                         {});
  PatientView still_view(
      {.ct = nullptr,
       .layers = {},
       .surfaces = {{"ball", BallSurface(kPressedBallMm + press_mm, kPressedRadiusMm)}}},
      {});
  const Blob truth = CoveredPart(InFrontOf(truth_view, {}));
  const Blob still = CoveredPart(InFrontOf(still_view, {}));
  for (const bool volume : {true, false}) {
    PatientView view(PressedBall(volume, &field), {});
    const Blob seen = CoveredPart(InFrontOf(view, {.motion = &motion, .pressed = &pressed}));
    EXPECT_LT((seen.middle_px - truth.middle_px).norm(), 0.3) << volume;
    EXPECT_NEAR(seen.diameter_px, truth.diameter_px, 1.0) << volume;
    const Blob at_rest = CoveredPart(InFrontOf(view, {.pressed = &pressed}));
    EXPECT_LT((at_rest.middle_px - still.middle_px).norm(), 0.3) << volume;
  }
}

TEST(PressedTissue, AVolumeAndASurfaceAreDentedAlike) {
  const auto field = FieldOf(DiaphragmMm);
  const auto motion = At(field, 0.5);
  const PressedTissue pressed(
      {kPressedBallMm.array() - 60.0, kPressedBallMm.array() + 60.0}, 2.0,
      [](const Eigen::Vector3d& x, const Eigen::Vector3d&) -> Eigen::Vector3d {
        const double far_2 = (x - kPressedBallMm - Eigen::Vector3d(20.0, 0.0, -10.0)).squaredNorm();
        return x + 12.0 * std::exp(-0.5 * far_2 / 150.0) * Eigen::Vector3d::UnitX();
      },
      1);
  PatientView volume(PressedBall(true, &field), {});
  PatientView surface(PressedBall(false, &field), {});
  const ViewMoment dented{.motion = &motion, .pressed = &pressed};
  const Blob by_volume = CoveredPart(InFrontOf(volume, dented));
  const Blob by_surface = CoveredPart(InFrontOf(surface, dented));
  const Blob whole = CoveredPart(InFrontOf(surface, {.motion = &motion}));
  EXPECT_LT(by_surface.diameter_px, whole.diameter_px - 2.0);
  EXPECT_LT((by_volume.middle_px - by_surface.middle_px).norm(), 0.3);
  EXPECT_NEAR(by_volume.diameter_px, by_surface.diameter_px, 1.0);
}

TEST(PressedTissue, SameBitsWithThreadsAndNothingStaysBehind) {
  const auto field = FieldOf(DiaphragmMm);
  const auto motion = At(field, 1.0);
  const PressedTissue pressed = DentOf(10.0, 3.0);
  PatientInView patient = PressedBall(true, &field);
  patient.surfaces = PressedBall(false).surfaces;
  patient.surfaces[0].opacity = 0.4;
  PatientView view(patient, {});
  PatientView fresh(patient, {});
  const ViewMoment dented{.motion = &motion, .pressed = &pressed};
  const auto first = InFrontOf(view, dented).colour.rgb;
  const auto whole = InFrontOf(view, {.motion = &motion}).colour.rgb;
  EXPECT_NE(first, whole);
  EXPECT_EQ(whole, InFrontOf(fresh, {.motion = &motion}).colour.rgb);
  EXPECT_EQ(first, InFrontOf(view, dented, 3).colour.rgb);
  const auto at_rest = InFrontOf(view, {}).colour.rgb;
  InFrontOf(view, {.pressed = &pressed});
  EXPECT_EQ(at_rest, InFrontOf(view, {}).colour.rgb);
}

TEST(PatientView, ThePathOfATipIsALineAlongIt) {
  PatientView view(PressedBall(false), {});
  const std::vector<Eigen::Vector3d> path = {
      {-60.0, -40.0, 45.0}, {-20.0, -40.0, 45.0}, {-20.0, -40.0, 45.1}, {30.0, -40.0, 45.0}};
  const ViewImage without = InFrontOf(view, {});
  const ViewImage with = InFrontOf(view, {.path_in_ct_mm = path});
  const auto is_orange = [&](const ViewImage& image, const Eigen::Vector3d& place) {
    const Eigen::Vector2i at =
        InFrontCamera().ProjectPx(place).array().round().cast<int>().matrix();
    const auto n = static_cast<std::size_t>(3 * (at[1] * 256 + at[0]));
    return image.colour.rgb[n] > 200 && image.colour.rgb[n + 2] < 90;
  };
  for (double share = 0.02; share < 1.0; share += 0.07) {
    const Eigen::Vector3d place(-60.0 + 90.0 * share, -40.0, 45.0);
    EXPECT_TRUE(is_orange(with, place)) << share;
    EXPECT_FALSE(is_orange(without, place)) << share;
  }
  EXPECT_FALSE(is_orange(with, {-60.0, -40.0, 60.0}));
  const std::vector<Eigen::Vector3d> one = {path[0], Eigen::Vector3d::Constant(std::nan(""))};
  EXPECT_EQ(InFrontOf(view, {.path_in_ct_mm = one}).colour.rgb, without.colour.rgb);
}

TEST(CutPlanes, HalfABallIsShownAndToolsAreNotCut) {
  const CutPlane cut(Eigen::Vector3d::UnitX(), kPressedBallMm);
  const auto half_of = [&](PatientView& view, const ViewMoment& whole, ViewMoment half) {
    half.cuts = {cut};
    const Blob all = CoveredPart(InFrontOf(view, whole));
    const Blob part = CoveredPart(InFrontOf(view, half));
    EXPECT_NEAR(std::pow(part.diameter_px / all.diameter_px, 2), 0.5, 0.03);
    // The middle of half a disc lies 4 r / (3 pi) beside its straight side: x is to the left here.
    EXPECT_NEAR(std::abs(part.middle_px[0] - all.middle_px[0]),
                0.5 * all.diameter_px * 4.0 / (3.0 * M_PI), 1.0);
  };
  for (const bool volume : {true, false}) {
    PatientView view(PressedBall(volume), {});
    half_of(view, {}, {});
    ViewMoment none;
    none.cuts = {cut, CutPlane(-Eigen::Vector3d::UnitX(), kPressedBallMm)};
    EXPECT_LT(CoveredPart(InFrontOf(view, none)).diameter_px, 3.0);
    ViewMoment with_needle = none;
    with_needle.needle.emplace();
    with_needle.needle->tip_in_ct_mm = kPressedBallMm + Eigen::Vector3d(10.0, -40.0, 0.0);
    with_needle.needle->axis_in_ct = -Eigen::Vector3d::UnitX();
    with_needle.needle->length_mm = 50.0;
    with_needle.needle->radius_mm = 2.0;
    EXPECT_GT(CoveredPart(InFrontOf(view, with_needle)).diameter_px, 8.0);
    ViewMoment bad;
    bad.cuts = {CutPlane(Eigen::Vector3d::Constant(std::nan("")), 0.0)};
    EXPECT_THROW(InFrontOf(view, bad), InputError);
  }
}

}  // namespace
}  // namespace acus::volume_rendering
