// Where the patient's scan ends inside the image: no interface is drawn there, and nothing beyond.
#include <algorithm>
#include <filesystem>
#include <gtest/gtest.h>

#include "acus/imaging/ultrasound/aperture/aperture_renderer.h"
#include "acus/imaging/ultrasound/beams/beam_renderer.h"
#include "acus/imaging/ultrasound/columns/alamilla.h"
#include "acus/imaging/ultrasound/columns/bmode.h"
#include "acus/imaging/ultrasound/columns/vidal.h"
#include "support/synthetic_ct.h"

namespace acus::ultrasound {
namespace {

std::filesystem::path AcousticsFile(const char* name) {
  return std::filesystem::path(ACUS_SOURCE_DIR) / "configs/acoustics" / name;
}

/// Muscle of 60 HU, all of 80 x 60 x 40 mm, and the same as labels. The probe on top of it looks
/// down +y and is turned, so that lines leave through the bottom and through a side.
class ScanEnd : public testing::Test {
 protected:
  ScanEnd()
      : ct_(testing_support::SyntheticCt({80, 60, 40}, 1.0,
                                         [](double, double, double) { return 60.0; })),
        labels_(ct_.geometry),
        acoustics_(acoustics::ReadTissueAcoustics(AcousticsFile("tissues.json"))),
        probe_(acoustics::ReadProbe(std::filesystem::path(ACUS_SOURCE_DIR) /
                                    "configs/probes/curvilinear_c5_2.json")) {
    std::ranges::fill(labels_.voxels, volume::Label{1});
    labels_.names = {{1, "muscle"}};
    probe_.depth_mm = 120.0;
    ct_from_probe_ =
        Eigen::Translation3d(40.0, 0.0, 20.0) * Eigen::AngleAxisd(0.35, Eigen::Vector3d::UnitZ());
  }

  /// Largest grey of pixels whose tissue was scanned, at least `margin_mm` from its end, and of
  /// those beyond its end.
  struct Greys {
    int inside = 0;
    int at_the_end = 0;
    int beyond = 0;
  };
  template <typename Renderer>
  Greys GreysOf(Renderer& renderer) {
    constexpr double kMarginMm = 4.0;  // The reach of the beam across, at these depths.
    image::GrayImage image;
    renderer.Render(ct_from_probe_, {}, image);
    const Eigen::Affine3d index_from_ct = ct_.geometry.index_from_ct();
    Greys greys;
    for (int r = 0; r < image.height; ++r) {
      for (int c = 0; c < image.width; ++c) {
        const Eigen::Vector3d at =
            index_from_ct *
            (ct_from_probe_ * renderer.image().probe_from_image() * Eigen::Vector3d(c, r, 0.0));
        // Up to the faces that lines leave through.
        const double depth_mm = std::min({59.5 - at[1], 79.5 - at[0], at[0] + 0.5});
        if (at[1] < 8.0) continue;
        int& grey = depth_mm < -kMarginMm  ? greys.beyond
                    : depth_mm > kMarginMm ? greys.inside
                                           : greys.at_the_end;
        grey = std::max(grey, int{image.At(c, r)});
      }
    }
    return greys;
  }

  template <typename Renderer>
  void ExpectNothingBeyond(Renderer& renderer) {
    const Greys greys = GreysOf(renderer);
    EXPECT_GT(greys.inside, 40);
    EXPECT_LE(greys.at_the_end, greys.inside + 12);
    EXPECT_EQ(greys.beyond, 0);
  }

  volume::CtVolume ct_;
  volume::LabelMap labels_;
  acoustics::TissueAcousticsTable acoustics_;
  acoustics::Probe probe_;
  Eigen::Isometry3d ct_from_probe_;
};

TEST_F(ScanEnd, Columns2010) {
  probe_.pulse_length_mm = 1.0;
  probe_.gain_db = 14.0;
  BModeRenderer renderer(ct_, probe_, ReadBModeOptions(AcousticsFile("hu_textured.json")));
  ExpectNothingBeyond(renderer);
}

TEST_F(ScanEnd, Vidal2008) {
  VidalRenderer renderer(ct_, probe_, ReadVidalOptions(AcousticsFile("vidal_2008.json")));
  ExpectNothingBeyond(renderer);
}

TEST_F(ScanEnd, Alamilla2021) {
  AlamillaRenderer renderer(labels_, probe_,
                            ReadAlamillaOptions(AcousticsFile("alamilla_2021.json")));
  ExpectNothingBeyond(renderer);
}

TEST_F(ScanEnd, Beams) {
  const BeamTissue tissue{.labels = &labels_, .acoustics = &acoustics_};
  BeamRenderer renderer(tissue, probe_, {});
  ExpectNothingBeyond(renderer);
  const BeamTissue of_ct{.ct = &ct_, .acoustics = &acoustics_};
  BeamRenderer from_ct(of_ct, probe_, {});
  ExpectNothingBeyond(from_ct);
}

TEST_F(ScanEnd, ApertureButForNoiseAndClutter) {
  const BeamTissue tissue{.ct = &ct_, .labels = &labels_, .acoustics = &acoustics_};
  ApertureOptions options;
  options.noise = options.clutter = false;
  ApertureRenderer renderer(tissue, probe_, options);
  ExpectNothingBeyond(renderer);
}

}  // namespace
}  // namespace acus::ultrasound
