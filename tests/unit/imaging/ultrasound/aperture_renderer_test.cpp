#include "acus/imaging/ultrasound/aperture/aperture_renderer.h"

#include <cmath>
#include <gtest/gtest.h>
#include <vector>

#include "acus/imaging/ultrasound/aperture/aperture_tissue.h"
#include "support/beam_targets.h"

namespace acus::ultrasound {
namespace {

using testing_support::FaceAt;
using testing_support::LabelledBlock;
using testing_support::Scattering;
using testing_support::TableOf;
using testing_support::TargetProbe;

/// Muscle over liver: muscle has fibres.
class ApertureStreaks : public testing::Test {
 protected:
  volume::LabelMap labels_ = LabelledBlock(
      {60, 60, 30}, 1.0, {{1, "muscle"}, {2, "liver"}},
      [](double, double y, double) { return static_cast<volume::Label>(y < 24.0 ? 1 : 2); });
  acoustics::TissueAcousticsTable table_ =
      TableOf({{"muscle", Scattering()}, {"liver", Scattering()}});

  static constexpr int kLines = 150;  // Two blocks of lines and a part of one.

  /// By sample, then line.
  std::vector<float> Envelope(bool fibres, int num_threads) const {
    BeamTissue tissue{.labels = &labels_, .acoustics = &table_};
    tissue.fibres_in_ct["muscle"] = Eigen::Vector3d(1.0, 0.2, 0.1).normalized();
    acoustics::Probe probe = TargetProbe();
    probe.scan_lines = kLines;
    ApertureOptions options;
    options.fibre_texture = fibres;
    options.noise = options.clutter = options.ring_down = false;
    ApertureRenderer renderer(tissue, probe, options, 1);
    image::GrayImage image;
    renderer.Render(FaceAt(30.0, 4.0, 15.0), {}, image, num_threads);
    const slicing::BeamImage& envelope = renderer.envelope();
    std::vector<float> out;
    for (int k = 0; k < envelope.samples(); ++k) {
      out.insert(out.end(), envelope.row(k), envelope.row(k) + kLines);
    }
    return out;
  }
};

TEST_F(ApertureStreaks, AreInTissueWithFibresOnly) {
  const std::vector<float> with = Envelope(true, 1), without = Envelope(false, 1);
  double muscle_db2 = 0.0, largest_in_liver_db = 0.0;
  int count = 0;
  for (std::size_t n = 0; n < with.size(); ++n) {
    const double depth_mm = 0.1 * static_cast<double>(n / kLines);
    const double db = 20.0 * std::log10((with[n] + 1e-9) / (without[n] + 1e-9));
    if (depth_mm > 2.0 && depth_mm < 18.0) {  // Muscle ends at 20 mm.
      muscle_db2 += db * db;
      ++count;
    } else if (depth_mm > 22.0) {
      largest_in_liver_db = std::max(largest_in_liver_db, std::abs(db));
    }
  }
  EXPECT_GT(std::sqrt(muscle_db2 / count), 2.0);
  EXPECT_LT(largest_in_liver_db, 0.1);
}

TEST_F(ApertureStreaks, AreTheSameBitsWithAnyNumberOfThreads) {
  const std::vector<float> one = Envelope(true, 1);
  for (const int threads : {2, 3}) EXPECT_TRUE(one == Envelope(true, threads)) << threads;
}

// Several bytes per voxel, of which a replay on many threads needs no copy for each.
TEST_F(ApertureStreaks, RenderersOfOneSceneShareTheirTissue) {
  const BeamTissue tissue{.labels = &labels_, .acoustics = &table_};
  const acoustics::Probe probe = TargetProbe();
  ApertureOptions options;
  ApertureTissueStore store;
  const auto first = store.Get(tissue, probe, options, 1);
  acoustics::Probe louder = probe;
  louder.gain_db += 6.0;
  EXPECT_EQ(store.Get(tissue, louder, options, 1), first);
  ApertureOptions other = options;
  other.attenuation = !other.attenuation;
  EXPECT_NE(store.Get(tissue, probe, other, 1), first);
}

}  // namespace
}  // namespace acus::ultrasound
