// What the beams lose on their way, against Beer and Lambert there and back.
#include <gtest/gtest.h>

#include "support/beam_targets.h"

namespace acus::ultrasound {
namespace {

using testing_support::Bare;
using testing_support::Clear;
using testing_support::FaceAt;
using testing_support::LabelledBlock;
using testing_support::Scattering;
using testing_support::TableOf;
using testing_support::TargetProbe;

/// Homogeneous tissue of 30 x 45 x 60 mm.
volume::LabelMap Homogeneous(const char* tissue) {
  return LabelledBlock({60, 90, 120}, 0.5, {{1, tissue}},
                       [](double, double, double) { return volume::Label{1}; });
}

/// dB per cm of depth that speckle falls, from the mean intensity over planes 1.5 mm apart.
double SlopeDbPerCm(const BeamTissue& tissue, const BeamOptions& options) {
  const acoustics::Probe probe = TargetProbe();
  BeamRenderer renderer(tissue, probe, options);
  std::vector<double> sum(static_cast<std::size_t>(probe.samples_per_line), 0.0);
  image::GrayImage image;
  for (double z_mm = 1.0; z_mm < 59.0; z_mm += 1.5) {
    renderer.Render(FaceAt(15.0, 0.5, z_mm), std::nullopt, image, 2);
    const slicing::BeamImage& envelope = renderer.envelope();
    for (int k = 0; k < envelope.samples(); ++k) {
      sum[static_cast<std::size_t>(k)] +=
          testing_support::MeanIntensity(envelope, k, 4, envelope.lines() - 4);
    }
  }
  std::vector<double> depth_cm;
  std::vector<double> db;
  for (int k = 30; k < 370; ++k) {
    depth_cm.push_back(0.1 * k * renderer.grid().step_mm);
    db.push_back(10.0 * std::log10(sum[static_cast<std::size_t>(k)]));
  }
  return testing_support::StraightLine(depth_cm, db).slope;
}

TEST(BeamAttenuation, SpeckleFallsByTwiceTheTable) {
  for (const double alpha : {0.3, 0.7, 1.2}) {
    acoustics::TissueAcoustics liver = Scattering();
    liver.attenuation_db_per_cm_mhz = liver.attenuation_along_fibres_db_per_cm_mhz = alpha;
    const auto table = TableOf({{"liver", liver}});
    const auto labels = Homogeneous("liver");
    BeamOptions options = Bare();
    options.speckle = options.point_spread = options.attenuation = true;
    const BeamTissue tissue{.labels = &labels, .acoustics = &table};
    const double slope = SlopeDbPerCm(tissue, options);
    options.attenuation = false;
    const double without = SlopeDbPerCm(tissue, options);
    const double expected = -2.0 * alpha * 5.0;
    // The same scatterers both times: what they do by chance falls out.
    EXPECT_NEAR((slope - without) / expected, 1.0, 0.01) << alpha;
    EXPECT_NEAR(without, 0.0, 0.1) << "brightness does not depend on depth otherwise";
  }
}

TEST(BeamAttenuation, MuscleLosesMoreAlongItsFibres) {
  acoustics::TissueAcoustics muscle = Scattering();
  muscle.attenuation_db_per_cm_mhz = 0.96;
  muscle.attenuation_along_fibres_db_per_cm_mhz = 1.40;
  const auto table = TableOf({{"muscle", muscle}});
  const auto labels = Homogeneous("muscle");
  BeamOptions options = Bare();
  options.speckle = options.attenuation = true;
  const auto slope = [&](const Eigen::Vector3d& fibres) {
    BeamTissue tissue{.labels = &labels, .acoustics = &table};
    tissue.fibres_in_ct["muscle"] = fibres;
    BeamOptions none = options;
    none.attenuation = false;
    return SlopeDbPerCm(tissue, options) - SlopeDbPerCm(tissue, none);
  };
  const double along = slope(Eigen::Vector3d::UnitY());
  const double across = slope(Eigen::Vector3d::UnitX());
  const double between = slope(Eigen::Vector3d(1.0, 1.0, 0.0));
  EXPECT_NEAR(along / (-2.0 * 1.40 * 5.0), 1.0, 0.01);
  EXPECT_NEAR(across / (-2.0 * 0.96 * 5.0), 1.0, 0.01);
  EXPECT_NEAR(between / (-2.0 * 1.18 * 5.0), 1.0, 0.01);
  EXPECT_NEAR(along / across, 1.40 / 0.96, 0.015);
}

/// Intensity behind a plate of 5 mm at 15 mm depth, over that without it, dB.
double BehindPlateDb(const acoustics::TissueAcoustics& plate, bool comet_tail) {
  const auto table = TableOf({{"liver", Scattering()}, {"plate", plate}});
  const auto labels = LabelledBlock(
      {60, 90, 30}, 0.5, {{1, "liver"}, {2, "plate"}},
      [](double, double y, double) -> volume::Label { return y > 15.0 && y < 20.0 ? 2 : 1; });
  const auto free = LabelledBlock({60, 90, 30}, 0.5, {{1, "liver"}},
                                  [](double, double, double) { return volume::Label{1}; });
  const auto behind = [&](const volume::LabelMap& map) {
    BeamOptions options;
    options.comet_tail = comet_tail;
    BeamRenderer renderer({.labels = &map, .acoustics = &table}, TargetProbe(), options);
    image::GrayImage image;
    renderer.Render(FaceAt(15.0, 0.5, 7.5), std::nullopt, image, 2);
    double sum = 0.0;
    for (int k = 300; k < 390; ++k) {
      sum += testing_support::MeanIntensity(renderer.envelope(), k, 10, 119);
    }
    return sum;
  };
  return 10.0 * std::log10(behind(labels) / behind(free));
}

TEST(BeamShadow, BoneAndGasTakeFortyDecibels) {
  acoustics::TissueAcoustics bone = Clear(4080.0, 7.8);
  bone.attenuation_db_per_cm_mhz = bone.attenuation_along_fibres_db_per_cm_mhz = 5.0;
  EXPECT_LT(BehindPlateDb(bone, true), -40.0);
  const acoustics::TissueAcoustics gas = Clear(343.0, 0.0004);
  EXPECT_LT(BehindPlateDb(gas, false), -40.0);
  EXPECT_LT(BehindPlateDb(gas, true), -40.0) << "where the comet's tail has tapered off";
  EXPECT_GT(BehindPlateDb(gas, true), BehindPlateDb(gas, false)) << "its comet's tail is seen";
  EXPECT_NEAR(BehindPlateDb(Clear(1540.0, 1.6), true), 0.0, 0.2) << "the same impedance";
}

}  // namespace
}  // namespace acus::ultrasound
