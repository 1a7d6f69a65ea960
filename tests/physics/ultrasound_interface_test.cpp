// Echoes of flat interfaces: how strong, where, and what is behind them, against Fresnel, Snell and
// the clock.
#include <gtest/gtest.h>

#include "support/beam_targets.h"

namespace acus::ultrasound {
namespace {

using testing_support::Bare;
using testing_support::Clear;
using testing_support::Db;
using testing_support::FaceAt;
using testing_support::LabelledBlock;
using testing_support::Scattering;
using testing_support::TableOf;
using testing_support::TargetProbe;

constexpr double kDegree = std::numbers::pi / 180.0;

/// 60 x 45 x 8 mm in voxels of 0.25 mm; border at y = 20 mm.
volume::LabelMap TwoHalves(const char* above, const char* below) {
  return LabelledBlock({240, 180, 32}, 0.25, {{1, above}, {2, below}},
                       [](double, double y, double) -> volume::Label { return y < 20.0 ? 1 : 2; });
}

/// Reflected amplitude of a plane wave between fluids.
double Fresnel(const acoustics::TissueAcoustics& a, const acoustics::TissueAcoustics& b,
               double angle_rad) {
  const double sine = b.speed_m_per_s / a.speed_m_per_s * std::sin(angle_rad);
  const double cos_b = std::sqrt(1.0 - sine * sine);
  const double from = b.impedance_mrayl * std::cos(angle_rad);
  const double to = a.impedance_mrayl * cos_b;
  return std::abs((from - to) / (from + to));
}

/// Largest envelope of each line near the middle, averaged over 21 lines. A parabola in dB finds
/// the peak between samples.
double PeakOfMiddleLines(const slicing::BeamImage& envelope) {
  double sum = 0.0;
  const int middle = envelope.lines() / 2;
  for (int l = middle - 10; l <= middle + 10; ++l) {
    int best = 1;
    for (int k = 1; k + 1 < envelope.samples(); ++k) {
      if (envelope.row(k)[l] > envelope.row(best)[l]) best = k;
    }
    const double before = std::log(envelope.row(best - 1)[l]);
    const double here = std::log(envelope.row(best)[l]);
    const double behind = std::log(envelope.row(best + 1)[l]);
    const double slope = 0.5 * (behind - before);
    sum += std::exp(here - 0.5 * slope * slope / (before - 2.0 * here + behind));
  }
  return sum / 21.0;
}

TEST(BeamInterface, SendsBackWhatFresnelSaysAtAnyAngle) {
  const acoustics::TissueAcoustics fat = Clear(1450.0, 1.38);
  const acoustics::TissueAcoustics muscle = Clear(1580.0, 1.70);
  const auto table = TableOf({{"fat", fat}, {"muscle", muscle}});
  const auto labels = TwoHalves("fat", "muscle");
  BeamOptions options = Bare();
  options.interfaces = options.angle = options.point_spread = true;
  acoustics::Probe probe = TargetProbe();
  probe.samples_per_line = 1601;
  BeamRenderer renderer({.labels = &labels, .acoustics = &table}, probe, options);
  for (const double deg : {0.0, 5.0, 10.0, 20.0, 30.0}) {
    image::GrayImage image;
    renderer.Render(FaceAt(20.0, 4.0, 4.0, deg * kDegree), std::nullopt, image, 2);
    EXPECT_NEAR(Db(PeakOfMiddleLines(renderer.envelope())), Db(Fresnel(fat, muscle, deg * kDegree)),
                0.1)
        << deg << " degrees";
  }
}

TEST(BeamInterface, WhatIsReflectedIsMissingBehind) {
  const auto table = TableOf({{"liver", Scattering()}, {"plate", Clear(1540.0, 2.4)}});
  const auto labels = LabelledBlock(
      {60, 90, 60}, 0.5, {{1, "liver"}, {2, "plate"}},
      [](double, double y, double) -> volume::Label { return y > 10.0 && y < 15.0 ? 2 : 1; });
  BeamOptions options = Bare();
  options.speckle = options.point_spread = true;
  const auto behind = [&](bool interfaces) {
    options.interfaces = interfaces;
    BeamRenderer renderer({.labels = &labels, .acoustics = &table}, TargetProbe(), options);
    image::GrayImage image;
    renderer.Render(FaceAt(15.0, 0.5, 15.0), std::nullopt, image, 2);
    double sum = 0.0;
    for (int k = 200; k < 380; ++k) {
      sum += testing_support::MeanIntensity(renderer.envelope(), k, 10, 119);
    }
    return sum;
  };
  const double r = (2.4 - 1.6) / (2.4 + 1.6);
  // Two surfaces, each passed there and back: (1 - r^2)^2 in amplitude.
  EXPECT_NEAR(10.0 * std::log10(behind(true) / behind(false)), 2.0 * Db(1.0 - r * r), 0.1);
}

/// Sample of the largest echo of the middle line, behind `from`.
int EchoSample(const slicing::BeamImage& envelope, int from, int to) {
  const int line = envelope.lines() / 2;
  int best = from;
  for (int k = from; k < std::min(to, envelope.samples()); ++k) {
    if (envelope.row(k)[line] > envelope.row(best)[line]) best = k;
  }
  return best;
}

TEST(BeamTimeOfFlight, EchoesLieWhereTheirTimePutsThem) {
  for (const double speed : {1450.0, 1540.0, 1600.0}) {
    const auto table = TableOf({{"layer", Clear(speed, 1.4)}, {"muscle", Clear(1580.0, 1.70)}});
    const auto labels = TwoHalves("layer", "muscle");
    BeamOptions options = Bare();
    options.interfaces = options.point_spread = options.time_of_flight = true;
    BeamRenderer renderer({.labels = &labels, .acoustics = &table}, TargetProbe(), options);
    image::GrayImage image;
    renderer.Render(FaceAt(30.0, 1.0, 4.0), std::nullopt, image, 2);
    const double shown_mm = EchoSample(renderer.envelope(), 20, 400) * renderer.grid().step_mm;
    EXPECT_NEAR(shown_mm, 19.0 * 1540.0 / speed, renderer.grid().step_mm) << speed << " m/s";
  }
}

// Behind the interface a plane x = x0 parts scatterers from clear tissue. Where each line crosses
// it tells its direction.
TEST(BeamRefraction, LinesBendBySnell) {
  constexpr double kWallMm = 40.0;
  for (const double deg : {10.0, 20.0, 30.0}) {
    for (const double speed : {1450.0, 1700.0}) {
      acoustics::TissueAcoustics grey = Scattering();
      grey.speed_m_per_s = speed;
      grey.impedance_mrayl = 1.7;
      const auto table =
          TableOf({{"above", Clear()}, {"clear", Clear(speed, 1.7)}, {"grey", grey}});
      const auto labels =
          LabelledBlock({240, 240, 32}, 0.25, {{1, "above"}, {2, "clear"}, {3, "grey"}},
                        [](double x, double y, double) -> volume::Label {
                          if (y < 15.0) return 1;
                          return x < kWallMm ? 2 : 3;
                        });
      acoustics::Probe probe = TargetProbe();
      probe.samples_per_line = 1601;
      BeamOptions options = Bare();
      options.speckle = options.interfaces = options.angle = options.refraction = true;
      BeamRenderer renderer({.labels = &labels, .acoustics = &table}, probe, options);
      const Eigen::Isometry3d pose = FaceAt(26.0, 1.0, 4.0, deg * kDegree);
      image::GrayImage image;
      renderer.Render(pose, std::nullopt, image, 2);
      const slicing::BeamImage& envelope = renderer.envelope();
      double sum_rad = 0.0;
      int count = 0;
      for (int l = 20; l < envelope.lines(); ++l) {
        const Eigen::Vector2d start = renderer.grid().start_mm[static_cast<std::size_t>(l)];
        const Eigen::Vector3d face = pose * Eigen::Vector3d(start.x(), start.y(), 0.0);
        const double to_border_mm = (15.0 - face.y()) / std::cos(deg * kDegree);
        const double border_x = face.x() + to_border_mm * std::sin(deg * kDegree);
        int k = static_cast<int>((to_border_mm + 1.0) / renderer.grid().step_mm);
        while (k < envelope.samples() && envelope.row(k)[l] < 1e-6F) ++k;
        const double behind_mm = (k - 0.5) * renderer.grid().step_mm - to_border_mm;
        if (k == envelope.samples() || border_x > kWallMm - 3.0 || behind_mm < 8.0) continue;
        sum_rad += std::asin(std::clamp((kWallMm - border_x) / behind_mm, -1.0, 1.0));
        ++count;
      }
      ASSERT_GE(count, 5) << deg << " degrees into " << speed << " m/s";
      const double snell = std::asin(speed / 1540.0 * std::sin(deg * kDegree));
      EXPECT_NEAR(sum_rad / count / kDegree, snell / kDegree, 0.1)
          << deg << " degrees into " << speed << " m/s";
    }
  }
}

TEST(BeamReverberation, RepeatsAtMultiplesOfTheDepth) {
  const auto table = TableOf({{"liver", Clear()}, {"bone", Clear(4080.0, 7.8)}});
  const auto labels = LabelledBlock(
      {120, 180, 32}, 0.25, {{1, "liver"}, {2, "bone"}},
      [](double, double y, double) -> volume::Label { return y > 12.0 && y < 16.0 ? 2 : 1; });
  BeamOptions options = Bare();
  options.interfaces = options.shadow = options.point_spread = true;
  options.multiple_reflections = true;
  BeamRenderer renderer({.labels = &labels, .acoustics = &table}, TargetProbe(), options);
  image::GrayImage image;
  renderer.Render(FaceAt(15.0, 1.0, 4.0), std::nullopt, image, 2);
  const slicing::BeamImage& envelope = renderer.envelope();
  const int line = envelope.lines() / 2;
  const int first = EchoSample(envelope, 20, 140);
  const int second = EchoSample(envelope, 190, 250);
  const int third = EchoSample(envelope, 300, 360);
  EXPECT_NEAR(first, 110, 1);
  EXPECT_NEAR(second, 220, 1);
  EXPECT_NEAR(third, 330, 1);
  const double once = envelope.row(first)[line];
  EXPECT_GT(envelope.row(second)[line], 0.01 * once);
  // Each turn: once more at the plate, once at the face.
  const double r = (7.8 - 1.6) / (7.8 + 1.6);
  EXPECT_NEAR(Db(envelope.row(second)[line] / once), Db(r * options.face_reflection), 1.0);
}

}  // namespace
}  // namespace acus::ultrasound
